"""Notices about recordings: typed, so that nothing has to be read back from text."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Notice:
    """
    Something a reader must know about a recording or a fit.

    Attributes
    ----------
    kind : str
        Machine-readable kind, such as 'effort_sign' or the value of an event.
    text : str
        One sentence with numbers and, where there is one, the remedy.
    joints : tuple of str
        Joints concerned; empty if it concerns all or none.
    recording : str
        Recording concerned; empty if it concerns all.
    refuses : bool
        Whether a calibration must not use the data.

    """

    kind: str
    text: str
    joints: tuple[str, ...] = ()
    recording: str = ''
    refuses: bool = False

    def about(self, recording: str) -> 'Notice':
        """Return the notice with the name of its recording."""
        return replace(self, recording=recording)

    def __str__(self) -> str:
        """Return the text, preceded by the recording if there is one."""
        return f'{self.recording}: {self.text}' if self.recording else self.text
