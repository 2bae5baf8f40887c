"""What the closed form is to reach, and whether it does."""

from dataclasses import dataclass

from .comparison import BATCH, GROWTH

LINEAR = 1.3  # a larger batch may take so much more a state than the smallest
# [bytes] a state that a larger batch may take beyond arguments and result, which have 224.
FLAT = 16.0


@dataclass(frozen=True)
class Target:
    """A bound on a ratio: less is better on one state, more is better on a batch."""

    text: str
    call: str
    bound: float
    engine: str  # whose ratio is judged
    checked: str = ''  # whose ratio is told beside it: the same as BaxterArm's user sees it


TARGETS = (
    # On one state, of the functions themselves: with arrays to make and to check, see beside it.
    Target('NumPy only, tau', 'tau', 6.0, 'ours, NumPy, bare', 'ours, NumPy'),
    Target('NumPy only, M, C qd and G', 'split', 11.0, 'ours, NumPy, bare', 'ours, NumPy'),
    Target('numba, tau', 'tau', 0.8, 'ours, numba, bare', 'ours, numba'),
    Target('exported C, tau', 'tau', 0.4, 'ours, exported C'),
    Target('NumPy only, batch', BATCH, 2.0, 'ours, NumPy, unchecked', 'ours, NumPy'),
    Target('numba, batch', BATCH, 5.0, 'ours, numba, unchecked', 'ours, numba'),
    Target('exported C, batch', BATCH, 35.0, 'ours, exported C'),
)


def verdicts(rows: list, batch: int) -> list:
    """
    Judge the rows of a comparison.

    Returns
    -------
    list of tuple
        Texts: target, bound, measured, the same by BaxterArm, verdict.

    """
    ratios = {(row.call, row.engine, row.size): row.ratio for row in rows}
    result = []
    for target in TARGETS:
        size = batch if target.call == BATCH else 1
        ratio, checked = (ratios.get((target.call, name, size))
                          for name in (target.engine, target.checked))
        if target.call == BATCH:
            bound = f'>= {target.bound:g} x the rate of rneaInParallel'
            verdict = '' if ratio is None else _word(ratio >= target.bound)
        else:
            bound = f'<= {target.bound:g} x the time of rnea'
            verdict = '' if ratio is None else _word(ratio <= target.bound)
        result.append((target.text, bound, _number(ratio, '.2f'), _number(checked, '.2f'),
                       verdict or 'not measured'))
    return result + _growth(rows)


def _growth(rows: list) -> list:
    """Judge whether time is linear in the number of states, and memory flat."""
    result = []
    growth = [row for row in rows if row.call == GROWTH]
    for name in dict.fromkeys(row.engine for row in growth):
        batches = [row for row in growth if row.engine == name]
        slower = max(row.ratio for row in batches)
        sizes = ', '.join(f'{row.size:,}' for row in batches)
        result.append((f'{name}: linear', f'<= {LINEAR:g} x the time a state, for {sizes} states',
                       f'{slower:.2f}', '', _word(slower <= LINEAR)))
        small, large = batches[-2:]
        if small.memory is not None:
            extra = (large.memory - small.memory) / (large.size - small.size)
            result.append((f'{name}: flat memory', f'<= {FLAT:g} bytes a state beyond arguments '
                           'and result', f'{extra:.1f}', '', _word(extra <= FLAT)))
    return result


def _word(reached: bool) -> str:
    return 'reached' if reached else 'NOT REACHED'


def _number(value, form: str) -> str:
    return '-' if value is None else format(value, form)
