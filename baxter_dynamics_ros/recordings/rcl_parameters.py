"""
ROS 2 parameter files as rcl reads them: the same values and the same refusals.

rcl does not load YAML documents. It walks through the parser's events, keeps its own scalar
types, knows no aliases, tags or dates, and merges files into one list. This module follows
``rcl_yaml_param_parser`` and rclpy's choice of a node's parameters (Jazzy), oddities included.
"""

from collections.abc import Iterator
import re
from typing import Any

import yaml

_KEY = 'ros__parameters'
_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)  # libyaml, which rcl uses, if available
_TRUE = {'Y', 'y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON'}
_FALSE = {'N', 'n', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF'}
# What C's strtol (base 0) and strtod accept.
_INTEGER = re.compile(r'\s*([+-]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)', re.ASCII)
_DECIMAL = re.compile(r'\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?', re.ASCII)
_HEXADECIMAL = re.compile(r'\s*[+-]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)'
                          r'([pP][+-]?\d+)?', re.ASCII)
_SPECIAL = re.compile(r'\s*([+-]?)(inf|infinity|nan(?:\(\w*\))?)', re.ASCII | re.IGNORECASE)
_YAML_SPECIAL = {'.nan', '.NaN', '.NAN', '.inf', '.Inf', '.INF', '+.inf', '+.Inf', '+.INF',
                 '-.inf', '-.Inf', '-.INF'}
_TEXT_TAG = 'tag:yaml.org,2002:str'
_LEAST_NORMAL = 2.2250738585072014e-308
# rclpy takes the first that is set: scalars before lists, in this order.
_KINDS = (bool, int, float, str)
_PART = re.compile(r'[A-Za-z_]\w*|\*\*?', re.ASCII)  # of a node's name


class RclError(Exception):
    """rcl refuses the file; the message says why and at which line."""


class RclParameters:
    """
    Parameters of all nodes in one or more files, read in order.

    Attributes
    ----------
    nodes : dict
        Node name as written to its parameters: a list of [name, {kind: value}] in order, where a
        kind is a Python type, or a list's element type in a tuple.

    """

    def __init__(self) -> None:
        self.nodes: dict[str, list[tuple[str, dict[Any, Any]]]] = {}

    def read(self, text: bytes) -> None:
        """
        Add the contents of a file.

        Raises
        ------
        RclError
            If rcl would refuse it.

        """
        walk = _Walk(self.nodes)
        try:
            for event in yaml.parse(text, Loader=_LOADER):
                walk.take(event)
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            mark = getattr(error, 'problem_mark', None)
            problem = getattr(error, 'problem', None) or getattr(error, 'reason', None)
            where = f' at line {mark.line + 1}' if mark else ''
            raise RclError(f'invalid YAML{where}: {problem or type(error).__name__}') from None

    def of(self, node: str) -> dict[str, Any]:
        """Return the parameters of a node with its namespace; None is an empty list or mapping."""
        values: dict[str, Any] = {}
        for name, parameters in self.nodes.items():
            # As rclpy: each * matches one part of the name, ** any number of them.
            if re.fullmatch(f'/{name.removeprefix("/")}'.replace('/*', r'(/\w+)'), node):
                values.update({parameter: _first(kinds) for parameter, kinds in parameters})
        return values


class _Walk:
    """The state of rcl's walk through one file."""

    def __init__(self, nodes: dict[str, list[tuple[str, dict[Any, Any]]]]) -> None:
        self._nodes = nodes
        self._is_key, self._is_list, self._is_new = True, False, False
        self._kind: type | None = None  # of the list's elements
        self._depth = 0
        self._inside = False  # below ros__parameters
        self._node = _Path('/')
        self._group = _Path('.')
        self._parameters: list[tuple[str, dict[Any, Any]]] = []
        self._places: dict[str, int] = {}  # parameter name -> its first index
        self._place = 0

    def take(self, event: Any) -> None:
        """Take the next event of the YAML parser."""
        line = event.start_mark.line + 1
        if isinstance(event, yaml.ScalarEvent):
            (self._key if self._is_key else self._value)(event, line)
        elif isinstance(event, yaml.SequenceStartEvent):
            if self._is_key or not self._inside:
                raise RclError(f'a list stands for a name at line {line}')
            self._is_list, self._kind = True, None
        elif isinstance(event, yaml.SequenceEndEvent):
            self._is_list, self._is_key = False, True
        elif isinstance(event, yaml.MappingStartEvent):
            self._depth += 1
            self._is_key = True
            self._is_new = not (self._inside and self._depth - self._node.count - 1 == 2)
        elif isinstance(event, yaml.MappingEndEvent):
            self._end()
        elif isinstance(event, yaml.AliasEvent):
            raise RclError(f'aliases are not supported, at line {line}')

    def _end(self) -> None:
        if self._inside and self._group.count:
            self._group.pop()
        elif self._inside:
            self._inside = False
        elif self._depth == self._node.count + 1:
            self._node.pop()
        self._depth -= 1

    def _key(self, event: Any, line: int) -> None:
        name = event.value
        if not name:
            raise RclError(f'a name is missing at line {line}')
        if self._inside:
            self._parameter(name, line)
        elif name.startswith(_KEY):
            self._enter(line)
        else:
            self._node.push(name)
        self._is_key = False

    def _enter(self, line: int) -> None:
        if not self._node.count:
            raise RclError(f'no node name before {_KEY} at line {line}')
        parts = self._node.text.removeprefix('/').split('/')
        if not all(_PART.fullmatch(part) for part in parts):
            raise RclError(f'{self._node.text} is not the name of a node, at line {line}')
        self._parameters = self._nodes.setdefault(self._node.text, [])
        self._places = {}
        for i, (name, _) in enumerate(self._parameters):
            self._places.setdefault(name, i)
        self._node.pop()
        self._inside = True

    def _parameter(self, name: str, line: int) -> None:
        if self._is_new:
            if not self._parameters:
                raise RclError(f'unexpected mapping at line {line}')
            self._group.text = self._parameters[self._place][0]
            self._group.count += 1
            self._is_new = False
        group = self._group.text if self._group.count else None
        self._place = self._find(name if group is None else group)
        if group is not None:  # rcl renames the entry that stood for the group
            if self._places[group] == self._place:
                del self._places[group]
            full = f'{group}.{name}'
            self._parameters[self._place] = full, self._parameters[self._place][1]
            self._places.setdefault(full, self._place)

    def _find(self, name: str) -> int:
        place = self._places.setdefault(name, len(self._parameters))
        if place == len(self._parameters):
            self._parameters.append((name, {}))
        return place

    def _value(self, event: Any, line: int) -> None:
        if not self._inside or not self._parameters:
            raise RclError(f'a value before {_KEY} at line {line}')
        plain = event.style not in ('"', "'")
        if plain and not event.value:
            raise RclError(f'a value is missing at line {line}')
        value = event.value if not plain or event.tag == _TEXT_TAG else _scalar(event.value)
        kinds = self._parameters[self._place][1]
        if not self._is_list:
            kinds[type(value)] = value
            self._is_key = True
            return
        if self._kind is None:
            self._kind = type(value)
            kinds[self._kind,] = []
        elif self._kind is not type(value):
            raise RclError(f'list of mixed types at line {line}: {event.value:.20} is not '
                           f'{_NOUNS[self._kind]}')
        kinds[self._kind,].append(value)


_NOUNS = {bool: 'true or false', int: 'an integer', float: 'a number with a decimal point',
          str: 'a text'}


class _Path:
    """A name that grows and shrinks by parts, as rcl's namespaces do."""

    def __init__(self, separator: str) -> None:
        self.text, self.count, self._separator = '', 0, separator

    def push(self, name: str) -> None:
        joint = '' if not self.count or self.text.endswith(self._separator) else self._separator
        self.text = f'{self.text}{joint}{name}' if self.count else name
        self.count += 1

    def pop(self) -> None:
        if self.count > 1:
            self.text = self.text.rpartition(self._separator)[0] or self.text
        self.count = max(self.count - 1, 0)


def _first(kinds: dict[Any, Any]) -> Any:
    for kind in (*_KINDS, *((kind,) for kind in _KINDS)):
        if kind in kinds:
            return kinds[kind]
    return None


def _scalar(text: str) -> bool | int | float | str:
    """Return the value of an unquoted scalar."""
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    integer = _INTEGER.fullmatch(text)
    if integer and len(text) < 40:  # longer ones are out of range
        sign, digits = integer.groups()
        base = 16 if digits[:2] in ('0x', '0X') else 8 if digits[0] == '0' else 10
        value = int(sign + digits, base)
        if -2**63 <= value < 2**63:
            return value
    return next(_numbers(text), text)


def _numbers(text: str) -> Iterator[float]:
    """Yield the number that strtod makes of a text, unless it is none or out of range."""
    if text in _YAML_SPECIAL:
        text = text.replace('.', '')
    special = _SPECIAL.fullmatch(text)
    if special:
        yield float(special[1] + special[2][:3])
    elif _DECIMAL.fullmatch(text) or _HEXADECIMAL.fullmatch(text):
        try:
            value = float.fromhex(text) if 'x' in text.lower() else float(text)
        except OverflowError:
            return
        zero = not re.search('[1-9a-fA-F]', re.split('[eEpP]', text.lower().replace('0x', ''))[0])
        if value == 0.0 and zero or _LEAST_NORMAL <= abs(value) < float('inf'):
            yield value
