"""Messages with all that can be wrong: each accounted for, nothing raised, nothing non-finite."""

from collections import Counter

from baxter_dynamics_ros.estimation.events import DROPPED, Event
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

MS = 1_000_000  # [ns]
START = 1_700_000_000_000_000_000  # [ns]
RIGHT = joint_names('right')
EMPTY = np.empty(0)
RESETS = (Event.RESET_GAP, Event.RESET_CLOCK_JUMP, Event.RESET_POSITION_JUMP,
          Event.RESET_VELOCITY_SOURCE)

pytestmark = pytest.mark.filterwarnings('error')


def stream(n: int):
    """Yield stamp and position, velocity and effort of n good messages at 100 Hz."""
    w, phase = 1.5, np.arange(7)
    for i in range(n):
        angle = w * 0.01 * i + phase
        yield START + 10 * MS * i, [np.sin(angle), w * np.cos(angle), 10.0 * np.sin(angle)]


def hostile(n: int):
    """Yield n messages, most of them good, the others with all that can be wrong."""
    rng = np.random.default_rng(7)
    offset = 0
    for stamp, arrays in stream(n):
        names = list(RIGHT)
        which = rng.integers(3)
        kind = rng.integers(120)  # mostly none of these
        if kind == 0:
            names = list(rng.choice(RIGHT, 7))
        elif kind == 1:
            names = names[:rng.integers(8)]
        elif kind == 2:
            names, arrays = ['head_pan'], [np.full(1, np.nan)] * 3
        elif kind == 3:
            names, arrays = [], [EMPTY] * 3
        elif kind == 4:
            arrays[which] = arrays[which][:rng.integers(7)]
        elif kind == 5:
            arrays[which][rng.integers(7)] = rng.choice([np.nan, np.inf, -np.inf])
        elif kind == 6:
            arrays[which] *= 10.0 ** rng.uniform(1, 308)
        elif kind == 7:
            arrays[which] = rng.normal(size=7) * (6.0, 40.0, 1000.0)[which]
        elif kind == 8:
            offset += int(rng.choice([1, MS, 100 * MS, 300 * MS, 10 ** 18]))
        elif kind == 9:
            offset -= int(rng.choice([1, 15 * MS, 100 * MS, 499 * MS, 600 * MS]))
        elif kind == 10:
            stamp = int(rng.integers(-2 ** 62, 2 ** 62))
        elif kind == 11:
            arrays[1] = EMPTY
        elif kind == 12:
            arrays[2] = [EMPTY, np.zeros(7), np.full(7, 1e-300)][which]
        elif kind in (13, 14):
            yield stamp + offset, names, *arrays
            arrays[2] = arrays[2] + (0.004 if kind == 13 else 0.0)
        yield stamp + offset, names, *arrays


@pytest.mark.parametrize('values', [{}, {'align': False, 'acceleration.cutoff': 50.0}],
                         ids=['default', 'unaligned'])
def test_hostile_messages(values):
    predictor = PredictorSettings({'stamps': 'header', **values}).predictor()
    total = Counter()
    with np.errstate(divide='raise', over='raise', invalid='raise'):
        for message in hostile(6000):
            before = predictor.counts.copy()
            step = predictor.handle(*message)
            prediction = step.prediction
            now = predictor.counts - before
            total += now
            # Each message is dropped, for one reason, or taken; and if it is taken, it gives a
            # prediction or, while the filter settles and at a repeated stamp, none.
            assert now['received'] == 1
            assert now['taken'] + sum(now[event] for event in DROPPED) == 1
            assert now['taken'] if step.dropped is None else now[step.dropped] == 1
            assert now['predicted'] == (prediction is not None) <= now['taken']
            assert now['predicted'] + sum(now[e] for e in (*RESETS, Event.REPEATED_STAMP)) <= 1
            if prediction is not None:
                assert all(array.shape == (7,) and np.isfinite(array).all() for array in (
                    prediction.q, prediction.qd, prediction.qdd, prediction.tau,
                    prediction.effort))
                assert prediction.residual is None or np.isfinite(prediction.residual).all()
    assert total == predictor.counts
    assert total['received'] == total['taken'] + sum(total[event] for event in DROPPED)
    assert total['predicted'] > 1000
    assert all(total[event] for event in DROPPED), 'not hostile enough'
    assert sum(total[event] for event in RESETS) > 10
    for stamp, arrays in stream(60):  # and good ones find it well
        prediction = predictor.handle(stamp, RIGHT, *arrays).prediction
    assert prediction.residual is not None
