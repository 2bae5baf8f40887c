"""Stamps for tests: a robot's, and times of arrival at three kinds of receiver."""

from baxter_dynamics_ros.estimation import retiming
from baxter_dynamics_ros.estimation.events import Event
import numpy as np

START = 1_700_000_000_123_456_789  # [ns]
JITTER = 4e-5  # sd of the robot's stamps [s]


class Retiming(retiming.Retiming):
    """Source of stamps that counts resyncs and marks the first stamp of a time line."""

    resyncs, restarted, _out_before = 0, False, None

    def update(self, *args):
        """Return the stamp to use."""
        out = super().update(*args)
        self.resyncs += self.event is Event.RESET_RESYNC
        self.restarted = out is not None and bool(self._out_before is None or self.event)
        self._out_before = out
        return out


def made(rate, duration, seed=0):
    """Return a robot's stamps [s], which have a little jitter."""
    n = int(duration * rate)
    return np.arange(n) / rate + np.random.default_rng(seed).normal(0.0, JITTER, n)


def lossy(rate, share, seed=1):
    """Return the robot's stamps without a share of them."""
    t = made(rate, 20.0)
    return t[np.random.default_rng(seed).uniform(size=len(t)) > share]


def stalled(t, seed=0, link=3e-4):
    """
    Return arrivals at a receiver that pauses for 50 to 110 ms about three times a second.

    ``link`` is the mean delay of the link to it [s].
    """
    random = np.random.default_rng(seed)
    n = int(4 * (t[-1] - t[0])) + 40
    lasts = random.uniform(0.05, 0.11, n)
    ends = t[0] + np.cumsum(random.exponential(0.27, n) + lasts)
    delayed = t + random.exponential(link, len(t))
    i = np.searchsorted(ends, delayed)
    return np.maximum.accumulate(np.where(delayed > (ends - lasts)[i], ends[i], delayed))


def bursts(t):
    """Return arrivals at a receiver that pauses, over a link without delay."""
    return stalled(t, link=0.0)


def queued(t, seed=0):
    """Return arrivals over a link with a mean delay of 15 ms that keeps the order."""
    delays = np.random.default_rng(seed).exponential(0.015, len(t))
    return np.maximum.accumulate(t + delays)


def polled(t, seed=0):
    """Return arrivals at a receiver that polls at irregular times, 77 times a second."""
    random = np.random.default_rng(seed)
    polls = t[0] + np.cumsum(random.exponential(0.013, int(100 * (t[-1] - t[0])) + 100))
    return polls[np.searchsorted(polls, t)]


PATTERNS = [stalled, queued, polled]


def run(retiming, arrivals, fresh=True, start=START):
    """Return the stamps [s after start], NaN for None, and whether each starts a time line."""
    out, restarted = [], []
    for x in arrivals:
        stamp = retiming.update(start + round(x * 1e9), fresh)
        out.append(np.nan if stamp is None else (stamp - start) * 1e-9)
        restarted.append(retiming.restarted)
        assert not (stamp is None and retiming.restarted)
    return np.array(out), np.array(restarted)


def increases(out, restarted):
    """Return whether stamps increase, except where a time line starts."""
    given = np.isfinite(out)
    return bool((np.diff(out[given]) > 0)[~restarted[given][1:]].all())
