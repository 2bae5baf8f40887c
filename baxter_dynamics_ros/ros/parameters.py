"""The predictor's settings as ROS parameters: declared from their table, validated when set."""

from difflib import get_close_matches
import math

from rcl_interfaces.msg import FloatingPointRange
from rcl_interfaces.msg import ParameterDescriptor
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.exceptions import InvalidParameterValueException

from ..core.exceptions import ArgumentError
from ..signals.settings import PredictorSettings
from ..signals.settings import Setting
from ..signals.settings import SETTINGS


def declare(node) -> PredictorSettings:
    """
    Declare all settings as parameters of the node and return what they were given.

    Raises
    ------
    ArgumentError
        If a given value is refused, or a given name is no parameter of the node.

    """
    values = {}
    for setting in SETTINGS:
        default = setting.default
        try:
            parameter = node.declare_parameter(
                setting.name, list(default) if isinstance(default, tuple) else default,
                _descriptor(setting))
        except InvalidParameterTypeException:
            raise ArgumentError(setting.name, f'expected {_type(setting)}') from None
        except InvalidParameterValueException as error:
            raise ArgumentError(setting.name, str(error)) from None
        values[setting.name] = parameter.value
    return PredictorSettings(values).warm_up()


def refuse_misspelt(node):
    """
    Refuse parameters given to the node that are nearly the name of one of its own.

    Others that it does not have may be another node's, in a file for both: these are logged.

    Raises
    ------
    ArgumentError
        If there is a misspelt one.

    """
    known = node.list_parameters([], 0).names
    for name in getattr(node, '_parameter_overrides', {}):  # rclpy has no public way to ask
        if name not in known:
            meant = get_close_matches(name, known, 1, 0.75)
            if meant:
                raise ArgumentError(name, f'no such parameter; is {meant[0]} meant?')
            node.get_logger().warning(f'parameter {name} is given, but there is none')


def proposed(settings: PredictorSettings, parameters) -> PredictorSettings:
    """
    Return the settings as they would be with ``parameters`` set.

    Raises
    ------
    ArgumentError
        If a value is refused.

    """
    changes = {parameter.name: parameter.value for parameter in parameters
               if parameter.name in settings.values}
    return PredictorSettings({**settings.values, **changes}).warm_up()


def verdict(settings: PredictorSettings, parameters) -> SetParametersResult:
    """Say whether ``parameters`` may be set."""
    try:
        proposed(settings, parameters)
    except ArgumentError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def _descriptor(setting: Setting) -> ParameterDescriptor:
    unit = f' [{setting.unit}]' if setting.unit else ''
    descriptor = ParameterDescriptor(
        description=setting.description + unit, read_only=setting.read_only)
    constraints = []
    if setting.choices:
        constraints.append('one of ' + ', '.join(setting.choices))
    if isinstance(setting.default, tuple):
        constraints.append(f'{len(setting.default)} numbers')
    if math.isfinite(setting.lower):
        constraints.append(f'from {setting.lower:g} to {setting.upper:g}')
        if isinstance(setting.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=setting.lower, to_value=setting.upper)]
    descriptor.additional_constraints = ', '.join(constraints)
    return descriptor


def _type(setting: Setting) -> str:
    default = setting.default
    if isinstance(default, bool):
        return 'true or false'
    if isinstance(default, str):
        return 'one of ' + ', '.join(setting.choices)
    if isinstance(default, tuple):
        return f'a list of {len(default)} numbers with decimal points, such as [1.0, ...]'
    return 'a number with a decimal point, such as 1.0'
