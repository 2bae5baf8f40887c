"""Stamps for tests: those that a robot makes, and times of arrival at receivers of three kinds."""

from baxter_dynamics_ros.estimation import retiming
from baxter_dynamics_ros.estimation.events import Event
import numpy as np

START = 1_700_000_000_123_456_789  # [ns]
JITTER = 4e-5  # sd of the robot's stamps [s]


class Retiming(retiming.Retiming):
    """Source of stamps that counts resyncs and says when a time line begins."""

    resyncs, restarted, _out_before = 0, False, None

    def update(self, *args):
        """Return the stamp to use."""
        out = super().update(*args)
        self.resyncs += self.event is Event.RESET_RESYNC
        self.restarted = out is not None and bool(self._out_before is None or self.event)
        self._out_before = out
        return out


def made(rate, duration, seed=0):
    """Return when a robot stamps its messages [s]."""
    n = int(duration * rate)
    return np.arange(n) / rate + np.random.default_rng(seed).normal(0.0, JITTER, n)


def lossy(rate, share, seed=1):
    """Return the robot's stamps without a share of them."""
    t = made(rate, 20.0)
    return t[np.random.default_rng(seed).uniform(size=len(t)) > share]


def stalled(t, seed=0, link=3e-4):
    """
    Return arrivals at a receiver that is away for 50 to 110 ms about three times a second.

    The link to it delays by ``link`` [s] in the mean.
    """
    random = np.random.default_rng(seed)
    n = int(4 * (t[-1] - t[0])) + 40
    lasts = random.uniform(0.05, 0.11, n)
    ends = t[0] + np.cumsum(random.exponential(0.27, n) + lasts)
    delayed = t + random.exponential(link, len(t))
    i = np.searchsorted(ends, delayed)
    return np.maximum.accumulate(np.where(delayed > (ends - lasts)[i], ends[i], delayed))


def bursts(t):
    """Return arrivals at such a receiver over a link that does not delay."""
    return stalled(t, link=0.0)


def queued(t, seed=0):
    """Return arrivals over a link that delays each by 15 ms in the mean and keeps the order."""
    delays = np.random.default_rng(seed).exponential(0.015, len(t))
    return np.maximum.accumulate(t + delays)


def polled(t, seed=0):
    """Return arrivals at a receiver that looks at no regular times, 77 times a second."""
    random = np.random.default_rng(seed)
    looks = t[0] + np.cumsum(random.exponential(0.013, int(100 * (t[-1] - t[0])) + 100))
    return looks[np.searchsorted(looks, t)]


PATTERNS = [stalled, queued, polled]


def run(retiming, arrivals, fresh=True, start=START):
    """Return the stamps [s since start] handed out, NaN for None, and those that began anew."""
    out, restarted = [], []
    for x in arrivals:
        stamp = retiming.update(start + round(x * 1e9), fresh)
        out.append(np.nan if stamp is None else (stamp - start) * 1e-9)
        restarted.append(retiming.restarted)
        assert not (stamp is None and retiming.restarted)
    return np.array(out), np.array(restarted)


def increases(out, restarted):
    """Tell whether stamps increase but for where they are said to begin anew."""
    given = np.isfinite(out)
    return bool((np.diff(out[given]) > 0)[~restarted[given][1:]].all())
