"""The terminal of a watcher: a key that ends it, and a picture of what it shows."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
import io
import os
from pathlib import Path
import select
import signal
import sys
import termios
import time
import tty
from types import FrameType

from rich.console import Console, Group
from rich.terminal_theme import DEFAULT_TERMINAL_THEME
from rich.text import Text

from ..files import write_file

# Rich's own refers to a font on the web, which a forge does not load. This one also has an
# opaque background up to the edges.
_SVG = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">
<title>TITLE</title>
<style>
.{unique_id}-matrix {{
  font-family: "DejaVu Sans Mono", Menlo, Consolas, "Liberation Mono", monospace;
  font-size: {char_height}px;
  line-height: {line_height}px;
}}
.{unique_id}-title {{
  font-family: sans-serif;
  font-size: {char_height}px;
  fill: #555555;
}}
{styles}
</style>
<defs>
<clipPath id="{unique_id}-clip-terminal">
<rect x="0" y="0" width="{terminal_width}" height="{terminal_height}"/>
</clipPath>
{lines}
</defs>
<rect width="100%" height="100%" fill="#ffffff"/>
<text class="{unique_id}-title" x="{terminal_x}" y="27">TITLE</text>
<g transform="translate({terminal_x}, {terminal_y})" clip-path="url(#{unique_id}-clip-terminal)">
{backgrounds}
<g class="{unique_id}-matrix">
{matrix}
</g>
</g>
</svg>
"""


class Keys:
    """Waits, and knows whether q was pressed meanwhile."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    def wait(self, seconds: float) -> bool:
        """Wait; return at once, with True, where q is pressed."""
        until = time.monotonic() + seconds
        while True:
            left = max(until - time.monotonic(), 0.0)
            if self._descriptor is None:
                time.sleep(left)
                return False
            if not select.select([self._descriptor], [], [], left)[0]:
                return False
            pressed = os.read(self._descriptor, 100)
            if b'q' in pressed.lower():
                return True
            if not pressed:  # closed
                self._descriptor = None


@contextmanager
def keys() -> Iterator[Keys]:
    """Take single keys from the terminal, unshown; it is as before afterwards."""
    descriptor = sys.stdin.fileno() if sys.stdin is not None and sys.stdin.isatty() else None
    if descriptor is None or _is_in_background(descriptor):
        yield Keys(None)
        return
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield Keys(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


@contextmanager
def suspension(drawn: Console) -> Iterator[None]:
    """Let Ctrl-Z leave the terminal's usual screen and settings to the shell."""
    terminal = drawn.file.fileno()
    usual = termios.tcgetattr(terminal)

    def stop(number: int, frame: FrameType | None) -> None:
        # Past Rich, which may be writing just now; all of it is drawn anew at the next time.
        ours = termios.tcgetattr(terminal)
        os.write(terminal, b'\x1b[?1049l\x1b[?25h')
        termios.tcsetattr(terminal, termios.TCSADRAIN, usual)
        os.kill(os.getpid(), signal.SIGSTOP)
        # In the background this stops again, until it is in the foreground.
        termios.tcsetattr(terminal, termios.TCSADRAIN, ours)
        os.write(terminal, b'\x1b[?1049h\x1b[?25l')
    before = signal.getsignal(signal.SIGTSTP)
    if before is not signal.SIG_IGN:  # as it is where no shell could continue us
        signal.signal(signal.SIGTSTP, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTSTP, before)


def _is_in_background(terminal: int) -> bool:
    try:
        return os.tcgetpgrp(terminal) != os.getpgrp()
    except OSError:  # not the terminal that this process belongs to
        return False


def save_picture(path: Path, lines: list[Text], width: int, title: str) -> None:
    """
    Save lines of text as an SVG that needs no other file, nor the web.

    Raises
    ------
    BaxterDynamicsError
        If it cannot be written.

    """
    console = Console(record=True, file=io.StringIO(), width=width, height=len(lines),
                      force_terminal=True, color_system='truecolor', legacy_windows=False)
    console.print(Group(*lines))
    svg = console.export_svg(theme=DEFAULT_TERMINAL_THEME, unique_id='watch',
                             code_format=_SVG.replace('TITLE', escape(title)))
    write_file(path, svg)
