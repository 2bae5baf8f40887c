"""A progress bar beside a recording that is being read."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress

from ..recordings.playback import Message, Recording

_EVERY = 1000  # messages between two updates of the bar


class _Watched:
    """A recording that moves a progress bar while it is iterated over."""

    def __init__(self, recording: Recording, progress: Progress) -> None:
        self.name, self.topic, self.arm = recording.name, recording.topic, recording.arm
        self.count = recording.count
        self._recording = recording
        self._progress = progress
        self._task = progress.add_task(recording.name, total=recording.count)

    def __iter__(self) -> Iterator[Message]:
        for i, message in enumerate(self._recording):
            if i % _EVERY == 0:
                self._progress.update(self._task, completed=i)
            yield message


@contextmanager
def watched(recording: Recording, console: Console) -> Iterator[Recording]:
    """
    Show a progress bar on a terminal while an open recording is read.

    Yields
    ------
    Recording
        To iterate over in the recording's place.

    """
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        yield _Watched(recording, progress)
