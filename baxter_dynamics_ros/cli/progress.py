"""Progress bar for a recording that is being read."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .console import progress
from ..recordings.playback import Message, Recording

_EVERY = 1000  # messages between two updates of the bar


class _Watched:
    """A recording that moves a progress bar while it is iterated over."""

    def __init__(self, recording: Recording, update: Callable[[float, str], None]) -> None:
        self.name, self.topic, self.arm = recording.name, recording.topic, recording.arm
        self.count = recording.count
        self._recording = recording
        self._update = update

    def __iter__(self) -> Iterator[Message]:
        for i, message in enumerate(self._recording):
            if i % _EVERY == 0:
                self._update(i, self.name)
            yield message


@contextmanager
def watched(recording: Recording) -> Iterator[Recording]:
    """
    Show a progress bar on a terminal while an open recording is read.

    Yields
    ------
    Recording
        To iterate over in the recording's place.

    """
    with progress(recording.count) as update:
        yield _Watched(recording, update)
