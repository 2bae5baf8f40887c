"""Playback of a recording through the node's predictor, in blocks for batch computation."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from .recording import JointState
from ..estimation.motion_estimator import Estimate
from ..estimation.predictor import Predictor
from ..estimation.stream import State
from ..model.arrays import Array
from ..model.joints import N_JOINTS

BLOCK = 256  # estimates in a batch, few enough for the processor's cache

_NOTHING = np.full(N_JOINTS, np.nan)


class Block(NamedTuple):
    """Consecutive estimates of one arm, and the newest measurements at those times."""

    estimate: Estimate  # arrays (n, 7); NaN where no effort was measured
    q: Array  # (n, 7) newest position [rad]
    qd: Array  # (n, 7) newest usable velocity [rad/s]; NaN where there is none
    measured_qd: Array  # (n, 7) newest velocity, even if the positions contradict it [rad/s]
    effort: Array  # (n, 7) newest effort [N m]; NaN where none was measured
    dt: Array  # (n,) time since the previous measurement [s]
    first_difference: Array  # (n, 7) (newest - previous velocity) / dt [rad/s^2], or NaN


def play(messages: Iterable[JointState], predictor: Predictor) -> Iterator[Block]:
    """Pass joint states to a predictor; yield blocks of up to BLOCK estimates, in order."""
    rows: list[tuple[Estimate, State, State]] = []
    previous = None
    for message in messages:
        step = predictor.estimate(*message)
        if step.state is None:
            continue
        if step.estimate is not None and previous is not None:
            rows.append((step.estimate, step.state, previous))
            if len(rows) == BLOCK:
                yield _stacked(rows)
                rows = []
        previous = step.state
    if rows:
        yield _stacked(rows)


def _stacked(rows: list[tuple[Estimate, State, State]]) -> Block:
    estimates, newest, previous = zip(*rows)
    stamp, *estimate = zip(*estimates)
    q, qd, measured_qd, effort = (
        _array([getattr(state, name) for state in newest])
        for name in ('q', 'qd', 'measured_qd', 'effort'))
    dt = np.array([now.stamp_ns - then.stamp_ns for now, then in zip(newest, previous)]) * 1e-9
    difference = (qd - _array([state.qd for state in previous])) / dt[:, None]
    return Block(Estimate(np.array(stamp), *map(_array, estimate)), q, qd, measured_qd, effort,
                 dt, difference)


def _array(values: Iterable[Array | None]) -> Array:
    """Stack arrays (7,) to (n, 7), with NaN for None."""
    return np.concatenate(
        [_NOTHING if value is None else value for value in values]).reshape(-1, N_JOINTS)
