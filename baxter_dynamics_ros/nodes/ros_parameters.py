"""ROS parameters declared from a table of settings, and rejected with a reason."""

from collections.abc import Iterable
from difflib import get_close_matches
import math
import time
from typing import Any

from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)
from rclpy.node import Node
from rclpy.parameter import Parameter

from .rclpy_internals import given_parameters
from ..model.exceptions import ArgumentError
from ..model.setting import Setting

# A change builds a model, which delays joint states by milliseconds.
_AT_ONCE, _PER_SECOND = 100.0, 20.0


class ParameterNode(Node):
    """
    Node whose parameters are declared from a table of settings.

    Subclasses override ``build`` and ``apply``. Each value is checked before rclpy sees it,
    because rclpy's reasons lack name or unit; then all values together.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.values: dict[str, Any] = {}  # parameter name -> current value; lists are tuples
        self._settings: dict[str, Setting] = {}
        self._accepted: Any = None  # what build() returned of the values accepted last
        self._allowed, self._asked = _AT_ONCE, 0.0  # changes, at monotonic time [s]

    def build(self, values: dict[str, Any]) -> Any:
        """Return the argument of ``apply``; raise ArgumentError for inconsistent values."""
        return values

    def apply(self, built: Any) -> None:
        """Use changed values, given as the result of ``build``."""

    def declare_settings(self, settings: Iterable[Setting]) -> Any:
        """Declare settings as parameters; return what ``build`` returns for their values."""
        given = given_parameters(self)
        for setting in settings:
            self._settings[setting.name] = setting
            self.values[setting.name] = setting.check_parameter(
                given.get(setting.name, setting.default))
            self.declare_parameter(setting.name, setting.default, _descriptor(setting))
        self._accepted = self.build(self.values)
        return self._accepted

    def accept_changes(self) -> None:
        """
        Accept parameter changes from now on; call this after declaring all parameters.

        Raises ArgumentError if a given name resembles a parameter of this node. Other unknown
        names are logged, as a parameter file may be shared with another node.
        """
        for name in given_parameters(self):
            if not self.has_parameter(name):
                if self._similar(name):
                    raise ArgumentError(name, f'no such parameter{self._similar(name)}')
                self.get_logger().warning(f'parameter {name} is given, but this node has none')
        self.add_on_set_parameters_callback(self._on_set)
        self.add_post_set_parameters_callback(self._on_post_set)

    def changed_settings(self) -> str:
        """Return the names of the settings that differ from their defaults."""
        return ', '.join(name for name, setting in self._settings.items()
                         if setting.check(self.values[name]) != setting.default) or 'none'

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set parameters as rclpy does, if they are valid by themselves and not too many."""
        try:
            for name in (parameter.name for parameter in parameter_list):
                if not self.has_parameter(name):
                    raise ArgumentError(name, f'no such parameter{self._similar(name)}')
            self._changed(parameter_list)
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        now = time.monotonic()
        self._allowed = min(_AT_ONCE, self._allowed + _PER_SECOND * (now - self._asked))
        self._asked = now
        if self._allowed < 1.0:
            return SetParametersResult(successful=False, reason=(
                f'too many changes: at most {_AT_ONCE:g} at once and {_PER_SECOND:g} per second; '
                'set_parameters_atomically sets several as one change'))
        self._allowed -= 1.0
        return super().set_parameters_atomically(parameter_list)

    def _on_set(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            self._accepted = self.build(self._changed(changes))
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_post_set(self, changes: list[Parameter]) -> None:
        self.values = self._changed(changes)
        self.apply(self._accepted)

    def _similar(self, name: str) -> str:
        """Return the question whether a similar parameter is meant; empty if there is none."""
        meant = get_close_matches(name, self.list_parameters([], 0).names, 1, 0.75)
        return f'; did you mean {meant[0]}?' if meant else ''

    def _changed(self, changes: list[Parameter]) -> dict[str, Any]:
        return {**self.values, **{
            parameter.name: self._settings[parameter.name].check_parameter(parameter.value)
            for parameter in changes if parameter.name in self._settings}}


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
