"""Stream: samples, reasons to drop messages, re-timed stamps, and counts."""

from arrivals import bursts, Retiming
from baxter_dynamics_ros.estimation.events import Event, RESETS
from baxter_dynamics_ros.estimation.stream import State, Stream
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

START = 1_700_000_000_000_000_000  # [ns]
MS = 1_000_000  # [ns]
RIGHT = joint_names('right')
Q = np.array([0.1, -0.5, 0.2, 1.0, -0.3, 0.4, 0.0])
QD = np.full(7, 1e-3)
EFFORT = np.array([1.0, 20.0, 2.0, 8.0, 0.1, 0.5, 0.0])
EMPTY = np.empty(0)
ARRIVALS = [round(x * 1e9) for x in bursts(0.01 * np.arange(600))]  # [ns]
LOCKED = 110  # messages at 100 Hz, after which arrivals are re-timed


def take(stream, after, q=Q, qd=QD, effort=EFFORT, names=RIGHT):
    """Return the sample of a joint state stamped ``after`` [ns] after START, or None."""
    found = stream.take(START + after, names, q, qd, effort)
    return found if isinstance(found, State) and found.dt is not None else None


def even(stream, n=LOCKED, since=0):
    """Take n different joint states, 10 ms apart; return the samples."""
    return [take(stream, 10 * MS * i, effort=EFFORT + 0.004 * (i % 7))
            for i in range(since, since + n)]


@pytest.fixture(params=['header', 'auto'])
def stream(request):
    """Return one that has accepted a sample at START and uses header stamps."""
    stream = Stream('right', request.param)
    assert take(stream, 0).begins
    return stream


# ---- samples

def test_a_sample_is_the_state_and_the_step_to_it(stream):
    for after, dt in ((10, 0.010), (13, 0.003), (250, 0.237)):
        sample = take(stream, after * MS)
        assert not sample.begins
        assert sample.dt == pytest.approx(dt, abs=1e-12)
        assert sample.stamp_ns == START + after * MS
    for found, wanted in zip(sample[1:], (Q, QD, EFFORT)):
        np.testing.assert_array_equal(found, wanted)
    assert stream.counts == {'received': 4, 'taken': 4}


@pytest.mark.parametrize('message, event, field', [
    ({'effort': EMPTY}, Event.EFFORT_MISSING, 'effort'),
    ({'effort': np.zeros(7)}, Event.EFFORT_ALL_ZERO, 'effort'),
    ({'qd': EMPTY}, Event.VELOCITY_MISSING, 'qd')], ids=lambda x: getattr(x, 'value', None))
def test_missing_fields_are_counted_and_the_others_used(message, event, field):
    stream = Stream('right', 'auto')
    samples = [take(stream, 10 * MS * i, **message) for i in range(3)]
    assert all(getattr(sample, field) is None for sample in samples)
    assert stream.counts == {'received': 3, 'taken': 3, event: 3}


# ---- dropped messages

FAULTS = {
    Event.NOT_THIS_ARM: {'names': joint_names('left'), 'q': EMPTY},
    Event.DUPLICATE_JOINT: {'names': RIGHT[:6] + RIGHT[:1], 'q': Q[:3]},
    Event.INCOMPLETE_ARM: {'names': RIGHT[:6], 'q': Q[:3]},
    Event.LENGTH_MISMATCH: {'q': np.full(6, np.nan)},
    Event.NON_FINITE: {'q': np.array([np.nan, 99.0, 0.0, 0.0, 0.0, 0.0, 0.0])},
    Event.IMPLAUSIBLE: {'q': Q + 99.0},
}


@pytest.mark.parametrize('after', [-700, -100, 0, 10, 999], ids=lambda ms: f'{ms} ms')
@pytest.mark.parametrize('event', FAULTS, ids=lambda event: event.value)
def test_fields_are_validated_before_the_stamp(stream, event, after):
    assert take(stream, after * MS, **FAULTS[event]) is None
    assert stream.counts == {'received': 2, 'taken': 1, event: 1}
    sample = take(stream, 20 * MS)  # it is forgotten
    assert sample.dt == pytest.approx(0.02) and not sample.begins


@pytest.mark.parametrize('after, change, event', [
    (251, {'q': Q + 0.5, 'qd': EMPTY}, Event.RESET_GAP),
    (-600, {'q': Q + 0.5, 'qd': EMPTY}, Event.RESET_CLOCK_JUMP),
    (10, {'q': Q + 0.5, 'qd': EMPTY}, Event.RESET_VELOCITY_SOURCE),
    (10, {'q': Q + 0.5}, Event.RESET_POSITION_JUMP),
    (0, {'q': Q + 0.5}, Event.RESET_POSITION_JUMP)],
    ids=lambda x: getattr(x, 'value', None))
def test_one_reason_for_a_restart_is_counted(stream, after, change, event):
    if event is not Event.RESET_GAP:
        assert take(stream, after * MS, **change) is None
        assert stream.counts[Event.UNCONFIRMED] == 1
        after += 10
    sample = take(stream, after * MS, **change)
    assert sample.begins and sample.stamp_ns == START + after * MS
    assert {e: stream.counts[e] for e in RESETS if stream.counts[e]} == {event: 1}
    following = take(stream, (after + 10) * MS, **change)
    assert not following.begins and following.dt == pytest.approx(0.01)
    assert stream.counts['taken'] == 3


# ---- re-timed stamps

@pytest.mark.parametrize('mode', ['auto', 'arrival'])
def test_stamps_are_the_clocks(mode):
    stream, clock = Stream('right', mode), Retiming(mode)
    last = None
    begun = []
    for i, after in enumerate(ARRIVALS[:600]):
        wanted = clock.update(START + after, True)
        sample = take(stream, after, q=Q + 1e-4 * (i % 10))
        assert (sample is None) == (wanted is None)
        if sample is None:
            continue
        assert sample.stamp_ns == wanted
        assert sample.begins == clock.restarted
        if sample.begins:
            begun.append(i)
        else:
            assert sample.dt == pytest.approx((wanted - last) * 1e-9, abs=1e-12)
        last = wanted
    assert stream.counts['taken'] == stream.counts['received'] == 600
    if mode == 'auto':
        assert begun[0] == 0 and stream.counts[Event.RESET_STAMP_SOURCE] == 1
        assert 0 < stream.counts[Event.REPEATED_STAMP] < 30  # before they were recognised
    else:
        assert stream.counts == {'received': 600, 'taken': 600, Event.AWAITING_PERIOD: begun[0]}
    assert 90 < begun[-1] < 130 and len(begun) == (2 if mode == 'auto' else 1)


def test_a_gap_while_the_period_is_unknown_causes_one_restart():
    stream = Stream('right', 'arrival')
    even(stream, 50)
    samples = even(stream, 150, since=80)  # 0.3 s later
    begun = [i for i, sample in enumerate(samples) if sample is not None and sample.begins]
    assert len(begun) == 1 and 95 < begun[0] < 105
    assert stream.counts[Event.RESET_GAP] == 1
    assert stream.counts[Event.RESET_RESYNC] == 0  # no line was in use


@pytest.mark.parametrize('moved, jumps', [(0.045, False), (0.055, True)])
def test_position_jumps_are_judged_by_the_period(moved, jumps):
    # Arrivals 2 ms apart of messages that are 10 ms apart: 2 rad/s * 1.5 * 10 ms + 0.02 rad.
    q = Q + [moved, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    stream = Stream('right', 'arrival')
    even(stream)
    late = 10 * MS * LOCKED + 8 * MS
    assert not take(stream, late).begins
    assert (take(stream, late + 2 * MS, q=q) is None) == jumps
    stream = Stream('right', 'header')
    even(stream)
    take(stream, late)
    assert take(stream, late + 2 * MS, q=q) is None


# ---- reset

def test_reset_forgets_the_stream_and_keeps_the_counts(stream):
    stream.reset()
    assert take(stream, -100 * MS, q=Q + 1.0).begins
    assert not take(stream, -90 * MS, q=Q + 1.0).begins
    assert stream.counts == {'received': 3, 'taken': 3, Event.RESET_REQUESTED: 1}
