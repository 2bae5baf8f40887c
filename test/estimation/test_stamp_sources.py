"""Sources of stamps: receipt for useless header stamps, and the return to header stamps."""

import gc
import tracemalloc

from arrivals import bursts, JITTER
from baxter_dynamics_ros.estimation.events import DROPPED, Event
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import measured
import pytest

RIGHT = joint_names('right')
START = 1_700_000_000 * 10 ** 9  # [ns]
RECEIPT = 5 * 10 ** 9  # difference of the receiver's clock to the robot's [ns]
T = np.arange(0.0, 8.0, 0.01)
ROWS = list(zip(*measured(PredictorSettings(), T)))


def nanoseconds(t):
    """Return times t [s] as stamps."""
    return START + np.round(t * 1e9).astype(int)


def play(stamps, mode='auto', rows=ROWS, receipts=bursts(T)):
    """Play rows with stamps [ns] and times of receipt [s]; return predictor, predictions."""
    predictor = Predictor(PredictorSettings.from_parameters({'stamps': mode}), external=True)
    predictions = [
        predictor.handle(int(stamp), RIGHT, *row,
                         START + RECEIPT + round(receipt * 1e9)).prediction
        for stamp, row, receipt in zip(stamps, rows, receipts)]
    return predictor, predictions


def rms(predictions, last=300):
    """Return the RMS of the residual of s0 in the last predictions [N m]."""
    return np.sqrt(np.mean([p.residual[0] ** 2 for p in predictions[-last:]]))


USELESS = {
    'stand still': np.full(len(T), START),
    '+1 ns': START + np.arange(len(T)),
    '+100 ns': START + 100 * np.arange(len(T)),
    'whole seconds': START + 10 ** 9 * np.floor(T).astype(int),
    'zero': np.zeros(len(T), dtype=int),
}


@pytest.mark.parametrize('stamps', USELESS.values(), ids=USELESS.keys())
def test_receipt_is_used_where_stamps_stand_still(stamps):
    predictor, predictions = play(stamps)
    assert predictor.stream.clock.source == 'receipt'
    assert predictor.counts[Event.RESET_STAMP_SOURCE] in (1, 2)  # perhaps arrival first
    assert all(p is not None for p in predictions[350:])
    steps = np.diff([p.stamp_ns for p in predictions[350:]]) * 1e-9
    assert steps.min() > 0.008 and steps.max() < 0.012
    assert predictions[-1].stamp_ns == pytest.approx(START + RECEIPT + T[-1] * 1e9, abs=1e8)
    assert rms(predictions) < 0.2


def test_receipt_needs_no_header_stamps():
    _, from_stamps = play(nanoseconds(bursts(T)), 'arrival')
    _, from_receipts = play(np.zeros(len(T)), 'receipt')
    for found, wanted in zip(from_receipts, from_stamps):
        assert (found is None) == (wanted is None)
        if found is not None:
            assert abs(found.stamp_ns - wanted.stamp_ns - RECEIPT) < 1000
            np.testing.assert_allclose(found.residual, wanted.residual, atol=1e-4)


def test_one_stall_of_the_receiver_does_not_discredit_stamps():
    receipts = T.copy()
    receipts[400:500] = T[500]
    predictor, predictions = play(nanoseconds(T), receipts=receipts)
    assert predictor.stream.clock.source == 'header'
    assert not predictor.counts[Event.RESET_STAMP_SOURCE]
    assert sum(p is None for p in predictions) == 21


@pytest.mark.parametrize('wrong', ['bursts', 'still'])
def test_even_steps_restore_trust_in_header_stamps(wrong):
    t = np.arange(0.0, 12.5, 0.01)
    rows = list(zip(*measured(PredictorSettings(), t)))
    true = nanoseconds(t + np.random.default_rng(0).normal(0.0, JITTER, len(t)))
    stamps = true.copy()
    stamps[:500] = nanoseconds(bursts(t))[:500] if wrong == 'bursts' else START
    predictor, predictions = play(stamps, rows=rows, receipts=t)
    assert predictor.stream.clock.source == 'header'
    instants = np.array([p.stamp_ns for p in predictions[1100:]])
    assert np.ptp(true[1100:] - instants) <= 1


def test_a_burst_of_stray_messages_is_forgotten():
    """Four stray messages in 0.6 ms, and from then on 5 % of the messages are lost."""
    t = np.arange(0.0, 15.0, 0.01)
    rows = list(zip(*measured(PredictorSettings(), t)))
    stamps = nanoseconds(t)
    kept = np.random.default_rng(1).uniform(size=len(t)) > 0.05
    kept[:300] = True
    clean = list(zip(stamps[kept], [rows[i] for i in np.flatnonzero(kept)]))
    q, qd, effort = rows[200]
    burst = [(stamps[200] + k * 150_000, (q, qd, effort + 0.01 * k)) for k in range(1, 5)]
    figures = []
    for messages in (clean, clean[:201] + burst + clean[201:]):
        predictor = Predictor(PredictorSettings())
        predictions = [predictor.handle(int(stamp), RIGHT, *row).prediction
                       for stamp, row in messages]
        figures.append(rms([p for p in predictions if p is not None], 500))
    print(f'RMS of s0 without and with a burst: {figures[0]:.4f}, {figures[1]:.4f} N m')
    assert predictor.counts[Event.RESET_STAMP_SOURCE] == 2  # to arrival and back
    assert figures[1] == pytest.approx(figures[0], rel=1e-6)


@pytest.mark.parametrize('mode, step', [('auto', 0), ('header', 1), ('header', 10 ** 7)])
def test_memory_does_not_grow(mode, step):
    predictor = Predictor(PredictorSettings.from_parameters({'stamps': mode}), external=True)
    random = np.random.default_rng(0)

    def send(n, first):
        for k in range(first, first + n):
            q, qd, effort = ROWS[k % len(ROWS)]
            predictor.handle(START + step * k, RIGHT, q, np.empty(0) if step == 1 else qd,
                             effort + random.uniform(0.0, 0.01), START + 10 ** 7 * k)
    send(1100, 0)
    tracemalloc.start()
    send(300, 1100)
    gc.collect()
    before, _ = tracemalloc.get_traced_memory()
    send(300, 1400)
    gc.collect()
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 300 * 20  # [bytes]


def test_rates_above_the_robots_are_predicted():
    t = np.arange(0.0, 1.6, 0.00025)
    rows = list(zip(*measured(PredictorSettings(), t)))
    predictor, predictions = play(nanoseconds(t), rows=rows, receipts=t)
    assert all(p is not None for p in predictions[-500:])
    assert rms(predictions, 500) < 0.2
    counts = predictor.counts
    assert counts['received'] == len(t) == counts['taken'] + sum(counts[e] for e in DROPPED)
