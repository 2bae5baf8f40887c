"""Whether a sample continues the stream, starts it anew, or does not belong to it."""

import numpy as np

from .events import DROPPED, Event
from ..model.arrays import Array
from ..model.joints import N_JOINTS, VELOCITY_LIMIT

GAP = 0.25  # longer between two stamps [s]: the filter starts anew
CLOCK_JUMP = 0.5  # stamps that run back this far [s] belong to another clock
MAX_OUT_OF_ORDER = 5  # late messages in a row, after which the stream is believed instead
JUMP_MARGIN = 0.02  # [rad] allowed on top of 1.5 times the greatest joint speed
_MARGIN = np.full(N_JOINTS, JUMP_MARGIN)  # compares faster than a number
# Stamps closer than the robot's greatest rate of 800 Hz allows are times of arrival: what they
# stamp may be this far apart in truth [s].
SHORTEST_PERIOD = 0.001
UNKNOWN_PERIOD = 0.03


class Continuity:
    """
    Remembers the last sample that was taken in and judges the next against it.

    Attributes
    ----------
    repeated : bool
        Whether the sample that was judged last came at once after the one before, with its data.

    """

    def __init__(self) -> None:
        self.repeated = False
        # Stamp [ns], q, qd, effort.
        self._last: tuple[int, Array, Array | None, Array | None] | None = None
        self._out_of_order = 0

    def forget(self) -> None:
        """Take whatever comes next as a beginning."""
        self._last = None
        self._out_of_order = 0

    def judge(self, stamp_ns: int, q: Array, qd: Array | None, effort: Array | None,
              period: float | None = None) -> 'Event | None':
        """
        Judge a sample, and remember it unless it is dropped.

        Parameters
        ----------
        stamp_ns : int
            The sample's stamp [ns].
        q : ndarray (7,)
            Position [rad].
        qd, effort : ndarray (7,) or None
            Velocity [rad/s] and effort [N m].
        period : float, optional
            How far apart samples are in truth, where stamps are times of arrival [s].

        Returns
        -------
        Event or None
            OUT_OF_ORDER or DUPLICATE: drop it. REPEATED_STAMP: new data at the last stamp.
            RESET_...: start anew with it. None: it continues the stream, or begins it.

        """
        event = self._verdict(stamp_ns, q, qd, effort, period)
        if event is None or event not in DROPPED:
            self._last = (stamp_ns, q, qd, effort)
            self._out_of_order = 0
        return event

    def _verdict(self, stamp_ns: int, q: Array, qd: Array | None, effort: Array | None,
                 period: float | None) -> Event | None:
        self.repeated = False
        if self._last is None:
            return None
        last_stamp, last_q, last_qd, last_effort = self._last
        dt = (stamp_ns - last_stamp) * 1e-9
        if dt > GAP:
            return Event.RESET_GAP
        if dt < 0.0:
            self._out_of_order += 1
            if -dt >= CLOCK_JUMP or self._out_of_order >= MAX_OUT_OF_ORDER:
                return Event.RESET_CLOCK_JUMP
            return Event.OUT_OF_ORDER
        if dt < SHORTEST_PERIOD:
            self.repeated = (_same(q, last_q) and _same(qd, last_qd)
                             and _same(effort, last_effort))
            if dt == 0.0 and self.repeated:
                return Event.DUPLICATE
        if (qd is None) != (last_qd is None):
            return Event.RESET_VELOCITY_SOURCE
        moved = np.abs(q - last_q)
        if np.count_nonzero(moved > _MARGIN):  # else it is no jump, whatever the period
            if period is None and dt < SHORTEST_PERIOD:
                period = UNKNOWN_PERIOD
            period = max(dt, period or 0.0)
            if np.count_nonzero(moved - _MARGIN > (1.5 * period) * VELOCITY_LIMIT):
                return Event.RESET_POSITION_JUMP
        return Event.REPEATED_STAMP if dt == 0.0 else None


def _same(a: Array | None, b: Array | None) -> bool:
    return a is b if a is None or b is None else bool((a == b).all())
