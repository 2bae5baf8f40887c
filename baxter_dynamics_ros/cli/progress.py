"""A progress bar beside a recording that is being read."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .console import progress
from ..recordings.bags import BagRecording
from ..recordings.playback import Message, Recording
from ..recordings.reader import ArrayRecording
from ..recordings.writer import BagWriter

_EVERY = 1000  # messages between two looks at the bar


class _Watched:
    """A recording that tells how far it was read; iterate over it like the one it stands for."""

    def __init__(self, recording: Recording, messages: Callable[[], Iterator[Message]],
                 tell: Callable[[int], None]) -> None:
        self.name, self.topic, self.arm = recording.name, recording.topic, recording.arm
        self._messages = messages
        self._tell = tell

    def __iter__(self) -> Iterator[Message]:
        for i, message in enumerate(self._messages()):
            if i % _EVERY == 0:
                self._tell(i)
            yield message


@contextmanager
def watched(recording: BagRecording | ArrayRecording,
            writer: BagWriter | None = None) -> Iterator[_Watched]:
    """
    Show a bar while an open recording is read.

    Parameters
    ----------
    recording : BagRecording or ArrayRecording
        Open.
    writer : BagWriter, optional
        Gets a copy of all that is read.

    Yields
    ------
    an object to iterate over in the recording's place

    """
    def messages() -> Iterator[Message]:
        return iter(recording) if writer is None else recording.copied_to(writer)

    with progress(recording.count) as update:
        yield _Watched(recording, messages, lambda i: update(i, recording.name))
