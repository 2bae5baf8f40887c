"""One arm or both: which settings each arm has of its own, and the names they bear then."""

from collections.abc import Mapping
from typing import Any

from .settings import DEFAULTS, PredictorSettings, Setting, SETTINGS
from ..model.exceptions import ArgumentError
from ..model.joints import SIDES

BOTH = 'both'
_OWN = ('effort_model.', 'payload.', 'links.')  # what belongs to one arm, not to the robot


def sides(arm: str) -> tuple[str, ...]:
    """
    Return the sides that the setting ``arm`` means.

    Raises
    ------
    ArgumentError
        If it is none of right, left and both.

    """
    if arm == BOTH:
        return SIDES
    if arm not in SIDES:
        raise ArgumentError('arm', f'expected one of {", ".join(SIDES)}, {BOTH}, got {arm!r}')
    return (arm,)


def named_settings(arm: str) -> dict[str, Setting]:
    """
    Return all settings by the names they bear where the setting ``arm`` is as given.

    Those that belong to one arm are there twice for both, as ``right.payload.mass`` and
    ``left.payload.mass``.

    Returns
    -------
    dict
        Name to :class:`Setting`.

    Raises
    ------
    ArgumentError
        As :func:`sides`.

    """
    sides(arm)
    named = {}
    for setting in SETTINGS:
        for name in _names(setting, arm):
            named[name] = setting
    return named


def per_arm(values: Mapping[str, Any]) -> dict[str, PredictorSettings]:
    """
    Return the settings of each arm that ``values``, by their names, are for.

    Returns
    -------
    dict
        Side to :class:`PredictorSettings`.

    Raises
    ------
    ArgumentError
        If a name is unknown or a value is refused; names the setting by the name it bears.

    """
    arm = values.get('arm', DEFAULTS['arm'])
    known = named_settings(arm)
    for name in values:
        if name not in known:
            hint = f'; with arm {BOTH} say {SIDES[0]}.{name} or {SIDES[1]}.{name}'
            raise ArgumentError(name, 'unknown setting' + (
                hint if name in DEFAULTS else f'; known are {", ".join(known)}'))
    return {side: _of(side, arm, values) for side in sides(arm)}


def _names(setting: Setting, arm: str) -> list[str]:
    own = arm == BOTH and setting.name.startswith(_OWN)
    return [f'{side}.{setting.name}' for side in SIDES] if own else [setting.name]


def _of(side: str, arm: str, values: Mapping[str, Any]) -> PredictorSettings:
    prefix = f'{side}.'
    own = {}
    for setting in SETTINGS:
        for name in _names(setting, arm):
            if name in values and (name == setting.name or name.startswith(prefix)):
                own[setting.name] = values[name]
    try:
        return PredictorSettings({**own, 'arm': side})
    except ArgumentError as error:
        if arm == BOTH and error.argument.startswith(_OWN):
            raise ArgumentError(prefix + error.argument, error.problem) from None
        raise
