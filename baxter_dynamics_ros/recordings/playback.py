"""Playback of a recording through the node's predictor, in blocks for batch computation."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..estimation.predictor import Estimate, Predictor
from ..estimation.stream import State
from ..model.arrays import Array, Indices
from ..model.joints import N_JOINTS

BLOCK = 256  # estimates in a batch, few enough for the processor's cache

# Stamp [ns], names, position, velocity and effort of a joint state, and when it was received [ns].
Message = tuple[int, Sequence[str], Array, Array, Array, int]
_Row = tuple[int, Estimate, State, State]

_NOTHING = np.full(N_JOINTS, np.nan)


class Recording(Protocol):
    """Joint states of one arm, in the order of recording."""

    name: str
    topic: str
    arm: str
    count: int  # messages

    def __iter__(self) -> Iterator[Message]:
        """Yield each joint state."""


class Block(NamedTuple):
    """Consecutive estimates of one arm, and the newest measurements at those times."""

    received_ns: Indices  # (n,) time of recording of the newest message [ns]
    estimate: Estimate  # arrays (n, 7); NaN where no effort was measured
    q: Array  # (n, 7) newest position [rad]
    qd: Array  # (n, 7) newest usable velocity [rad/s]; NaN where there is none
    measured_qd: Array  # (n, 7) newest velocity, even if the positions contradict it [rad/s]
    effort: Array  # (n, 7) newest effort [N m]; NaN where none was measured
    dt: Array  # (n,) time since the previous measurement [s]
    first_difference: Array  # (n, 7) (newest - previous velocity) / dt [rad/s^2], or NaN


def play(messages: Iterable[Message], predictor: Predictor) -> Iterator[Block]:
    """Pass joint states to a predictor; yield blocks of up to BLOCK estimates, in order."""
    rows: list[_Row] = []
    previous = None
    for stamp_ns, names, position, velocity, effort, received_ns in messages:
        step = predictor.estimate(stamp_ns, names, position, velocity, effort)
        if step.state is None:
            continue
        if step.estimate is not None and previous is not None:
            rows.append((received_ns, step.estimate, step.state, previous))
            if len(rows) == BLOCK:
                yield _stacked(rows)
                rows = []
        previous = step.state
    if rows:
        yield _stacked(rows)


def _stacked(rows: list[_Row]) -> Block:
    received, estimates, newest, previous = zip(*rows)
    stamp, q, qd, qdd, measured, presliding = zip(*estimates)
    velocity = _array([state.qd for state in newest])
    dt = np.array([now.stamp_ns - then.stamp_ns for now, then in zip(newest, previous)]) * 1e-9
    difference = (velocity - _array([state.qd for state in previous])) / dt[:, None]
    return Block(
        np.array(received),
        Estimate(np.array(stamp), *map(_array, (q, qd, qdd, measured, presliding))),
        _array([state.q for state in newest]), velocity,
        _array([state.measured_qd for state in newest]),
        _array([state.effort for state in newest]), dt, difference)


def _array(values: Iterable[Array | None]) -> Array:
    """Stack arrays (7,) to (n, 7), with NaN for None."""
    return np.concatenate(
        [_NOTHING if value is None else value for value in values]).reshape(-1, N_JOINTS)
