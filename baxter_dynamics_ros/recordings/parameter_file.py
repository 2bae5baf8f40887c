"""Settings in ROS 2 parameter files: read as the node would, written for the node to read."""

from collections.abc import Iterable, Iterator
import os
from pathlib import Path
import tempfile
from typing import Any

import yaml

from ..estimation.settings import DEFAULTS, PredictorSettings
from ..model.exceptions import BaxterDynamicsError

NODE = 'torque_predictor'
_WILDCARDS = ('/**', '/*')
_DIGITS = 7  # that are written: more than any calibration knows


class ParameterFileError(BaxterDynamicsError):
    """A parameter file cannot be read or written, or does not fit."""


def read_parameters(path: str | Path) -> dict[str, Any]:
    """
    Return the predictor's settings in a parameter file, setting name to value.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    ParameterFileError
        If it cannot be read, has no settings, or one of them is unknown or refused.

    """
    try:
        values = _settings(yaml.safe_load(Path(path).read_text(encoding='utf-8')))
    except (OSError, UnicodeDecodeError, RecursionError, yaml.YAMLError) as error:
        reason = ' '.join(str(error).split())
        raise ParameterFileError(
            f'{path}: cannot be read as a parameter file ({reason})') from None
    if not values:
        raise ParameterFileError(f'{path}: no parameters of {NODE}; expected /**: or {NODE}:, '
                                 'below it ros__parameters:, and below that the settings')
    try:
        PredictorSettings(values)
    except BaxterDynamicsError as error:
        raise ParameterFileError(f'{path}: {error}') from None
    return values


def write_parameters(path: str | Path, values: dict[str, Any],
                     comments: Iterable[str] = ()) -> None:
    """
    Write settings that differ from the defaults, and the arm, into a parameter file.

    The file is there when it is complete, or not at all.

    Parameters
    ----------
    path : Path
        Where to; replaced if it is there.
    values : dict
        All settings.
    comments : sequence of str
        Lines for its head.

    Raises
    ------
    ParameterFileError
        If it cannot be written.

    """
    tree: dict[str, Any] = {}
    for name, default in DEFAULTS.items():
        if name == 'arm' or values[name] != default:
            *groups, leaf = name.split('.')
            place = tree
            for group in groups:
                place = place.setdefault(group, {})
            place[leaf] = _plain(values[name])
    head = ''.join(f'# {_printable(line)}'.rstrip() + '\n' for line in comments)
    body = yaml.safe_dump({'/**': {'ros__parameters': tree}}, sort_keys=False, width=95,
                          default_flow_style=None)
    path = Path(path)
    try:
        with tempfile.NamedTemporaryFile('w', encoding='utf-8', dir=path.parent, delete=False,
                                         prefix=f'.{path.name}.') as file:
            try:
                file.write(head + body)
                file.close()
                os.chmod(file.name, 0o644)
                os.replace(file.name, path)
            except BaseException:
                os.unlink(file.name)
                raise
    except OSError as error:
        raise ParameterFileError(f'{path}: cannot be written ({error.strerror})') from None


def _settings(content: object) -> dict[str, Any]:
    """Return what a file holds for the predictor, setting name to value."""
    values: dict[str, Any] = {}
    if isinstance(content, dict):
        for node, entry in content.items():
            name = str(node).rstrip('/').rpartition('/')[2]
            parameters = entry.get('ros__parameters') if isinstance(entry, dict) else None
            if (node in _WILDCARDS or name == NODE) and isinstance(parameters, dict):
                values.update(flat(parameters))
    return {name: value for name, value in values.items()
            if name != 'use_sim_time' and not name.startswith('qos_overrides.')}


def flat(tree: dict[str, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield dotted name and value of nested parameters."""
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f'{prefix}{name}.')
        else:
            yield f'{prefix}{name}', value


def _printable(text: str) -> str:
    """Return text with what no comment in YAML may hold, such as ends of lines, escaped."""
    return ''.join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def _plain(value: Any) -> Any:
    """Return a value as YAML has it; numbers keep their decimal point, as ROS insists."""
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    return float(f'{value:.{_DIGITS}g}') if isinstance(value, float) else value
