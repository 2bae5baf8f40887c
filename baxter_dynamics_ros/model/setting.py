"""Declaration of settings: default, description, unit and range, and groups of them."""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, Field, field, fields, replace
from textwrap import fill, indent
from typing import Any, ClassVar

import numpy as np

from .arrays import finite, read_only
from .exceptions import ArgumentError

Floats = tuple[float, ...]

# Type of a value -> words for it in errors; a tuple is a list of numbers.
TYPE_WORDS: dict[type, str] = {
    bool: 'true or false', int: 'an integer such as 2',
    float: 'a number with a decimal point such as 1.0', str: 'a string',
    tuple: 'a list of numbers with decimal points such as [1.0, 2.0]'}


@dataclass(frozen=True)
class Setting:
    """Declaration of a setting; a tuple as the default stands for a list of that length."""

    name: str
    default: str | bool | int | float | Floats
    description: str
    unit: str = ''
    lower: float = -float('inf')
    upper: float = float('inf')
    choices: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()  # of an array, which is a flat list as a parameter
    read_only: bool = False  # cannot be changed while the node runs

    def check(self, value: Any) -> Any:
        """Return the value in the type of the default; raise ArgumentError if it is invalid."""
        kind = type(self.default)
        if isinstance(self.default, tuple):
            n = len(self.default)
            return tuple(self._within(value, *dict.fromkeys([(n,), self.shape or (n,)])))
        if kind is float:
            return self._within(value, ())[0]
        if self.choices and value not in self.choices:
            raise ArgumentError(
                self.name, f'expected one of {", ".join(self.choices)}, got {value!r}')
        if not isinstance(value, kind) or isinstance(value, bool) is not (kind is bool):
            raise ArgumentError(self.name, f'expected {TYPE_WORDS[kind]}, got {value!r}')
        if isinstance(value, str) and not value.isprintable():
            raise ArgumentError(self.name, f'expected printable text, got {value!r}')
        return int(self._within(value, ())[0]) if kind is int else value

    def check_parameter(self, value: Any) -> Any:
        """Return the checked value of a ROS parameter; integers are not accepted for floats."""
        kind = type(self.default)
        parts = list(value) if kind is tuple and isinstance(value, (list, tuple, array)) else []
        if not (parts and type(parts[0]) is float if kind is tuple else type(value) is kind):
            raise ArgumentError(self.name, f'expected {TYPE_WORDS[kind]}, got {value!r:.40}')
        return self.check(value)

    def _within(self, value: Any, *shapes: tuple[int, ...]) -> list[float]:
        """Return numbers of one of some shapes as a flat list, if all are in the range."""
        found = finite(self.name, value, *shapes).ravel()
        outside = np.flatnonzero((found < self.lower) | (found > self.upper))
        if outside.size:
            name = f'{self.name}[{outside[0]}]' if shapes[0] else self.name
            range_ = f'[{self.lower:g}, {self.upper:g}] {self.unit}'.rstrip()
            raise ArgumentError(name, f'expected a value in {range_}, got '
                                f'{found[outside[0]]:.15g}')
        return found.tolist()

    def document(self, name: str) -> str:
        """Return the entry of this setting in the docstring of its group."""
        default, kind = self.default, type(self.default).__name__
        if isinstance(default, tuple):
            kind = f'array_like {self.shape or (len(default),)}'
        unit = f' [{self.unit}]' if self.unit else ''
        range_ = f', from {self.lower:g} to {self.upper:g}' if self.lower > -np.inf else ''
        text = fill(f'{self.description[:-1]}{unit}{range_}.', 91)
        return f'\n    {name} : {kind}\n' + indent(text, 8 * ' ')


@dataclass(frozen=True)
class Group:
    """Base of groups of settings; values are checked when a group is created."""

    own_settings: ClassVar[dict[str, Setting]] = {}  # field name -> declaration

    def __init_subclass__(cls, prefix: str = '') -> None:
        """Collect the settings, whose names have a prefix, and add them to the docstring."""
        own = {name: replace(each.metadata['setting'], name=prefix + name)
               for name, each in vars(cls).items() if isinstance(each, Field)}
        cls.own_settings = cls.own_settings | own
        entries = ''.join(each.document(name) for name, each in own.items())
        text = (cls.__doc__ or '').rstrip()
        cls.__doc__ = f'{text}\n\n    Attributes\n    ----------{entries}'

    def __post_init__(self) -> None:
        """Check each value and store it in the type of the default, or as a read-only array."""
        for name, setting in self.own_settings.items():
            value = setting.check(getattr(self, name))
            if setting.shape:
                value = read_only(np.reshape(value, setting.shape))
            object.__setattr__(self, name, value)
        for each in fields(self):
            kind, value = type(each.default), getattr(self, each.name)
            if issubclass(kind, Group) and not isinstance(value, kind):
                raise ArgumentError(each.name, f'expected {kind.__name__}, got {value!r:.60}')

    def __reduce__(self: Any) -> tuple[Any, ...]:
        """Copy and pickle by constructor arguments, so that arrays stay read-only."""
        return type(self), tuple(getattr(self, each.name) for each in fields(self) if each.init)

    def __eq__(self, other: object) -> bool:
        """Compare by value, arrays too."""
        return isinstance(other, Group) and self.parameters() == other.parameters()

    def __hash__(self) -> int:
        """Return the hash of the values."""
        return hash(tuple(self.parameters().values()))

    def items(self) -> 'Iterator[tuple[Setting, Any]]':
        """Yield each setting, those of groups too, and its value; an array is a flat tuple."""
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, Group):
                yield from value.items()
            else:
                yield self.own_settings[each.name], (
                    tuple(value.ravel().tolist()) if isinstance(value, np.ndarray) else value)

    def parameters(self) -> dict[str, Any]:
        """Return the value of each setting by its dotted name."""
        return {setting.name: value for setting, value in self.items()}


def setting(default: Any, *declaration: Any, **options: Any) -> Any:
    """Return a field of a group, declared as a :class:`Setting`, for arrays if the default is."""
    if isinstance(default, np.ndarray):
        default, options['shape'] = tuple(default.ravel().tolist()), default.shape
    return field(default=default,
                 metadata={'setting': Setting('', default, *declaration, **options)})
