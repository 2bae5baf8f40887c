"""Stamps of predictions, whatever the clocks do: each describes the motion at its stamp."""

from arrivals import bursts
from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import VELOCITY_LAG
from played import (assert_right, assert_same, back_steps, DELAY, instants, play, RIGHT, robot,
                    Run, SETTINGS, stacked)
import pytest

LEFT = joint_names('left')
BOTH = ('head_nod', 'head_pan', *LEFT[::-1], *RIGHT[::-1], 'torso_t0')
SETTLING = 21  # messages at 100 Hz without a prediction, once the filter starts anew
LOCKING = 1.45  # time without predictions: locking and settling [s]

pytestmark = pytest.mark.filterwarnings('error')


T = np.arange(550) * 0.01  # [s]
ARRIVALS = bursts(T)
LATE = np.mean(ARRIVALS - T)  # 8 ms
JUMPS = {'0.3 s back': -0.3, '5 s back': -5.0, '1 s ahead': 1.0, 'days ahead': 1e6}


def jumped(stamps, at, by):
    """Return stamps of a clock that is set from message ``at`` on."""
    return np.where(np.arange(len(stamps)) < at, stamps, stamps + by)


# ---- instant of a prediction

@pytest.mark.parametrize('rate', [50.0, 400.0])
def test_header_stamps_give_the_instant(rate):
    t = np.arange(int(1.5 * rate)) / rate
    run = play(robot(t, t), 'auto')
    assert_right(run)
    assert not run.counts()
    np.testing.assert_allclose(instants(run.predictions) + DELAY, t[list(run.predictions)],
                               atol=1e-8)
    np.testing.assert_allclose(instants(run.external) + VELOCITY_LAG, t[list(run.external)],
                               atol=1e-8)


@pytest.mark.parametrize('rate', [50.0, 400.0])
def test_re_timed_stamps_give_the_instant_plus_the_transport_delay(rate):
    t = np.arange(int(3.5 * rate)) / rate
    arrivals = bursts(t)
    run = play(robot(t, arrivals), 'arrival')
    assert t[run.withheld(0)] < LOCKING
    assert_right(run.since(int(2 * rate)), late=np.mean(arrivals - t))
    assert not back_steps(run.predictions) and not back_steps(run.external)
    assert not run.counts()
    # The same arrivals, used as header stamps, give wrong instants.
    as_header = play(robot(t, arrivals), 'header').since(int(2 * rate))
    assert max(np.abs(p.residual).max() for p in as_header.predictions.values()) > 1.5


def test_recognised_arrivals_give_the_results_of_mode_arrival():
    messages = robot(T, ARRIVALS)
    run, known = play(messages, 'auto'), play(messages, 'arrival')
    assert run.counts().pop(Event.RESET_STAMP_SOURCE) == 1
    assert {*run.counts()} == {Event.RESET_STAMP_SOURCE, Event.REPEATED_STAMP}
    assert max(i for i in run.external if i < 80) < 50  # until they were recognised
    assert run.withheld(50) == known.withheld(50)
    assert_same(run.since(80), known.since(80))


# ---- a clock that jumps, a bag that loops

DROPPED = {by: {Event.OUT_OF_ORDER: 4} if by == -0.3 else {Event.UNCONFIRMED: 1}
           for by in JUMPS.values()}


@pytest.mark.parametrize('by', JUMPS.values(), ids=JUMPS.keys())
def test_robots_clock_jumps(by):
    messages = robot(T[:300], jumped(T[:300], 200, by))
    run = play(messages, 'auto')
    # Less than 0.5 s back may be late messages: the fifth in a row is accepted.
    doubted = 4 if by == -0.3 else 1
    event = Event.RESET_GAP if by > 0 else Event.RESET_CLOCK_JUMP
    assert run.counts() == {event: 1} | DROPPED[by]
    assert run.withheld(200) == doubted + SETTLING
    assert_same(run.since(200 + doubted), play(messages[200 + doubted:], 'auto'))
    assert_right(run.since(200), ahead=by)
    for of in (run.predictions, run.external):
        first = min(i for i in of if i >= 200)
        assert [*back_steps(of)] == ([first] if by < 0 else [])


@pytest.mark.parametrize('by, at', [*zip(JUMPS.values(), [250, 250, 290, 290]), (-0.3, 271)],
                         ids=[*JUMPS, '0.3 s back, later'])
def test_clock_of_arrivals_jumps(by, at):
    messages = robot(T, jumped(ARRIVALS, at, by))
    run = play(messages, 'arrival')
    event = Event.RESET_GAP if by > 0 else Event.RESET_CLOCK_JUMP
    assert run.counts() == {event: 1, Event.RESET_RESYNC: 1} | DROPPED[by]
    assert 1.1 < run.withheld(at) * 0.01 < LOCKING
    if by != -0.3:  # the fifth may still be near the line, which then restarts later
        assert_same(run.since(at + 1), play(messages[at + 1:], 'arrival'))
    assert_right(run.since(at), ahead=by, late=LATE)
    for of in (run.predictions, run.external):
        first = min(i for i in of if i >= at)
        assert [*back_steps(of)] == ([first] if by == -5.0 else [])


@pytest.mark.parametrize('stamps, mode, event, withheld', [
    (np.tile(T[:350], 2), 'auto', {Event.RESET_CLOCK_JUMP: 1}, (SETTLING, SETTLING)),
    (np.tile(ARRIVALS[:350], 2), 'arrival', {Event.RESET_CLOCK_JUMP: 1, Event.RESET_RESYNC: 1},
     (110, 145)),
    # Stamped when it is played: the line goes on, and the arm is elsewhere.
    (bursts(T), 'arrival', {Event.RESET_POSITION_JUMP: 1}, (SETTLING, SETTLING + 1))],
    ids=['stamps', 'recorded arrivals', 'arrivals'])
def test_a_bag_loops(stamps, mode, event, withheld):
    messages = robot(np.tile(T[:350], 2), stamps)
    run = play(messages, mode)
    assert run.counts() == event | {Event.UNCONFIRMED: 1}
    assert withheld[0] <= run.withheld(351) <= withheld[1]
    if Event.RESET_CLOCK_JUMP in event:
        assert_same(run.since(351), play(messages[351:], mode))
    if mode == 'auto':
        assert_right(run)
    else:
        ahead = 3.5 if Event.RESET_POSITION_JUMP in event else 0.0
        assert_right(run.since(350), ahead=ahead, late=LATE)
    for of in (run.predictions, run.external):
        assert len(back_steps(of)) == (Event.RESET_CLOCK_JUMP in event)


# ---- simulated time that pauses

@pytest.mark.parametrize('mode', SETTINGS)
def test_repeated_messages_in_a_pause_change_nothing(mode):
    messages = robot(T, ARRIVALS if mode == 'arrival' else T)
    paused = messages[:301] + [messages[300]] * 200 + messages[301:]
    run, wanted = play(paused, mode), play(messages, mode)
    assert run.counts() == {Event.DUPLICATE: 200}
    assert not [i for i in (*run.predictions, *run.external) if 300 < i <= 500]
    assert_same(run.since(501), wanted.since(301))


def paused():
    """Return messages, and the same with 100 noisy efforts at one stamp."""
    messages = robot(T, T)
    noise = np.random.default_rng(0).normal(0.0, 0.02, (100, 7))
    return messages, messages[:301] + [
        (*messages[300][:4], messages[300][4] + row) for row in noise] + messages[301:]


def test_noisy_messages_in_a_pause_change_nothing_with_header_stamps():
    messages, with_noise = paused()
    run, wanted = play(with_noise, 'header'), play(messages, 'header')
    assert run.counts() == {Event.REPEATED_STAMP: 100}
    assert not [i for i in run.predictions if 300 < i <= 400]
    for i, prediction in wanted.since(301).predictions.items():
        found = run.predictions[401 + i]
        assert found.stamp_ns == prediction.stamp_ns
        np.testing.assert_allclose(found[1:4], prediction[1:4], rtol=1e-12)
        np.testing.assert_allclose(found.residual, prediction.residual, atol=0.1)


# ---- another rate

FASTER = np.concatenate([np.arange(200) * 0.01, 2.0 + np.arange(800) * 0.0025])  # [s]
SLOWER = np.concatenate([np.arange(800) * 0.0025, 2.0 + np.arange(250) * 0.01])  # [s]


@pytest.mark.parametrize('t', [FASTER, SLOWER], ids=['100 to 400 Hz', '400 to 100 Hz'])
def test_robot_changes_its_rate(t):
    run = play(robot(t, t), 'auto')
    assert not run.counts()
    first = run.withheld(0)
    assert t[first] < 0.22
    assert list(run.predictions) == list(range(first, len(t)))
    assert_right(run)


# ---- several publishers

@pytest.mark.parametrize('mode', ['auto', 'arrival'])
def test_messages_of_other_joints_change_nothing(mode):
    messages = robot(T, ARRIVALS if mode == 'arrival' else T)
    mixed, numbers = [], []
    random = np.random.default_rng(0)
    for k, (stamp, names, *row) in enumerate(messages):
        noise = random.normal(size=(3, 17))
        mixed.append((stamp - 10 ** 6, ('l_gripper_l_finger_joint',), *noise[:, :1]))
        mixed.append((stamp + 10 ** 9, LEFT, *noise[:, :7]))
        mixed.append((stamp, ('right_s1',), *noise[:, 1:2]))
        numbers.append(len(mixed))
        if k % 3:  # of 17 joints, or of the arm's seven
            noise[:, [BOTH.index(name) for name in RIGHT]] = row
            mixed.append((stamp, BOTH, *noise))
        else:
            mixed.append((stamp, names, *row))
    run, wanted = play(mixed, mode), play(messages, mode)
    assert run.counts() == {Event.NOT_THIS_ARM: 1100, Event.INCOMPLETE_ARM: 550}
    assert run.predictor.counts['taken'] == 550
    assert {*run.predictions, *run.external} <= {*numbers}
    found = Run(run.predictor, *({k: of[i] for k, i in enumerate(numbers) if i in of}
                                 for of in run[1:]))
    assert_same(found, wanted)


@pytest.mark.parametrize('apart', [0.0, 0.5])  # [rad]
def test_two_publishers_of_the_same_arm(apart):
    t = np.sort(np.concatenate([T[:250], T[:250] + 0.003]))
    run = play([(stamp, names, q + k % 2 * apart, *others)
                for k, (stamp, names, q, *others) in enumerate(robot(t, t))], 'auto')
    assert run.counts() == ({Event.UNCONFIRMED: 250} if apart else {})
    assert len(run.predictions) > (200 if apart else 400)
    assert_right(run)
    assert not any(external.contact for external in run.external.values())


# ---- lost messages

def test_lost_messages_cause_a_bounded_error_of_re_timing():
    share, most = 0.05, 0.6  # of the messages; [N m]
    t = np.arange(1000) * 0.01
    kept = np.random.default_rng(1).uniform(size=len(t)) >= share
    run = play(robot(t[kept], bursts(t)[kept]), 'arrival')
    assert not run.counts()
    residual, = stacked(run.since(300).predictions, 'residual')
    rms = np.sqrt(np.mean(residual ** 2, axis=0))
    print(f'{share:.0%} lost: residual', rms.round(3), 'N m RMS')
    assert rms.max() < most
    assert run.predictor.stream.clock.period == pytest.approx(0.01 / (1 - share), rel=0.03)


# ---- late recognition

def test_arrivals_that_begin_later_are_recognised_without_a_pause():
    run = play(robot(T, np.concatenate([T[:350], bursts(T[350:])])), 'auto')
    assert run.counts()[Event.RESET_STAMP_SOURCE] == 1
    assert np.diff(list(run.predictions)).max() < SETTLING + 10
    assert_right(Run(None, *({i: made for i, made in of.items() if i < 350} for of in run[1:])))
    assert_right(run.since(450), late=LATE)
    assert not back_steps(run.predictions) and not back_steps(run.external)
