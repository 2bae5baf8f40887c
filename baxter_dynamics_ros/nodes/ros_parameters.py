"""The predictor's settings as ROS parameters: declared from their table, validated when set."""

from difflib import get_close_matches
import math
from typing import Any

from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..estimation.arms import BOTH, named_settings, per_arm
from ..estimation.settings import PredictorSettings, Setting, SETTINGS
from ..model.exceptions import ArgumentError
from ..model.joints import SIDES

NO_SUCH = 'no such parameter'


class Parameters:
    """
    The parameters' values, and what they say of each arm.

    Parameters
    ----------
    values : dict
        Parameter name to value.

    Attributes
    ----------
    settings : dict
        Side to :class:`PredictorSettings`, warmed up.

    Raises
    ------
    ArgumentError
        If a value is refused.

    """

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values
        # Changes, and the parameters with them.
        self._verdict_on: list[Parameter] | None = None
        self._next: Parameters | None = None
        self._named = named_settings(values['arm'])
        self.settings = per_arm(values)
        for settings in self.settings.values():
            settings.warm_up()

    @classmethod
    def declare(cls, node: Node) -> 'Parameters':
        """
        Declare all settings as parameters of the node and return what they were given.

        Raises
        ------
        ArgumentError
            If a given value is refused.

        """
        arm = next(setting for setting in SETTINGS if setting.name == 'arm')
        values = {'arm': _declare(node, 'arm', arm)}
        for name, setting in named_settings(values['arm']).items():
            if name != 'arm':
                values[name] = _declare(node, name, setting)
        for roll in (0.0, 0.1):
            PredictorSettings({'base.roll': roll}).warm_up()
        return cls(values)

    def proposed(self, changes: list[Parameter]) -> 'Parameters':
        """
        Return the parameters as they would be with ``changes``, ROS parameters, set.

        Raises
        ------
        ArgumentError
            If a value is refused.

        """
        # rclpy hands over the same list to both its callbacks.
        if self._next is not None and changes is self._verdict_on:
            return self._next
        return Parameters({**self._values, **{
            parameter.name: parameter.value for parameter in changes
            if parameter.name in self._values}})

    def refuse_other_types(self, changes: list[Parameter]) -> None:
        """
        Refuse ``changes``, ROS parameters, to another type: rclpy would not say which it refuses.

        Raises
        ------
        ArgumentError
            If one has another type than its setting.

        """
        for parameter in changes:
            setting = self._named.get(parameter.name)
            if setting and parameter.type_ is not Parameter.Type.from_parameter_value(
                    _value(setting)):
                raise ArgumentError(parameter.name, f'expected {_type(setting)}')

    def verdict(self, changes: list[Parameter]) -> SetParametersResult:
        """Say whether ``changes``, ROS parameters, may be set."""
        try:
            self._next = self.proposed(changes)
            self._verdict_on = changes
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)


def refuse_misspelt(node: Node) -> None:
    """
    Refuse parameters given to the node that are nearly the name of one of its own.

    Others that it does not have may be another node's, in a file for both: these are logged.

    Raises
    ------
    ArgumentError
        If there is a misspelt one.

    """
    for name in getattr(node, '_parameter_overrides', {}):  # rclpy has no public way to ask
        if not node.has_parameter(name):
            problem = no_such(node, name)
            if problem != NO_SUCH:
                raise ArgumentError(name, problem)
            node.get_logger().warning(f'parameter {name} is given, but there is none')


def no_such(node: Node, name: str) -> str:
    """Return what to say of a parameter that the node does not have."""
    known = node.list_parameters([], 0).names
    of_each = [f'{side}.{name}' for side in SIDES]
    meant = of_each if of_each[0] in known else get_close_matches(name, known, 1, 0.75)
    return f'{NO_SUCH}; is {" or ".join(meant)} meant?' if meant else NO_SUCH


def _declare(node: Node, name: str, setting: Setting) -> Any:
    try:
        value = node.declare_parameter(name, _value(setting), _descriptor(setting)).value
    except InvalidParameterTypeException:
        value = None
    except InvalidParameterValueException:
        raise ArgumentError(
            name, f'expected a value in [{setting.lower:g}, {setting.upper:g}]') from None
    if value is None:  # an empty list, too
        raise ArgumentError(name, f'expected {_type(setting)}')
    return value


def _value(setting: Setting) -> Any:
    default = setting.default
    return list(default) if isinstance(default, tuple) else default


def _descriptor(setting: Setting) -> ParameterDescriptor:
    unit = f' [{setting.unit}]' if setting.unit else ''
    descriptor = ParameterDescriptor(
        description=setting.description + unit, read_only=setting.read_only)
    constraints = []
    default = setting.default
    if setting.choices:
        constraints.append('one of ' + ', '.join(_choices(setting)))
    if isinstance(default, tuple):
        constraints.append(f'{len(default)} numbers')
    if math.isfinite(setting.lower):
        constraints.append(f'from {setting.lower:g} to {setting.upper:g}')
        if isinstance(default, int):
            descriptor.integer_range = [
                IntegerRange(from_value=setting.lower, to_value=setting.upper, step=1)]
        elif isinstance(default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=setting.lower, to_value=setting.upper)]
    descriptor.additional_constraints = ', '.join(constraints)
    return descriptor


def _type(setting: Setting) -> str:
    default = setting.default
    if isinstance(default, bool):
        return 'true or false'
    if isinstance(default, str):
        return 'one of ' + ', '.join(_choices(setting))
    if isinstance(default, int):
        return 'a whole number, such as 2'
    if isinstance(default, tuple):
        return f'a list of {len(default)} numbers with decimal points, such as [1.0, ...]'
    return 'a number with a decimal point, such as 1.0'


def _choices(setting: Setting) -> tuple[str, ...]:
    """Return what may be chosen: the node knows both arms, a stream one."""
    return (*setting.choices, BOTH) if setting.name == 'arm' else setting.choices
