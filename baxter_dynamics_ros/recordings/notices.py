"""Notices about recordings and fits."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Notice:
    """A warning about a recording or a fit."""

    kind: str  # such as 'effort_sign' or the value of an event
    text: str  # one sentence with numbers and, if there is one, the remedy
    joints: tuple[str, ...] = ()  # joints concerned; empty for all or none
    recording: str = ''  # recording concerned; empty for all
    refuses: bool = False  # whether a calibration must not use the data

    def __str__(self) -> str:
        """Return the text, preceded by the recording if there is one."""
        return f'{self.recording}: {self.text}' if self.recording else self.text
