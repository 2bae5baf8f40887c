"""Data of a fit: motion estimates of recordings, from the estimator of the predictor."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS
from ..model.presliding import Presliding
from ..recordings.playback import play, Recording
from ..recordings.velocity_lag import segments

_SPEED_SPAN = 0.1  # half span of the position difference that gives the speed [s]


@dataclass(frozen=True, eq=False)
class Motion:
    """The n estimates of a recording that have a measured effort; joint order s0 ... w2."""

    name: str
    time: Array  # (n,) instants of the estimates, relative to the first [s]
    q: Array  # (n, 7) [rad]
    qd: Array  # (n, 7) [rad/s]
    qdd: Array  # (n, 7) [rad/s^2]
    effort: Array  # (n, 7) measured [N m]
    newest_q: Array  # (n, 7) newest position at the time of the estimate [rad]
    newest_qd: Array  # (n, 7) newest measured velocity [rad/s]; NaN if missing
    counts: dict[Any, int] = field(default_factory=dict)  # counts of the stream handler

    def __len__(self) -> int:
        return len(self.time)

    def rows(self, start: int, stop: int) -> 'Motion':
        """Return the given rows as a motion."""
        return self._taken(slice(start, stop))

    def renamed(self, name: str) -> 'Motion':
        """Return the same motion under another name."""
        return replace(self, name=name)

    @property
    def duration(self) -> float:
        """Time covered by the estimates, without gaps [s]."""
        if not len(self):
            return 0.0
        return float(sum(np.ptp(self.time[segment]) for segment in self.segments))

    @property
    def period(self) -> float:
        """Typical time between two estimates [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def segments(self) -> list[slice]:
        """Slices between restarts of the filter."""
        return segments(self.time)

    @property
    def speed(self) -> Array:
        """
        Speed from positions alone, (m, 7) [rad/s].

        Over 0.2 s the noise of positions is 0.003 rad/s, that of measured velocities 0.013 rad/s
        and up to 0.1 rad/s on some arms.
        """
        result = [np.zeros((1, N_JOINTS))]
        for segment in self.segments:
            t, q = self.time[segment], self.q[segment]
            k = max(round(_SPEED_SPAN / self.period), 1) if len(t) > 1 else 1
            result.append((q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None])
        return np.concatenate(result)

    def same_data(self, other: 'Motion') -> bool:
        """Return whether another motion holds the same measurements, whatever its name."""
        return np.array_equal(self.q, other.q) and np.array_equal(self.effort, other.effort)

    def without(self, mask: Bools) -> 'Motion':
        """Return the motion without some rows, (n,) bool."""
        return self._taken(~mask)

    def _taken(self, rows: Any) -> 'Motion':
        parts: dict[str, Any] = {name: value[rows] for name, value in vars(self).items()
                                 if isinstance(value, np.ndarray)}
        return replace(self, **parts)

    def presliding(self, length: Array | float) -> Array:
        """
        Return Dahl's state along the motion.

        Parameters
        ----------
        length : float, or array_like (m, 1)
            Angle over which friction reverses [rad], or several.

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
            block.measured_qd)])
    if not parts:
        parts = [[np.empty(0, int)] + [np.empty((0, 7))] * 6]
    stamps, q, qd, qdd, effort, newest_q, newest_qd = (
        np.concatenate(column) for column in zip(*parts))
    time = (stamps - stamps[:1]) * 1e-9
    return Motion(recording.name, time, q, qd, qdd, effort, newest_q, newest_qd,
                  dict(predictor.counts))
