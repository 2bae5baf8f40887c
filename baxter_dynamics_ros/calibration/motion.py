"""What a recording says about the robot, taken in by the node's own estimator."""

from dataclasses import dataclass
from dataclasses import field
from dataclasses import fields
from dataclasses import replace

import numpy as np

from ..core.presliding import Presliding
from ..offline.playback import play
from ..signals.settings import PredictorSettings

_BREAK = 0.15  # [s] between estimates, after which the filter has started anew


@dataclass(frozen=True, eq=False)
class Motion:
    """The estimates of one recording that have a measured effort, n of them; joint order."""

    name: str
    time: np.ndarray  # (n,) the estimates' instants, since the first [s]
    q: np.ndarray  # (n, 7) [rad]
    qd: np.ndarray  # (n, 7) [rad/s]
    qdd: np.ndarray  # (n, 7) [rad/s^2]
    effort: np.ndarray  # (n, 7) measured [N m]
    newest_q: np.ndarray  # (n, 7) position when the estimate was made [rad]
    newest_qd: np.ndarray  # (n, 7) velocity as measured [rad/s]; NaN where there is none
    counts: dict = field(default_factory=dict)  # what the stream handler met

    def __len__(self):
        return len(self.time)

    def rows(self, start: int, stop: int) -> 'Motion':
        """Return some of the rows, as a recording of their own."""
        return Motion(*(value[start:stop] if isinstance(value, np.ndarray) else value
                        for value in (getattr(self, f.name) for f in fields(self))))

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
    def segments(self) -> list:
        """Slices between which the filter started anew."""
        breaks = np.flatnonzero(np.abs(np.diff(self.time)) > _BREAK) + 1
        return [slice(*pair) for pair in zip([0, *breaks], [*breaks, len(self)])]

    def presliding(self, length) -> np.ndarray:
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


def observe(recording, values: dict) -> Motion:
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
    parts = []
    for block in play(recording, predictor):
        estimate = block.estimate
        valid = np.isfinite(estimate.measured[:, 0])
        parts.append([x[valid] for x in (
            estimate.stamp_ns, estimate.q, estimate.qd, estimate.qdd, estimate.measured, block.q,
            block.qd)])
    if not parts:
        parts = [[np.empty(0, int)] + [np.empty((0, 7))] * 6]
    stamps, *arrays = (np.concatenate(column) for column in zip(*parts))
    time = (stamps - stamps[:1]) * 1e-9
    return Motion(recording.name, time, *arrays, dict(predictor.counts))
