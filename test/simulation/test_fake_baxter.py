"""The fake Baxter behaves as the real one was measured to."""

from dataclasses import replace
import tracemalloc

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import ArgumentError, EffortModel, joint_names
import numpy as np
import pytest

mujoco = pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.description import (  # noqa: E402, I100
    DescriptionError, find_description)
from baxter_dynamics_ros.simulation.plant import default_truth, Plant, Sensors  # noqa: E402
from baxter_dynamics_ros.simulation.robot import (  # noqa: E402
    FakeBaxter, GRIPPER_NAMES, JOINT_STATE_NAMES, record)
from baxter_dynamics_ros.simulation.trajectories import JointTrajectory  # noqa: E402

PERIOD = 0.01  # [s]
ORDER = [JOINT_STATE_NAMES.index(name) for name in joint_names('right')]
LOAD = Payload(1.1, (0.04, -0.03, 0.08), (0.05, 0.045, 0.04, 0.012, -0.01, 0.008))
TILTED = (0.3, -0.2, -9.8)  # [m/s^2]
CABLES = EffortModel(stiffness=[2.0, -1.5, 1.0, 0.8, 0.4, -0.3, 0.2])


def run(robot, seconds, side='right'):
    """Return q, qd, effort (n, 7) of one arm as published."""
    order = [JOINT_STATE_NAMES.index(name) for name in joint_names(side)]
    start, rows = robot.time, []
    for k in range(1, round(seconds / PERIOD) + 1):
        robot.advance(start + k * PERIOD)
        rows.append([field[order] for field in robot.joint_state()])
    return np.array(rows).transpose(1, 0, 2)


def test_publishes_the_robots_17_joints_in_its_order():
    assert ' '.join(JOINT_STATE_NAMES) == (
        'head_nod head_pan left_e0 left_e1 left_s0 left_s1 left_w0 left_w1 left_w2 right_e0 '
        'right_e1 right_s0 right_s1 right_w0 right_w1 right_w2 torso_t0')
    assert all(field.shape == (17,) for field in FakeBaxter(trajectory='hold').joint_state())


def test_velocity_lags_position_by_13_and_a_half_milliseconds():
    sensors, velocity, t = Sensors(noise=False), [], 0.001 * np.arange(4000)
    for now in t:
        sensors.read(np.full(7, np.sin(3 * now)))
        velocity.append(sensors.publish(np.zeros(7))[1][0])
    lags = np.arange(0.0, 0.03, 1e-4)
    error = [np.sum((np.array(velocity[100:]) - 3 * np.cos(3 * (t[100:] - lag))) ** 2)
             for lag in lags]
    assert lags[np.argmin(error)] == pytest.approx(0.0135, abs=2e-4)


def test_noise_and_quanta_at_rest_are_those_measured():
    sensors, rows = Sensors(seed=3), []
    for _ in range(3000):
        for _ in range(10):
            sensors.read(np.full(7, 0.3))
        rows.append(np.array(sensors.publish(np.full(7, 2.0))))
    q, qd, effort = np.array(rows).transpose(1, 0, 2)
    quantum = 2 * np.pi / 16384
    np.testing.assert_allclose(q / quantum, np.round(q / quantum), atol=1e-9)
    np.testing.assert_allclose(effort / 0.004, np.round(effort / 0.004), atol=1e-9)
    np.testing.assert_allclose(qd.std(0), 0.013, rtol=0.1)
    np.testing.assert_allclose(
        effort.std(0), [0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011], rtol=0.1)


def test_readings_that_nobody_publishes_take_no_memory():
    sensors = Sensors()
    tracemalloc.start()
    for _ in range(20_000):
        sensors.read(np.zeros(7))
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


@pytest.mark.parametrize('truth, settings, least, most', [
    (EffortModel.rigid(), {'effort_model.enabled': False}, 0.0, 0.02),
    (default_truth(friction=False), {}, 0.0, 0.02),
    (default_truth(), {}, 0.2, 0.8)], ids=['rigid', 'spring', 'friction'])
def test_residual_is_the_friction_that_the_predictor_does_not_know(truth, settings, least, most):
    robot = FakeBaxter(noise=False, truth=truth)
    predictor, residuals = Predictor(PredictorSettings.from_parameters(settings)), []
    for k in range(1, 501):
        robot.advance(k * PERIOD)
        prediction = predictor.handle(round(k * PERIOD * 1e9), JOINT_STATE_NAMES,
                                      *robot.joint_state()).prediction
        if prediction is not None:
            residuals.append(prediction.residual)
    rms = np.sqrt(np.mean(np.square(residuals), axis=0))
    assert least <= rms[1] and rms.max() < most


@pytest.mark.parametrize('side, changes, force, torque', [
    ('right', {}, 0.0, 0.0),
    ('left', {'payload': LOAD, 'gravity': TILTED, 'truth': CABLES}, 0.0, 0.0),
    ('right', {}, [3.0, -5.0, -10.0], [1.0, -3.0, 1.0, -2.0, 0.3, 0.2, -0.1]),
], ids=['spring', 'payload, tilt, cables', 'external loads'])
def test_effort_at_rest_balances_gravity_springs_and_loads(side, changes, force, torque):
    robot = {'truth': default_truth(friction=False), **changes}
    fake = FakeBaxter(side, 'hold', noise=False, **robot)
    truth = robot.pop('truth')
    arm = BaxterArm(mount=mount(side), **robot)
    _, qd, _ = run(fake, 0.1, side)
    assert np.abs(qd).max() < 1e-3  # at rest from the start
    fake.plant.force, fake.plant.torque = np.zeros(3) + force, np.zeros(7) + torque
    q, _, effort = (row[-1] for row in run(fake, 3.0 if np.any(force) else 0.1, side))
    expected = (arm.gravity(q) + truth.spring(q) + truth.stiffness * q
                - arm.jacobian(q)[:3].T @ fake.plant.force - fake.plant.torque)
    np.testing.assert_allclose(effort, truth.coupled(expected), atol=0.05)


@pytest.mark.parametrize('rate', [50.0, 1000.0])
def test_a_recording_is_what_the_robot_publishes_from_where_it_is(rate):
    robots = [FakeBaxter(seed=2) for _ in range(3)]
    for robot in robots:
        robot.advance(0.1)
    first, second = (list(record(robot, 30.0 / rate, rate, seed=4)) for robot in robots[:2])
    for a, b in zip(first, second, strict=True):
        assert a[:2] == b[:2]
        np.testing.assert_array_equal(a[2:], b[2:])
    assert robots[0].time == pytest.approx(0.1 + 30.0 / rate)
    arms = [message for message in first if message[1] == JOINT_STATE_NAMES]
    assert len(arms) == 30
    for k, message in enumerate(arms):
        robots[2].advance(0.1 + (k + 1) / rate)
        np.testing.assert_array_equal(message[2:], robots[2].joint_state())


def test_a_recording_has_the_robots_stamps_and_repeats_by_its_seed():
    messages, other = (list(record(FakeBaxter(), 1.5, 200.0, seed)) for seed in (4, 5))
    stamps = np.array([stamp for stamp, *_ in messages]) - 10 ** 18
    assert (np.diff(stamps) > 0).all() and [m[0] for m in messages] != [m[0] for m in other]
    is_arm = np.array([names == JOINT_STATE_NAMES for _, names, *_ in messages])
    jitter = stamps[is_arm] - np.arange(1, 301) / 200.0 * 1e9
    assert 3e-5 < jitter.std() * 1e-9 < 5e-5
    assert {names for _, names, *_ in messages} == {JOINT_STATE_NAMES, GRIPPER_NAMES}
    np.testing.assert_allclose(np.diff(stamps[~is_arm]), 1e9 / 38, atol=1.0)
    assert np.count_nonzero(~is_arm) == 57


@pytest.mark.parametrize('change, problem', [
    (('<robot', 'robot'), 'wrong.urdf: cannot be read as URDF'),
    (('"right_s0"', '"s0"'), "wrong.urdf: no revolute joint right_s0; is it a Baxter's URDF"),
    (('"right_s1" type="revolute"', '"right_s1" type="fixed"'), 'no revolute joint right_s1'),
    (('<child link="right_wrist"', '<child'), 'wrong.urdf: joint right_w2 has no child link'),
    (('right_hand', 'right_tool'), 'wrong.urdf: no link right_hand'),
    (('rpy="0 0 0"', 'rpy="x"'), "description: XML Error: .* 'rpy' Element 'origin'$")])
def test_refuses_a_file_that_is_no_description_of_a_baxter(tmp_path, change, problem):
    wrong = tmp_path / 'wrong.urdf'
    wrong.write_text(find_description().read_text().replace(*change))
    with pytest.raises(DescriptionError, match=problem):
        FakeBaxter(description=wrong)


def with_truth(trajectory='hold', **truth):
    """Return a fake Baxter with these terms of the effort and neither spring nor noise."""
    model = replace(EffortModel.rigid(), **truth)
    return FakeBaxter(trajectory=trajectory, noise=False, truth=model)


def one(joint, value):
    """Return (7,) with a value at one joint and zeros elsewhere."""
    return np.where(np.arange(7) == joint, value, 0.0)


def test_payload_and_tilt_move_as_in_the_model(random_states):
    plant = Plant('left', truth=EffortModel.rigid(), payload=LOAD, gravity=TILTED)
    states, expected = random_states(200), []
    for plant.data.qpos, plant.data.qvel, plant.data.qacc in zip(*states):
        mujoco.mj_inverse(plant.model, plant.data)
        expected.append(plant.data.qfrc_inverse.copy())
    arm = BaxterArm(payload=LOAD, gravity=TILTED, mount=mount('left'))
    np.testing.assert_allclose(arm.inverse_dynamics(*states), expected, atol=0.03)


def test_the_robot_itself_knows_neither_payload_nor_tilt_nor_cables():
    plain = Plant('right')
    laden = Plant('right', payload=LOAD, gravity=TILTED,
                  truth=EffortModel(stiffness=np.ones(7), bias=np.ones(7)))
    for plant in (plain, laden):
        plant.place(np.array([0.3, -0.6, 0.1, 1.4, 0.2, 0.8, 0.4]))
    np.testing.assert_allclose(laden.holding_torque(), plain.holding_torque(), atol=1e-12)
    np.testing.assert_allclose(plain.static_torque(), plain.holding_torque(), atol=1e-12)
    assert np.abs(laden.static_torque() - laden.holding_torque()).max() > 5.0


def test_bias_is_an_offset_of_the_measured_effort_alone():
    bias = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.02])
    for side in ('right', 'left'):
        biased, plain = (run(with_truth('circle', **truth), 0.1, side)
                         for truth in ({'bias': bias}, {}))
        np.testing.assert_array_equal(biased[:2], plain[:2])
        np.testing.assert_allclose(biased[2] - plain[2], np.tile(bias, (10, 1)), atol=1e-9)


def test_added_inertia_and_viscous_friction_show_in_motion():
    robot = with_truth('switch', added_inertia=one(0, 0.4), viscous=one(0, 0.3))
    robot.advance(2.2)  # the first switch begins at 2.4 s
    rows = []
    for k in range(2201, 3001):  # every time step, so that the effort is of this very state
        before = robot.plant.q, robot.plant.qd
        robot.advance(k * 1e-3)
        rows.append((*before, robot.plant.data.qacc.copy(), robot.joint_state()[2][ORDER]))
    q, qd, qdd, effort = np.array(rows).transpose(1, 0, 2)
    shown = (effort - BaxterArm().inverse_dynamics(q, qd, qdd))
    assert min(np.abs(qd[:, 0]).max(), np.abs(qdd[:, 0]).max()) > 0.5
    np.testing.assert_allclose(shown[:, 0], 0.4 * qdd[:, 0] + 0.3 * qd[:, 0], atol=0.02)
    np.testing.assert_allclose(shown[:, 1:], 0.0, atol=0.02)


def test_dahls_friction_is_a_loop_of_twice_its_height_that_turns_within_its_length():
    robot, period = with_truth(dahl=one(1, 1.5), dahl_length=0.05), 3.0
    start = robot.plant.q
    robot.reference = JointTrajectory(
        lambda t: start + one(1, 0.2 * np.cos(2 * np.pi * t / period) - 0.2))
    rows = []
    for k in range(1, 801):
        robot.advance(k * PERIOD)
        rows.append((robot.plant.q, robot.plant.qd, robot.joint_state()[2][ORDER]))
    q, qd, effort = np.array(rows).transpose(1, 0, 2)
    qdd = np.gradient(qd, PERIOD, axis=0)
    friction = (effort - BaxterArm().inverse_dynamics(q, qd, qdd))[150:-1, 1]
    s1, speed = q[150:-1, 1], qd[150:-1, 1]
    turn = np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))[0]
    for angle in (0.02, 0.05, 0.1, 0.2):  # after it turns round, from -1.5
        there = turn + np.argmax(s1[turn:] > s1[turn] + angle)
        expected = 1.5 - 3.0 * np.exp(-(s1[there] - s1[turn]) / 0.05)
        assert friction[there] == pytest.approx(expected, abs=0.06)
    n = round(period / PERIOD)
    np.testing.assert_allclose(friction[n:], friction[:-n], atol=0.05)  # it closes


def test_refuses_impossible_arguments():
    with pytest.raises(ArgumentError, match='truth.added_inertia: expected no negative value'):
        with_truth(added_inertia=one(3, -0.1))
    with pytest.raises(ArgumentError, match='gravity: expected shape'):
        FakeBaxter(gravity=(0.0, -9.81))
    with pytest.raises(ArgumentError, match='trajectory: expected one of circle, switch'):
        FakeBaxter(trajectory='spiral')
