"""Samples that continue the stream, restart it or are dropped; check of the velocity."""

from baxter_dynamics_ros.estimation.continuity import Continuity, VelocityCheck
from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import measured
import pytest

START = 1_700_000_000_000_000_000  # [ns]
MS = 1_000_000  # [ns]
RIGHT = joint_names('right')
Q = np.array([0.1, -0.5, 0.2, 1.0, -0.3, 0.4, 0.0])
QD = np.full(7, 0.3)
EFFORT = np.array([1.0, 20.0, 2.0, 8.0, 0.1, 0.5, 0.0])
CONFIRMED = {event: [Event.UNCONFIRMED, event] for event in Event}
GREATEST_SPEED = np.array([2.0, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0])  # [rad/s]


@pytest.fixture
def continuity():
    """Return one that has accepted a sample at START."""
    continuity = Continuity()
    assert continuity.judge(START, Q, QD, EFFORT) is None
    return continuity


def judge(continuity, after, q=Q, qd=QD, effort=EFFORT):
    """Judge a sample ``after`` nanoseconds after START."""
    return continuity.judge(START + after, q, qd, effort)


@pytest.mark.parametrize('after', [1, MS, 10 * MS, 250 * MS])
def test_continues_at_any_rate(continuity, after):
    assert judge(continuity, after) is None


def test_gap(continuity):
    assert judge(continuity, 250 * MS + 1) is Event.RESET_GAP
    assert judge(continuity, 260 * MS) is None


def test_stray_stamps_far_ahead_do_not_restart_the_stream(continuity):
    day = 24 * 3600 * 1000 * MS
    assert judge(continuity, day) is Event.UNCONFIRMED
    assert judge(continuity, 10 * MS) is None
    assert [judge(continuity, day + k * MS) for k in (20, 30)] == CONFIRMED[Event.RESET_GAP]
    assert [judge(continuity, k * MS) for k in (20, 30)] == CONFIRMED[Event.RESET_CLOCK_JUMP]
    assert judge(continuity, 40 * MS) is None


@pytest.mark.parametrize('late, event', [
    (1, Event.OUT_OF_ORDER), (100 * MS, Event.OUT_OF_ORDER), (500 * MS - 1, Event.OUT_OF_ORDER),
    (500 * MS, Event.UNCONFIRMED), (10_000 * MS, Event.UNCONFIRMED)])
def test_backwards(continuity, late, event):
    assert judge(continuity, -late) is event


def test_a_stray_message_is_dropped_alone(continuity):
    for k in range(1, 20):
        for now, change in ((100 * k, {'q': Q + 0.5}), (100 * k + 20, {'qd': None})):
            assert judge(continuity, now * MS, **change) is Event.UNCONFIRMED
            assert judge(continuity, (now + 10) * MS) is None
        assert judge(continuity, (100 * k - 600) * MS) is Event.UNCONFIRMED
        assert judge(continuity, (100 * k + 40) * MS) is None


def test_fifth_contradicting_message_restarts_the_stream(continuity):
    events = [judge(continuity, 10 * k * MS, q=Q + 0.5 * k) for k in range(1, 11)]
    assert events == 2 * (4 * [Event.UNCONFIRMED] + [Event.RESET_POSITION_JUMP])


def test_fifth_late_message_restarts_the_stream(continuity):
    events = [judge(continuity, (-100 + 10 * i) * MS) for i in range(6)]
    assert events == [Event.OUT_OF_ORDER] * 4 + [Event.RESET_CLOCK_JUMP, None]


@pytest.mark.parametrize('joint', range(7))
@pytest.mark.parametrize('dt_ms', [0, 1e-3, 1, 10, 250])
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_position_jump(continuity, joint, dt_ms, sign):
    # Stamps under 1 ms apart are times of arrival: the samples may be 30 ms apart.
    dt = (dt_ms if dt_ms >= 1 else 30) / 1000
    allowed = (sign * QD[joint] + 1.5 * GREATEST_SPEED[joint]) * dt + 0.02  # [rad]
    moved = Q + QD * dt
    moved[joint] = Q[joint] + sign * allowed * (1 + 1e-9)
    assert judge(continuity, int(dt_ms * MS), q=moved) is Event.UNCONFIRMED
    moved[joint] = Q[joint] + sign * allowed * (1 - 1e-9)
    assert judge(continuity, int(dt_ms * MS), q=moved) is (None if dt_ms else Event.REPEATED_STAMP)


def test_a_move_that_agrees_with_the_velocity_is_no_jump(continuity):
    fast = np.array([0.0, 0.0, 0.0, 0.0, 15.0, -20.0, 0.0])  # [rad/s]
    assert judge(continuity, 10 * MS, q=Q + 0.01 * fast, qd=fast) is None
    assert judge(continuity, 20 * MS, q=Q + 0.02 * fast, qd=-fast) is None
    assert judge(continuity, 30 * MS, q=Q + 0.02 * fast + 0.2, qd=-fast) is Event.UNCONFIRMED


def test_a_move_that_speeds_up_without_measured_velocity_is_no_jump():
    continuity, q = Continuity(), Q.copy()
    for k, speed in enumerate([0.0, 2.0, 4.0, 6.0, 8.0, 4.0, 0.0]):  # [rad/s]
        q = q + 0.01 * speed
        assert judge(continuity, 10 * k * MS, q=q, qd=None) is None
    assert judge(continuity, 70 * MS, q=q + 0.3, qd=None) is Event.UNCONFIRMED


@pytest.mark.parametrize('qd', [QD, None], ids=['velocity', 'no velocity'])
@pytest.mark.parametrize('effort', [EFFORT, None], ids=['effort', 'no effort'])
def test_same_stamp_same_data_is_dropped(qd, effort):
    continuity = Continuity()
    continuity.judge(START, Q, qd, effort)
    copies = [None if a is None else a.copy() for a in (Q, qd, effort)]
    for _ in range(10):  # any number, they are no sign of another clock
        assert continuity.judge(START, *copies) is Event.DUPLICATE


@pytest.mark.parametrize('change', [
    {'q': Q + 0.001}, {'qd': QD + 0.001}, {'effort': EFFORT + 0.004}, {'effort': None}],
    ids=['position', 'velocity', 'effort', 'no effort'])
def test_same_stamp_new_data_is_taken_and_remembered(continuity, change):
    assert judge(continuity, 0, **change) is Event.REPEATED_STAMP
    assert judge(continuity, 0, **change) is Event.DUPLICATE
    assert judge(continuity, 0) is Event.REPEATED_STAMP


@pytest.mark.parametrize('after', [0, 10 * MS])
def test_velocity_that_appears_or_disappears_restarts_the_stream(continuity, after):
    events = [judge(continuity, after + k * MS, qd=None) for k in (0, 10)]
    assert events == CONFIRMED[Event.RESET_VELOCITY_SOURCE]
    assert judge(continuity, after + 20 * MS, qd=None) is None
    events = [judge(continuity, after + k * MS) for k in (30, 40)]
    assert events == CONFIRMED[Event.RESET_VELOCITY_SOURCE]


# ---- measured velocity against positions

PERIOD = 0.01  # [s]
T = np.arange(0.0, 10.0, PERIOD)
WRONG = {'zero': lambda qd: 0.0 * qd, 'frozen': lambda qd: 0.0 * qd + 0.3,
         'rpm': lambda qd: qd * 30 / np.pi}


def played(spoil, until=len(T)):
    """Play a perfect robot whose velocity is wrong in the first messages."""
    predictor = Predictor(PredictorSettings(), external=True)
    made = []
    for k, (q, qd, effort) in enumerate(zip(*measured(PredictorSettings(), T))):
        made.append(predictor.handle(START + 10 * k * MS, RIGHT, q,
                                     spoil(qd) if k < until else qd, effort))
    return predictor, made


@pytest.mark.parametrize('spoil', WRONG.values(), ids=WRONG.keys())
def test_slope_of_positions_replaces_wrong_velocity(spoil):
    predictor, made = played(spoil)
    counts = predictor.counts
    assert counts[Event.VELOCITY_MISMATCH] > len(T) - 150
    assert counts[Event.RESET_VELOCITY_SOURCE] == 1
    mismatch = predictor.stream.velocity_check.mismatch
    assert abs(mismatch.moved - mismatch.integrated) > 0.05
    assert np.abs([step.prediction.residual for step in made[300:]]).max() < 0.5
    assert not any(step.external.contact for step in made[300:])


def test_measured_velocity_is_used_again_when_it_agrees():
    predictor, made = played(WRONG['zero'], until=400)
    assert predictor.counts[Event.RESET_VELOCITY_SOURCE] == 2
    assert predictor.stream.velocity_check.mismatch is None
    assert made[-1].state.qd is not None
    assert made[-1].delay_of(made[-1].estimate) == pytest.approx(0.059, abs=1e-3)


def test_frozen_positions_are_reported():
    predictor = Predictor(PredictorSettings())
    for k in range(200):
        predictor.handle(START + 10 * k * MS, RIGHT, np.zeros(7), np.full(7, 0.3),
                         np.full(7, 1.0 + 0.01 * (k % 3)))
    assert predictor.counts[Event.POSITION_FROZEN] > 100
    assert predictor.counts[Event.VELOCITY_MISMATCH] == 0


def test_velocity_that_lags_a_fast_small_motion_agrees():
    check, t = VelocityCheck(), np.arange(0.0, 3.0, 0.0025)
    w = 60.0  # [rad/s]; a joint that swings after a push of 200 N
    assert all(check.update(0.0025, np.full(7, q), np.full(7, qd)) for q, qd in zip(
        0.15 * np.sin(w * t), 0.15 * w * np.cos(w * (t - 0.014))))


@pytest.mark.parametrize('name', ['left_arm_tracking', 'point_to_point'])
def test_real_velocity_agrees(recordings, name):
    data = {key: value[:5000] if value.ndim else value
            for key, value in np.load(recordings / f'baxter_{name}.npz').items()}
    check, last = VelocityCheck(), None
    for q, qd, recording in zip(data['position'], data['velocity'], data['recording']):
        if recording != last:
            check.restart()
        last = recording
        assert check.update(float(data['period']), q, qd)
