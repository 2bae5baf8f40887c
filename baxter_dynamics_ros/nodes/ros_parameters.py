"""ROS parameters declared from a table of settings, and rejected with a reason."""

from collections.abc import Iterable
from difflib import get_close_matches
import math
import time
from typing import Any

from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter

from .rclpy_internals import given_parameters
from ..model import ArgumentError, BaxterDynamicsError, Setting

# A change builds a model, which delays joint states by milliseconds.
_AT_ONCE, _PER_SECOND = 100, 20


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
        self._next_change = -math.inf  # earliest monotonic time at the allowed rate [s]

    def create_publisher(self, *args: Any, **options: Any) -> Any:
        """Create a publisher without default event handlers: each costs time in every spin."""
        return super().create_publisher(*args, **{
            'event_callbacks': PublisherEventCallbacks(use_default_callbacks=False), **options})

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
        return self.build(self.values)

    def check_given_names(self) -> None:
        """
        Raise ArgumentError if a given name resembles a parameter of this node.

        Call this after declaring all parameters. Other unknown names are logged, as a parameter
        file may be shared with another node.
        """
        for name in given_parameters(self):
            if not self.has_parameter(name):
                if self._similar(name):
                    raise ArgumentError(name, f'no such parameter{self._similar(name)}')
                self.get_logger().warning(f'ignoring {name}: not a parameter of this node')

    def changed_settings(self) -> str:
        """Return the names of the settings that differ from their defaults, for a log line."""
        names = [name for name, setting in self._settings.items()
                 if self.values[name] != setting.default]
        return f'parameters that differ from their defaults: {", ".join(names) or "none"}'

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set parameters one by one, each as :meth:`set_parameters_atomically` does."""
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set parameters as rclpy does and apply them, if they are valid and not too many."""
        try:
            values = self._changed(parameter_list)
            self._limit_rate()
            built = self.build(values)
        except BaxterDynamicsError as error:
            return SetParametersResult(successful=False, reason=str(error))
        result = super().set_parameters_atomically(parameter_list)
        if result.successful:
            self.values = values
            self.apply(built)
        return result

    def _changed(self, changes: list[Parameter]) -> dict[str, Any]:
        """Return all values after changes."""
        values = dict(self.values)
        for name, value in ((change.name, change.value) for change in changes):
            if not self.has_parameter(name):
                raise ArgumentError(name, f'no such parameter{self._similar(name)}')
            if name in self._settings:
                values[name] = self._settings[name].check_parameter(value)
        return values

    def _limit_rate(self) -> None:
        now = time.monotonic()
        self._next_change = max(self._next_change, now - (_AT_ONCE - 1) / _PER_SECOND)
        if self._next_change > now:
            raise BaxterDynamicsError(
                f'too many changes: at most {_AT_ONCE} at once and {_PER_SECOND} per second; '
                'set_parameters_atomically sets several as one change')
        self._next_change += 1.0 / _PER_SECOND

    def _similar(self, name: str) -> str:
        """Return the question whether a similar parameter is meant; empty if there is none."""
        meant = get_close_matches(name, self.list_parameters([], 0).names, 1, 0.75)
        return f'; did you mean {meant[0]}?' if meant else ''


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
