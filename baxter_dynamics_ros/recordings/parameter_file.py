"""
Settings in ROS 2 parameter files, read as the node reads them.

rcl has scalar types of its own, knows neither aliases nor dates, and merges all files; see
``rcl_yaml_param_parser`` and rclpy's choice of a node's parameters (Jazzy).
"""

from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path
import re
from typing import Any, TypeAlias

import yaml

from ..estimation.settings import DEFAULTS, PredictorSettings, SETTINGS
from ..files import write_file
from ..model import ArgumentError, BaxterDynamicsError, first_names, printable, Setting
from ..model.setting import TYPE_WORDS

NODE = '/torque_predictor'
_LARGEST = 1 << 17  # [bytes]; a file with every setting has 3,000
_CHECKED = 1000  # unknown names to look for a misspelling in, which takes time
_DIGITS = 7  # significant digits written; more than any calibration can determine
_PARAMETERS = {setting.name: setting for setting in (
    *SETTINGS, Setting('use_sim_time', True, ''),
    Setting('start_type_description_service', True, ''))}

_KEY = 'ros__parameters'
_BOOLEANS = {**dict.fromkeys('Y y yes Yes YES true True TRUE on On ON'.split(), True),
             **dict.fromkeys('N n no No NO false False FALSE off Off OFF'.split(), False)}
# Accepted by strtol (base 0) and strtod in C; names of infinity and NaN in YAML, too.
_INTEGER = re.compile(r'\s*[+-]?((0[xX][0-9a-fA-F]+)|(0[0-7]*)|([1-9][0-9]*))', re.ASCII)
_BASES = (16, 8, 10)  # of the inner groups
_DECIMAL = re.compile(r'\s*[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|\.?inf|\.?nan)',
                      re.ASCII | re.IGNORECASE)
# rclpy takes the first type that is set: scalars before lists.
_TYPES = bool, int, float, str
_ORDER = *_TYPES, *((kind,) for kind in _TYPES)
_PART = re.compile(r'[A-Za-z_]\w*|\*\*?', re.ASCII)  # of a node's name

# Node name, as written -> parameter -> type -> value; for a list, a tuple with the elements' type.
_Nodes: TypeAlias = dict[str, dict[str, dict[Any, Any]]]


class ParameterFileError(BaxterDynamicsError):
    """A parameter file cannot be read, or the node would refuse its parameters."""


class _RclError(Exception):
    """rcl refuses the file; the arguments are the reason and the YAML node or event."""


def read_parameters(paths: str | Path | Iterable[str | Path], node: str = NODE,
                    warn: Callable[[str], object] = lambda line: None) -> dict[str, Any]:
    """
    Return the settings, name to value, of a node with its namespace that is given parameter files.

    Later files override earlier ones; warn is called with a line about parameters that the node
    would ignore. Raises ParameterFileError if it would refuse them, or a file cannot be read.
    """
    paths = [paths] if isinstance(paths, (str, Path)) else list(paths)
    nodes: _Nodes = {}
    for path in paths:
        try:
            _add_file(nodes, _contents(Path(path)))
        except OSError as error:
            raise ParameterFileError(f'{path}: cannot be read ({error.strerror})') from None
        except _RclError as error:
            reason, place = error.args
            raise ParameterFileError(
                f'{path}: {reason}, at line {place.start_mark.line + 1}') from None
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            raise ParameterFileError(f'{path}: invalid YAML{_reason(error)}') from None
    names = ', '.join(map(str, paths))
    given = _parameters_of(nodes, '/' + node.strip('/'))
    if paths and not given:
        warn(f'{names}: no parameters for {node}, only for '
             f'{first_names(sorted(nodes)) or "no node"}: using the defaults')
    try:
        ignored = _ignored(given)
        values = {name: given[name] for name in DEFAULTS if name in given}
        PredictorSettings.from_parameters(values)
    except BaxterDynamicsError as error:
        raise ParameterFileError(f'{names}: {error}') from None
    if ignored:
        warn(f'{names}: ignoring {first_names(sorted(ignored))}: not parameters of '
             'the predictor')
    return values


def write_parameters(path: str | Path, settings: PredictorSettings,
                     comments: Iterable[str] = ()) -> None:
    """Write the arm and the settings that differ from their defaults, below lines of comment."""
    tree: dict[str, Any] = {}
    for name, value in settings.parameters().items():
        if name == 'arm' or value != DEFAULTS[name]:
            *groups, leaf = name.split('.')
            place = tree
            for group in groups:
                place = place.setdefault(group, {})
            place[leaf] = _plain(value)
    head = ''.join(f'# {printable(line)}'.rstrip() + '\n' for line in comments)
    body = yaml.safe_dump({'/**': {'ros__parameters': tree}}, sort_keys=False, width=95,
                          default_flow_style=None)
    write_file(path, head + body)


def _contents(path: Path) -> bytes:
    size = path.stat().st_size
    if not path.is_file():
        raise ParameterFileError(f'{path}: is not a file')
    if size > _LARGEST:
        raise ParameterFileError(f'{path}: {size} bytes is too large for a parameter file; the '
                                 f'maximum is {_LARGEST}')
    return path.read_bytes()


def _reason(error: Exception) -> str:
    mark = getattr(error, 'problem_mark', None)
    problem = getattr(error, 'problem', None) or getattr(error, 'reason', type(error).__name__)
    return f' at line {mark.line + 1}: {problem}' if mark else f': {problem}'


def _ignored(given: dict[str, Any]) -> list[str]:
    """Return the names that are no parameters of the node; refuse misspelt names, wrong types."""
    ignored: list[str] = []
    for name, value in given.items():
        if name in _PARAMETERS:
            _PARAMETERS[name].check_parameter(value)
        elif not name.startswith('qos_overrides.'):
            similar = len(ignored) < _CHECKED and get_close_matches(name, _PARAMETERS, 1, 0.75)
            if similar:
                raise ArgumentError(name, f'no such parameter; did you mean {similar[0]}?')
            ignored.append(name)
    return ignored


def _plain(value: Any) -> Any:
    """Return a value for YAML; numbers keep their decimal point, as ROS requires."""
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    return float(f'{value:.{_DIGITS}g}') if isinstance(value, float) else value


class _Loader(getattr(yaml, 'CSafeLoader', yaml.SafeLoader)):  # type: ignore[misc]
    """YAML loader in which only an explicit tag makes a scalar a string."""

    DEFAULT_SCALAR_TAG = 'unknown'


def _add_file(nodes: _Nodes, text: bytes) -> None:
    """Add the contents of a file; raise _RclError where rcl would, and what yaml raises."""
    for event in yaml.parse(text, _Loader):
        if isinstance(event, yaml.AliasEvent):
            raise _RclError('aliases are not supported', event)
    for document in yaml.compose_all(text, _Loader):
        for name, tree in _nodes(document):
            parameters = nodes.setdefault(name, {})
            for parameter, value in _parameters(tree):
                kind = (*map(type, value[:1]),) if isinstance(value, list) else type(value)
                parameters.setdefault(parameter, {})[kind] = value


def _parameters_of(nodes: _Nodes, node: str) -> dict[str, Any]:
    """Return the parameters of a node with its namespace; None is an empty list."""
    values: dict[str, Any] = {}
    for name, parameters in nodes.items():
        # As in rclpy, each * matches one part of the name, ** any number of them.
        if re.fullmatch(f'/{name.removeprefix("/")}'.replace('/*', r'(/\w+)'), node):
            values.update({
                parameter: next((kinds[kind] for kind in _ORDER if kind in kinds), None)
                for parameter, kinds in parameters.items()})
    return values


def _items(tree: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(tree, yaml.MappingNode):
        raise _RclError('expected names with values', tree)
    for key, value in tree.value:
        if not isinstance(key, yaml.ScalarNode) or not key.value:
            raise _RclError('expected a name', key)
        yield key.value, value


def _nodes(tree: Any, prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield the name of each node and the mapping of its parameters."""
    for key, value in _items(tree):
        if key != _KEY:
            yield from _nodes(value, f'{prefix.rstrip("/")}/{key}' if prefix else key)
        elif all(map(_PART.fullmatch, prefix.removeprefix('/').split('/'))):
            yield prefix, value
        else:
            raise _RclError(f'{prefix!r} before {_KEY} is not a valid node name', value)


def _parameters(tree: Any, prefix: str = '') -> Iterator[tuple[str, Any]]:
    for key, value in _items(tree):
        if not isinstance(value, yaml.MappingNode):
            yield prefix + key, _value(value)
        elif value.value:
            yield from _parameters(value, f'{prefix}{key}.')
        else:
            raise _RclError(f'no parameters in {key}', value)


def _value(node: Any) -> Any:
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node)
    values = [_scalar(element) for element in node.value]
    for value, element in zip(values, node.value):
        if type(value) is not type(values[0]):
            raise _RclError(f'list of mixed types: expected {TYPE_WORDS[type(values[0])]}, got '
                            f'{element.value:.20}', element)
    return values


def _scalar(node: Any) -> bool | int | float | str:
    if not isinstance(node, yaml.ScalarNode):
        raise _RclError('a list in a list', node)
    text: str = node.value
    if node.style in ('"', "'") or node.tag == 'tag:yaml.org,2002:str':
        return text
    if not text:
        raise _RclError('missing value', node)
    if text in _BOOLEANS:
        return _BOOLEANS[text]
    integer = _INTEGER.fullmatch(text)
    if integer and len(text) < 40:  # longer ones are out of range
        value = int(text, next(b for b, digits in zip(_BASES, integer.groups()[1:]) if digits))
        if -2**63 <= value < 2**63:
            return value
    if _DECIMAL.fullmatch(text):
        return float(text.lower().replace('.i', 'i').replace('.n', 'n'))
    return text
