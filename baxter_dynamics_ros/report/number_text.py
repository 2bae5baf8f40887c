"""Numbers as text."""

import math

NONE = '–'


def number(value: float, digits: int = 3) -> str:
    """Return a number with a number of decimals, or a dash if it is not finite."""
    if not math.isfinite(value):
        return NONE
    if value == 0.0:
        return '0'
    text = f'{value:.{digits}f}'
    return text.lstrip('-') if float(text) == 0.0 else text.replace('-', '−')


def torque(value: float) -> str:
    """Return a torque with its unit."""
    return f'{number(value, 2)}\u00a0N\u00a0m'


def decimals(deviation: float) -> int:
    """Return the number of significant decimals: two digits of the standard deviation."""
    if not 0.0 < deviation < math.inf:
        return 4
    return min(max(1 - math.floor(math.log10(deviation)), 0), 6)


def plus_minus(value: float, deviation: float) -> str:
    """Return a number with its standard deviation."""
    digits = decimals(deviation)
    return f'{number(value, digits)}\u00a0±\u00a0{number(deviation, digits)}'


def percent(share: float) -> str:
    """Return a share in percent."""
    return f'{100.0 * share:.0f}\u00a0%' if share >= 0.01 else 'less than 1\u00a0%'


def change(before: float, after: float) -> str:
    """Return a relative change in percent, or as a factor if it is above ten."""
    if not (before > 0.0 and math.isfinite(after)):
        return NONE
    if after > 10.0 * before:
        return f'×\u00a0{after / before:.0f}'
    percents = f'{100.0 * (after / before - 1.0):+.0f}'
    return ('0' if float(percents) == 0.0 else percents.replace('-', '−')) + '\u00a0%'


def duration(seconds: float) -> str:
    """Return a duration in seconds, or in minutes and seconds."""
    if seconds < 120.0:
        return f'{seconds:.1f} s'
    return f'{round(seconds) // 60} min {round(seconds) % 60} s'
