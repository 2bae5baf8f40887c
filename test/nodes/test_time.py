"""Stamps of the node's messages, for all kinds of stamps of joint states."""

import time

from arrivals import bursts
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.retiming import FAR
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import rows, trajectory
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

START = 10 ** 18  # [ns]
EXTERNAL = '/torque_predictor/external_effort'
DELAY = 0.014 + np.sqrt(2) / (2 * np.pi * 5)  # of predictions [s]


def nanoseconds(t) -> list:
    """Return times t [s after START] as stamps."""
    return [START + round(x * 1e9) for x in t]


def test_times_of_arrival_are_recognised_and_re_timed(robot, predictor, stamps):
    t = np.arange(0.0, 6.0, 0.01)
    arrivals = bursts(t)
    sent, messages = nanoseconds(arrivals), rows(t)
    offline = Predictor(PredictorSettings())
    steps = [offline.handle(stamp, joint_names('right'), *row)
             for stamp, row in zip(sent, messages)]
    expected = [step.prediction.stamp_ns for step in steps if step.prediction]
    before = int(robot.report()['filter'][2]['reset_stamp_source'])
    # Faster than the stamps say: the node knows no clock but theirs.
    robot.stream(messages, pace=0.003, stamps=sent)
    robot.until(lambda: robot.statuses()[-1]['stamps'][:2] == (
        b'\x00', 'header stamps are times of arrival: re-timing them'))
    _, _, values = robot.statuses()[-1]['stamps']
    assert values['re-timed'] == 'True'
    assert float(values['period [s]']) == pytest.approx(0.01, rel=0.05)
    assert 0.01 < float(values['jitter of arrival [s]']) < 0.04
    assert float(values['delay of predictions [s]']) == pytest.approx(DELAY, abs=1e-4)
    assert float(values['delay of external effort [s]']) == pytest.approx(0.014, abs=1e-4)
    assert int(robot.statuses()[-1]['filter'][2]['reset_stamp_source']) == before + 1
    assert 'the stamp source changed' in predictor.output

    robot.until(lambda: len(robot.residual) == len(robot.predicted) == len(expected))
    assert stamps(robot.predicted) == stamps(robot.residual) == expected
    late = robot.predicted[-400:]
    when = (np.array(stamps(late)) - START) * 1e-9
    assert (np.diff(when) > 0.005).all()
    q, qd, _ = trajectory(when)
    lag = ((q - [m.position for m in late]) * qd).sum(1) / (qd * qd).sum(1)
    print(f'stamps lag by {lag.mean() * 1e3:.1f} ms, messages by '
          f'{np.mean(arrivals - t) * 1e3:.1f} ms')
    assert 0.0 < lag.mean() < np.mean(arrivals - t) + 0.003
    assert np.abs(lag - lag.mean()).max() < 0.02
    assert np.abs([m.effort for m in robot.residual][-400:]).max() < 0.3


def test_zero_stamps_become_the_time_of_arrival(robot, predictor, stamps):
    external = robot.listen(JointState, EXTERNAL)
    begin = time.time_ns()
    _, problem, values = robot.move_until_report(
        lambda report: robot.residual and external and report['input'][0] == b'\x01',
        rows(np.arange(0.0, 30.0, 0.01)), 0, 0)['input']
    end = time.time_ns()
    for message in (*robot.predicted, *robot.residual, *external):
        assert tuple(message.name) == joint_names('right')
        assert begin - FAR * 1e9 < stamps([message])[0] < end + FAR * 1e9
    assert stamps(robot.predicted)[-1] > end - 2 * 10 ** 9
    assert 'header stamps are zero' in problem
    assert int(values['unstamped']) > 0


def test_simulated_time_pauses_and_restarts(robot, stamps):
    robot.start_predictor('-p', 'use_sim_time:=true')
    external = robot.listen(JointState, EXTERNAL)
    clock = robot.create_publisher(Clock, '/clock', 10)
    t = np.arange(0.0, 2.0, 0.01)
    messages = rows(np.arange(0.0, 20.0, 0.01))
    sent = nanoseconds(t)

    def tick(stamp):
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(stamp, 10 ** 9)
        clock.publish(message)

    robot.until(lambda: tick(START) or stamps(robot.diagnostics[-1:]) == [START])
    robot.stream(messages[:100], pace=0.002, stamps=sent, before=tick)
    robot.until(lambda: len(robot.predicted) == 100 - 21)
    robot.diagnostics.clear()
    tick(sent[99])  # the simulator's clock stands still, the node continues
    robot.until(lambda: len(robot.diagnostics) >= 2
                and robot.statuses()[-1]['input'][0] == b'\x03')  # STALE
    assert {*stamps(robot.diagnostics)} == {sent[99]}
    assert len(robot.predicted) == 100 - 21

    robot.stream(messages[100:200], pace=0.002, stamps=sent[100:], before=tick)
    robot.until(lambda: len(robot.residual) == len(robot.predicted) == 200 - 21
                and len(external) == 200 - 2)
    assert stamps(robot.predicted) == stamps(robot.residual)
    assert np.abs(np.subtract(sent[21:], stamps(robot.predicted)) - DELAY * 1e9).max() <= 1
    assert set(np.subtract(sent[2:], stamps(external))) == {14_000_000}
    assert np.abs([m.effort for m in robot.residual][40:]).max() < 0.15
    report = robot.move_until_report(lambda report: report['stamps'][:2] == (
        b'\x00', 'using header stamps'), messages[200:], sent[-1] + 10_000_000)
    values = report['stamps'][2]
    assert float(values['delay of predictions [s]']) == pytest.approx(DELAY, abs=1e-4)
    assert float(values['delay of external effort [s]']) == pytest.approx(0.014, abs=1e-4)
    assert {count for key, count in report['filter'][2].items() if 'reset' in key} == {'0'}

    restarted = [stamp - START + 10_000_000 for stamp in sent[:60]]  # a simulation began anew
    robot.stream(messages[:60], pace=0.002, stamps=restarted, before=tick)
    robot.until(lambda: sum(stamp < START for stamp in stamps(robot.predicted))
                == 60 - 21 - 1)  # one message confirms the jump
    assert stamps(robot.predicted)[-1] < restarted[-1]
