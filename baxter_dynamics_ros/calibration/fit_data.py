"""Data of a fit: motion estimates of recordings, from the estimator of the predictor."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..estimation.predictor import Estimate, Predictor
from ..estimation.settings import EffortModelSettings, PredictorSettings
from ..model.arrays import Array, Bools
from ..model.effort import Presliding
from ..model.joints import N_JOINTS
from ..recordings.playback import play
from ..recordings.recording import Recording
from ..recordings.velocity_lag import segments

MOVES = 0.05  # minimum speed of a moving joint [rad/s]

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
    weight: Array  # (n, 7) weight of each measured effort in a fit
    counts: dict[Any, int] = field(default_factory=dict)  # counts of the stream handler

    def __len__(self) -> int:
        return len(self.time)

    def take(self, rows: Any, name: str | None = None) -> 'Motion':
        """Return some rows, a slice or (n,) bool, as a motion with the same or another name."""
        parts: dict[str, Any] = {key: value[rows] for key, value in vars(self).items()
                                 if isinstance(value, np.ndarray)}
        return replace(self, name=name or self.name, **parts)

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

        Measured velocities have a noise of 0.1 rad/s on some arms, this speed one of 0.003 rad/s.
        """
        result = [np.zeros((1, N_JOINTS))]
        for segment in self.segments:
            t, q = self.time[segment], self.q[segment]
            k = max(round(_SPEED_SPAN / self.period), 1) if len(t) > 1 else 1
            result.append((q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None])
        return np.concatenate(result)

    def presliding(self, length: Array | float) -> Array:
        """
        Return Dahl's state along the motion, (n, 7).

        For several lengths, (m, 1), it is (n, m, 7). Length is the angle over which friction
        reverses [rad].
        """
        states = []
        for segment in self.segments:
            state = Presliding(length)
            states += [state.update(q) for q in self.q[segment]]
        return np.array(states)


def turning(motions: list[Motion]) -> Bools:
    """Return the joints whose positions move in both directions, (7,) bool."""
    speed = np.concatenate([motion.speed for motion in motions])
    return (speed.max(0) > MOVES) & (speed.min(0) < -MOVES)


def observe(recording: Recording, settings: PredictorSettings) -> Motion:
    """Return a recording's motion, estimated with the filter of some settings."""
    predictor = Predictor(replace(
        settings, arm=recording.arm, align=True, effort_model=EffortModelSettings(enabled=False)))
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
                  np.ones(q.shape), dict(predictor.counts))


def residual(motion: Motion, settings: PredictorSettings) -> Array:
    """Return the residual of a motion (n, 7) [N m], computed by the predictor."""
    model = settings.model.effort_model
    presliding = (motion.presliding(model.dahl_length) if model.has_dahl
                  else np.zeros(motion.q.shape))
    result = Predictor(settings).predict(Estimate(
        np.round(motion.time * 1e9).astype(int), motion.q, motion.qd, motion.qdd, motion.effort,
        presliding)).residual
    assert result is not None  # for the effort was measured
    return result


def rms(values: Array) -> Array:
    """Return the root of the mean square over the first axis."""
    return np.sqrt(np.mean(values ** 2, axis=0))
