"""What a recording says about the robot, taken in by the node's own estimator."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..estimation.settings import PredictorSettings
from ..model.arrays import Array
from ..model.presliding import Presliding
from ..recordings.playback import play, Recording

_BREAK = 0.15  # [s] between estimates, after which the filter has started anew


@dataclass(frozen=True, eq=False)
class Motion:
    """The estimates of one recording that have a measured effort, n of them; joint order."""

    name: str
    time: Array  # (n,) the estimates' instants, since the first [s]
    q: Array  # (n, 7) [rad]
    qd: Array  # (n, 7) [rad/s]
    qdd: Array  # (n, 7) [rad/s^2]
    effort: Array  # (n, 7) measured [N m]
    newest_q: Array  # (n, 7) position when the estimate was made [rad]
    newest_qd: Array  # (n, 7) velocity as measured [rad/s]; NaN where there is none
    counts: dict[Any, int] = field(default_factory=dict)  # what the stream handler met

    def __len__(self) -> int:
        return len(self.time)

    def rows(self, start: int, stop: int) -> 'Motion':
        """Return some of the rows, as a recording of their own."""
        parts: dict[str, Any] = {name: value[start:stop] for name, value in vars(self).items()
                                 if isinstance(value, np.ndarray)}
        return replace(self, **parts)

    def renamed(self, name: str) -> 'Motion':
        """Return the same motion under another name."""
        return replace(self, name=name)

    @property
    def duration(self) -> float:
        """Time that the estimates cover, without gaps [s]."""
        if not len(self):
            return 0.0
        return float(sum(np.ptp(self.time[segment]) for segment in self.segments))

    @property
    def period(self) -> float:
        """Typical time between two estimates [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def segments(self) -> list[slice]:
        """Slices between which the filter started anew."""
        breaks = np.flatnonzero(np.abs(np.diff(self.time)) > _BREAK) + 1
        return [slice(*pair) for pair in zip([0, *breaks], [*breaks, len(self)])]

    def presliding(self, length: Array | float) -> Array:
        """
        Return Dahl's state along the motion.

        Parameters
        ----------
        length : float, or array_like (m, 1)
            The angle over which friction turns round [rad], or several.

        Returns
        -------
        ndarray (n, 7), or (n, m, 7)

        """
        states = []
        for segment in self.segments:
            state = Presliding(length)
            states += [state.update(q) for q in self.q[segment]]
        return np.array(states)


def observe(recording: Recording, values: dict[str, Any]) -> Motion:
    """
    Return a recording's motion.

    Parameters
    ----------
    recording : Recording
        Joint states with a name and an arm.
    values : dict
        Settings of the predictor; those of the filter are used.

    """
    predictor = PredictorSettings({
        **values, 'arm': recording.arm, 'align': True, 'effort_model.enabled': False}).predictor()
    parts: list[list[Any]] = []
    for block in play(recording, predictor):
        estimate = block.estimate
        measured = estimate.measured
        assert measured is not None  # in a block it is NaN instead
        valid = np.isfinite(measured[:, 0])
        parts.append([x[valid] for x in (
            estimate.stamp_ns, estimate.q, estimate.qd, estimate.qdd, measured, block.q,
            block.qd)])
    if not parts:
        parts = [[np.empty(0, int)] + [np.empty((0, 7))] * 6]
    stamps, q, qd, qdd, effort, newest_q, newest_qd = (
        np.concatenate(column) for column in zip(*parts))
    time = (stamps - stamps[:1]) * 1e-9
    return Motion(recording.name, time, q, qd, qdd, effort, newest_q, newest_qd,
                  dict(predictor.counts))
