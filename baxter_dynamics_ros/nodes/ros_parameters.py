"""ROS parameters declared from a table of settings, and rejected with a reason."""

from collections.abc import Iterable
from difflib import get_close_matches
import math
import time
from typing import Any

from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from .rclpy_internals import given_parameters
from ..estimation.setting import Setting
from ..model.exceptions import ArgumentError

NO_SUCH = 'no such parameter'
# A change builds a model, which delays joint states: changes allowed at once, and per second.
_CHANGES = 100.0
_CHANGES_PER_SECOND = 20.0
_TYPES = {bool: 'true or false', int: 'a whole number, such as 2',
          float: 'a number with a decimal point, such as 1.0'}


class ParameterNode(Node):
    """
    Node whose parameters are declared from a table of settings.

    Subclasses override ``build`` and ``apply``. All values are validated together, at the start
    and whenever some are set; a rejection names the parameter and the reason.

    Attributes
    ----------
    values : dict
        Parameter name to current value; lists are tuples.

    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.values: dict[str, Any] = {}
        self._settings: dict[str, Setting] = {}
        self._allowed, self._asked_at = _CHANGES, time.monotonic()
        self._accepted: Any = None  # what build() returned of the values accepted last

    def build(self, values: dict[str, Any]) -> Any:
        """Return the argument of ``apply``; raise ArgumentError for inconsistent values."""
        return values

    def apply(self, built: Any) -> None:
        """Use changed values, given as the result of ``build``."""

    def declare_settings(self, settings: Iterable[Setting]) -> Any:
        """
        Declare settings as parameters and return the result of ``build`` for their values.

        Raises
        ------
        ArgumentError
            If a given value is invalid.

        """
        for setting in settings:
            self._settings[setting.name] = setting
            self.values[setting.name] = _declare(self, setting)
        self._accepted = self.build(self.values)
        return self._accepted

    def accept_changes(self) -> None:
        """
        Accept parameter changes from now on; call this after declaring all parameters.

        Raises
        ------
        ArgumentError
            If a given name resembles a parameter of this node. Other unknown names are logged, as
            a parameter file may be shared with another node.

        """
        for name in given_parameters(self):
            if not self.has_parameter(name):
                problem = self._no_such(name)
                if problem != NO_SUCH:
                    raise ArgumentError(name, problem)
                self.get_logger().warning(f'parameter {name} is given, but this node has none')
        self.add_on_set_parameters_callback(self._on_set)
        self.add_post_set_parameters_callback(self._on_post_set)

    def changed_settings(self) -> str:
        """Return the names of the settings that differ from their defaults."""
        return ', '.join(name for name, setting in self._settings.items()
                         if setting.check(self.values[name]) != setting.default) or 'none'

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set parameters as rclpy does, but name the parameter that is refused and the reason."""
        try:
            for parameter in parameter_list:
                self._refuse(parameter)
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if not self._has_allowance():
            return SetParametersResult(successful=False, reason=(
                f'too many changes: at most {_CHANGES:g} at once and {_CHANGES_PER_SECOND:g} per '
                'second; set_parameters_atomically sets several as one change'))
        return super().set_parameters_atomically(parameter_list)

    def _has_allowance(self) -> bool:
        """Return whether another change is allowed now, and deduct it."""
        now = time.monotonic()
        earned = _CHANGES_PER_SECOND * (now - self._asked_at)
        self._allowed = min(_CHANGES, self._allowed + earned)
        self._asked_at = now
        if self._allowed < 1.0:
            return False
        self._allowed -= 1.0
        return True

    def _refuse(self, parameter: Parameter) -> None:
        """Raise ArgumentError if a parameter cannot be set, or not to this value."""
        if not self.has_parameter(parameter.name):
            raise ArgumentError(parameter.name, self._no_such(parameter.name))
        setting = self._settings.get(parameter.name)
        if setting is None:
            return
        if setting.read_only:
            raise ArgumentError(setting.name, 'is fixed when the node starts')
        if parameter.type_ is not Parameter.Type.from_parameter_value(_value(setting)):
            raise _wrong_type(setting, parameter.value)
        setting.check(parameter.value)

    def _on_set(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            self._accepted = self.build(self._changed(changes))
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_post_set(self, changes: list[Parameter]) -> None:
        self.values = self._changed(changes)
        self.apply(self._accepted)

    def _changed(self, changes: list[Parameter]) -> dict[str, Any]:
        return {**self.values, **{
            parameter.name: self._settings[parameter.name].check(parameter.value)
            for parameter in changes if parameter.name in self._settings}}

    def _no_such(self, name: str) -> str:
        meant = get_close_matches(name, self.list_parameters([], 0).names, 1, 0.75)
        return f'{NO_SUCH}; did you mean {meant[0]}?' if meant else NO_SUCH


def _declare(node: Node, setting: Setting) -> Any:
    given = given_parameters(node).get(setting.name)
    try:
        value = node.declare_parameter(
            setting.name, _value(setting), _descriptor(setting)).value
    except InvalidParameterTypeException:
        raise _wrong_type(setting, given) from None
    except InvalidParameterValueException:
        value = given  # rejected by the check below, which names range and unit
    if value is None:  # an empty list, too
        raise _wrong_type(setting, 'nothing')
    return setting.check(value)


def _wrong_type(setting: Setting, value: Any) -> ArgumentError:
    default = setting.default
    if isinstance(default, tuple):
        wanted = f'a list of {len(default)} numbers with decimal points, such as [1.0, ...]'
    elif isinstance(default, str):
        wanted = f'one of {", ".join(setting.choices)}' if setting.choices else 'text'
    else:
        wanted = _TYPES[type(default)]
    shown = value if isinstance(value, str) else repr(value)
    return ArgumentError(setting.name, f'expected {wanted}, got {shown:.80}')


def _value(setting: Setting) -> Any:
    default = setting.default
    return list(default) if isinstance(default, tuple) else default


def _descriptor(setting: Setting) -> ParameterDescriptor:
    default, unit = setting.default, f' [{setting.unit}]' if setting.unit else ''
    descriptor = ParameterDescriptor(
        description=setting.description + unit, read_only=setting.read_only)
    constraints = []
    if setting.choices:
        constraints.append('one of ' + ', '.join(setting.choices))
    if isinstance(default, tuple):
        constraints.append(f'{len(default)} numbers')
    if math.isfinite(setting.lower):
        constraints.append(f'from {setting.lower:g} to {setting.upper:g}')
        limits = {'from_value': setting.lower, 'to_value': setting.upper}
        if isinstance(default, int):
            descriptor.integer_range = [IntegerRange(**limits, step=1)]
        elif isinstance(default, float):
            descriptor.floating_point_range = [FloatingPointRange(**limits)]
    descriptor.additional_constraints = ', '.join(constraints)
    return descriptor
