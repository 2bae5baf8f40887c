"""
ROS 2 parameter files as rcl reads them: the same values and the same refusals.

rcl has scalar types of its own, knows neither aliases nor dates, and merges all files; see
``rcl_yaml_param_parser`` and rclpy's choice of a node's parameters (Jazzy).
"""

from collections.abc import Iterator
import re
from typing import Any, TypeAlias

import yaml

_KEY = 'ros__parameters'
_PLAIN = 'plain'  # tag of unquoted scalars
_BOOLEANS = {**dict.fromkeys('Y y yes Yes YES true True TRUE on On ON'.split(), True),
             **dict.fromkeys('N n no No NO false False FALSE off Off OFF'.split(), False)}
# Accepted by strtol (base 0) and strtod in C; names of infinity and NaN in YAML, too.
_INTEGER = re.compile(r'\s*[+-]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)', re.ASCII)
_DECIMAL = re.compile(r'\s*[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|\.?inf|\.?nan)',
                      re.ASCII | re.IGNORECASE)
# rclpy takes the first type that is set: scalars before lists, in this order.
_KINDS = {bool: 'true or false', int: 'an integer', float: 'a number with a decimal point',
          str: 'a string'}
_ORDER = *_KINDS, *((kind,) for kind in _KINDS)
_PART = re.compile(r'[A-Za-z_]\w*|\*\*?', re.ASCII)  # of a node's name

# Node name, as written -> parameter -> type -> value; for a list, a tuple with the elements' type.
Nodes: TypeAlias = dict[str, dict[str, dict[Any, Any]]]


class RclError(Exception):
    """rcl refuses the file; the message gives reason and line."""

    def __init__(self, reason: str, node: Any) -> None:
        super().__init__(f'{reason}, at line {node.start_mark.line + 1}')


class _Loader(getattr(yaml, 'CSafeLoader', yaml.SafeLoader)):  # type: ignore[misc]
    """YAML loader that leaves the type of unquoted scalars open."""

    def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
        if kind is yaml.ScalarNode and implicit[0]:
            return _PLAIN
        return super().resolve(kind, value, implicit)


def add_file(nodes: Nodes, text: bytes) -> None:
    """
    Add the contents of a file to those of the files before it.

    Raises RclError where rcl would, and what yaml raises if it is not YAML.
    """
    for event in yaml.parse(text, _Loader):
        if isinstance(event, yaml.AliasEvent):
            raise RclError('aliases are not supported', event)
    for document in yaml.compose_all(text, _Loader):
        for name, tree in _nodes(document):
            parameters = nodes.setdefault(name, {})
            for parameter, value in _parameters(tree):
                kind = (*map(type, value[:1]),) if isinstance(value, list) else type(value)
                parameters.setdefault(parameter, {})[kind] = value


def parameters_of(nodes: Nodes, node: str) -> dict[str, Any]:
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
        raise RclError('expected names with values', tree)
    for key, value in tree.value:
        if not isinstance(key, yaml.ScalarNode) or not key.value:
            raise RclError('expected a name', key)
        yield key.value, value


def _nodes(tree: Any, prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield the name of each node and the mapping of its parameters."""
    for key, value in _items(tree):
        if key != _KEY:
            yield from _nodes(value, f'{prefix.rstrip("/")}/{key}' if prefix else key)
        elif all(map(_PART.fullmatch, prefix.removeprefix('/').split('/'))):
            yield prefix, value
        else:
            raise RclError(f'{prefix!r} before {_KEY} is not a valid node name', value)


def _parameters(tree: Any, prefix: str = '') -> Iterator[tuple[str, Any]]:
    for key, value in _items(tree):
        if not isinstance(value, yaml.MappingNode):
            yield prefix + key, _value(value)
        elif value.value:
            yield from _parameters(value, f'{prefix}{key}.')
        else:
            raise RclError(f'no parameters in {key}', value)


def _value(node: Any) -> Any:
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node)
    values = [_scalar(element) for element in node.value]
    for value, element in zip(values, node.value):
        if type(value) is not type(values[0]):
            raise RclError(f'list of mixed types: {element.value:.20} is not '
                           f'{_KINDS[type(values[0])]}', element)
    return values


def _scalar(node: Any) -> bool | int | float | str:
    if not isinstance(node, yaml.ScalarNode):
        raise RclError('a list in a list', node)
    text: str = node.value
    if node.style in ('"', "'") or node.tag == 'tag:yaml.org,2002:str':
        return text
    if not text:
        raise RclError('missing value', node)
    if text in _BOOLEANS:
        return _BOOLEANS[text]
    if _INTEGER.fullmatch(text) and len(text) < 40:  # longer ones are out of range
        digits = text.strip().lstrip('+-')
        base = 16 if digits[:2] in ('0x', '0X') else 8 if digits[0] == '0' else 10
        value = int(text, base)
        if -2**63 <= value < 2**63:
            return value
    if _DECIMAL.fullmatch(text):
        return float(text.lower().replace('.i', 'i').replace('.n', 'n'))
    return text
