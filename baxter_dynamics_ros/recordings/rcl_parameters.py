"""
ROS 2 parameter files as rcl reads them: the same values and the same refusals.

rcl does not load YAML documents. It walks through the parser's events, has its own scalar types,
knows no aliases, tags or dates, and merges files into one list. This module follows
``rcl_yaml_param_parser`` and rclpy's choice of a node's parameters (Jazzy), including oddities.
"""

import re
from typing import Any, TypeAlias

import yaml

# In order, name and values by type; the type of a list is a tuple with that of its elements.
Parameters: TypeAlias = list[tuple[str, dict[Any, Any]]]

_KEY = 'ros__parameters'
_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)  # libyaml, which rcl uses, if available
_BOOLEANS = {**dict.fromkeys('Y y yes Yes YES true True TRUE on On ON'.split(), True),
             **dict.fromkeys('N n no No NO false False FALSE off Off OFF'.split(), False)}
# Accepted by strtol (base 0) and strtod in C; names of infinity and NaN in YAML, too.
_INTEGER = re.compile(r'\s*([+-]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)', re.ASCII)
_DECIMAL = re.compile(r'\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?', re.ASCII)
_HEXADECIMAL = re.compile(r'\s*[+-]?0x([\da-f]+\.?[\da-f]*|\.[\da-f]+)(p[+-]?\d+)?',
                          re.ASCII | re.IGNORECASE)
_SPECIAL = re.compile(r'\s*([+-]?)(inf|nan)(?:(?<=f)inity|(?<=n)\(\w*\))?',
                      re.ASCII | re.IGNORECASE)
_YAML_SPECIAL = re.compile(r'([+-]?)\.(inf|Inf|INF)|()\.(nan|NaN|NAN)')
_ZERO = re.compile(r'\s*[+-]?(0x)?[0.]+([ep].*)?', re.IGNORECASE)
_LEAST_NORMAL = 2.2250738585072014e-308
_TEXT_TAG = 'tag:yaml.org,2002:str'
# rclpy takes the first that is set: scalars before lists, in this order.
_KINDS = {bool: 'true or false', int: 'an integer', float: 'a number with a decimal point',
          str: 'a string'}
_PART = re.compile(r'[A-Za-z_]\w*|\*\*?', re.ASCII)  # of a node's name


class RclError(Exception):
    """rcl refuses the file; the message gives reason and line."""


class RclParameters:
    """
    Parameters of all nodes in one or more files, read in order.

    Attributes
    ----------
    nodes : dict
        Node name, as written, to its parameters.

    """

    def __init__(self) -> None:
        self.nodes: dict[str, Parameters] = {}

    def read(self, text: bytes) -> None:
        """Add the contents of a file; raise RclError if rcl would refuse it."""
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
            # As in rclpy, each * matches one part of the name, ** any number of them.
            if re.fullmatch(f'/{name.removeprefix("/")}'.replace('/*', r'(/\w+)'), node):
                values.update({parameter: next((kinds[kind] for kind in (
                    *_KINDS, *((kind,) for kind in _KINDS)) if kind in kinds), None)
                    for parameter, kinds in parameters})
        return values


class _Walk:
    """State of rcl's walk through one file."""

    def __init__(self, nodes: dict[str, Parameters]) -> None:
        self._nodes = nodes
        self._is_key, self._is_list, self._is_new_group = True, False, False
        self._kind: type | None = None  # of the list's elements
        self._depth = 0
        self._inside = False  # below ros__parameters
        self._node, self._group = _Path('/'), _Path('.')
        self._parameters: Parameters = []
        self._places: dict[str, int] = {}  # parameter name -> its first index
        self._place = 0

    def take(self, event: Any) -> None:
        """Take the next event of the YAML parser."""
        line = event.start_mark.line + 1
        if isinstance(event, yaml.ScalarEvent):
            (self._key if self._is_key else self._value)(event, line)
        elif isinstance(event, yaml.SequenceStartEvent):
            if self._is_key or not self._inside:
                raise RclError(f'expected a name at line {line}, got a list')
            self._is_list, self._kind = True, None
        elif isinstance(event, yaml.SequenceEndEvent):
            self._is_list, self._is_key = False, True
        elif isinstance(event, yaml.MappingStartEvent):
            self._depth += 1
            self._is_key = True
            self._is_new_group = not (self._inside and self._depth - self._node.count - 1 == 2)
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
        if not event.value:
            raise RclError(f'missing name at line {line}')
        if self._inside:
            self._parameter(event.value, line)
        elif event.value.startswith(_KEY):
            self._enter(line)
        else:
            self._node.push(event.value)
        self._is_key = False

    def _enter(self, line: int) -> None:
        name = self._node.text
        if not self._node.count:
            raise RclError(f'no node name before {_KEY} at line {line}')
        if not all(map(_PART.fullmatch, name.removeprefix('/').split('/'))):
            raise RclError(f'{name} is not a valid node name, at line {line}')
        self._parameters = self._nodes.setdefault(name, [])
        self._places = {}
        for i, (parameter, _) in enumerate(self._parameters):
            self._places.setdefault(parameter, i)
        self._node.pop()
        self._inside = True

    def _parameter(self, name: str, line: int) -> None:
        if self._is_new_group:
            if not self._parameters:
                raise RclError(f'unexpected mapping at line {line}')
            self._group.text = self._parameters[self._place][0]
            self._group.count += 1
            self._is_new_group = False
        group = self._group.text if self._group.count else None
        place = self._places.setdefault(name if group is None else group, len(self._parameters))
        if place == len(self._parameters):
            self._parameters.append((name, {}))
        if group is not None:  # rcl renames the entry that stood for the group
            if self._places[group] == place:
                del self._places[group]
            full = f'{group}.{name}'
            self._parameters[place] = full, self._parameters[place][1]
            self._places.setdefault(full, place)
        self._place = place

    def _value(self, event: Any, line: int) -> None:
        if not self._inside or not self._parameters:
            raise RclError(f'a value before {_KEY} at line {line}')
        is_plain = event.style not in ('"', "'")
        if is_plain and not event.value:
            raise RclError(f'missing value at line {line}')
        value = _scalar(event.value) if is_plain and event.tag != _TEXT_TAG else event.value
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
                           f'{_KINDS[self._kind]}')
        kinds[self._kind,].append(value)


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


def _scalar(text: str) -> bool | int | float | str:
    """Return the value of an unquoted scalar."""
    if text in _BOOLEANS:
        return _BOOLEANS[text]
    integer = _INTEGER.fullmatch(text)
    if integer and len(text) < 40:  # longer ones are out of range
        sign, digits = integer.groups()
        base = 16 if digits[:2] in ('0x', '0X') else 8 if digits[0] == '0' else 10
        value = int(sign + digits, base)
        if -2**63 <= value < 2**63:
            return value
    special = _YAML_SPECIAL.fullmatch(text) or _SPECIAL.fullmatch(text)
    if special:
        return float(''.join(filter(None, special.groups())))
    if _DECIMAL.fullmatch(text) or _HEXADECIMAL.fullmatch(text):
        try:
            number = float.fromhex(text) if 'x' in text.lower() else float(text)
        except OverflowError:
            return text
        if _LEAST_NORMAL <= abs(number) < float('inf') or number == 0.0 and _ZERO.fullmatch(text):
            return number
    return text
