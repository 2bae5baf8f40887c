"""The rooms of the package, as the table in architecture.md has them."""

from __future__ import annotations

from pathlib import Path
import re
from typing import NamedTuple

PAGE = Path(__file__).with_name('architecture.md')


class Room(NamedTuple):
    """A part of the package: what is in it, and what it may import."""

    name: str
    text: str
    imports: tuple[str, ...]
    late: tuple[str, ...]  # inside a function only
    libraries: tuple[str, ...]  # that no other room imports


def rooms() -> dict[str, Room]:
    """Return the rooms by their names, in the order of the table."""
    section = PAGE.read_text(encoding='utf-8').split('## Rooms')[1].split('\n## ')[0]
    rows = [line.split('|')[1:-1] for line in section.splitlines() if line.startswith('| `')]
    return {room.name: room for room in (
        Room(_names(name)[0], text.strip(), *(_names(cell) for cell in cells))
        for name, text, *cells in rows)}


def _names(cell: str) -> tuple[str, ...]:
    return tuple(re.findall(r'`(\w+)`', cell))
