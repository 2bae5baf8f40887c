"""Settings in ROS 2 parameter files, read as the node reads them."""

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from .rcl_parameters import add_file, Nodes, parameters_of, RclError
from ..estimation.settings import DEFAULTS, PredictorSettings
from ..files import write_file
from ..model.exceptions import ArgumentError, BaxterDynamicsError

NODE = '/torque_predictor'
_LARGEST = 1 << 17  # [bytes]; a file with every setting has 3,000
_CHECKED = 1000  # unknown names to look for a misspelling in, which takes time
_DIGITS = 7  # significant digits written; more than any calibration can determine
_OF_ALL_NODES = ('use_sim_time', 'start_type_description_service')  # true or false
_EXPECTED = {bool: 'true or false', str: 'a string', int: 'an integer such as 2',
             float: 'a number with a decimal point such as 1.0',
             list: 'a list of numbers with decimal points such as [1.0, 2.0]'}


class ParameterFileError(BaxterDynamicsError):
    """A parameter file cannot be read, or the node would refuse its parameters."""


def read_parameters(paths: str | Path | Iterable[str | Path], node: str = NODE,
                    warn: Callable[[str], object] = lambda line: None) -> dict[str, Any]:
    """
    Return the settings of a node that is given parameter files, setting name to value.

    Later files override earlier ones. The node is named with its namespace; warn is called with a
    line about parameters that it would ignore. Raises ParameterFileError if a file cannot be read,
    or the node would refuse its parameters.
    """
    paths = [paths] if isinstance(paths, (str, Path)) else list(paths)
    nodes: Nodes = {}
    for path in paths:
        try:
            add_file(nodes, _contents(Path(path)))
        except OSError as error:
            raise ParameterFileError(f'{path}: cannot be read ({error.strerror})') from None
        except (RclError, yaml.YAMLError, ValueError, RecursionError) as error:
            raise ParameterFileError(f'{path}: {_reason(error)}') from None
    names = ', '.join(map(str, paths))
    given = parameters_of(nodes, '/' + node.strip('/'))
    if paths and not given:
        others = ', '.join(nodes) or 'no node'
        warn(f'{names}: no parameters for {node}, only for {others}: using the defaults')
    try:
        ignored = _ignored(given)
        values = {name: given[name] for name in DEFAULTS if name in given}
        PredictorSettings.from_parameters(values)
    except BaxterDynamicsError as error:
        raise ParameterFileError(f'{names}: {error}') from None
    if ignored:
        more = f' and {len(ignored) - 3} more' if len(ignored) > 3 else ''
        warn(f'{names}: ignoring {", ".join(ignored[:3])}{more}: not parameters of the predictor')
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
    head = ''.join(f'# {_printable(line)}'.rstrip() + '\n' for line in comments)
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
    if isinstance(error, RclError):
        return str(error)
    mark = getattr(error, 'problem_mark', None)
    where = f' at line {mark.line + 1}' if mark else ''
    problem = getattr(error, 'problem', None) or getattr(error, 'reason', type(error).__name__)
    return f'invalid YAML{where}: {problem}'


def _ignored(given: dict[str, Any]) -> list[str]:
    """Return the names that are no parameters of the node; refuse misspelt names, wrong types."""
    ignored: list[str] = []
    for name, value in given.items():
        if name in DEFAULTS or name in _OF_ALL_NODES:
            default = DEFAULTS.get(name, True)
            wanted: type = list if isinstance(default, tuple) else type(default)
            if type(value) is not wanted or (
                    isinstance(value, list) and type(value[0]) is not float):
                raise ArgumentError(name, f'expected {_EXPECTED[wanted]}, got {value!r:.40}')
        elif not name.startswith('qos_overrides.'):
            similar = len(ignored) < _CHECKED and get_close_matches(
                name, (*DEFAULTS, *_OF_ALL_NODES), 1, 0.75)
            if similar:
                raise ArgumentError(name, f'no such parameter; did you mean {similar[0]}?')
            ignored.append(name)
    return ignored


def _printable(text: str) -> str:
    """Return text with characters escaped that no YAML comment may have, such as line ends."""
    return ''.join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def _plain(value: Any) -> Any:
    """Return a value for YAML; numbers keep their decimal point, as ROS requires."""
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    return float(f'{value:.{_DIGITS}g}') if isinstance(value, float) else value
