"""The fake Baxter behaves as the real one was measured to."""

from dataclasses import replace

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import joint_names, POSITION_LOWER, POSITION_UPPER
import numpy as np
import pytest

mujoco = pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.plant import default_truth, Plant  # noqa: E402, I100
from baxter_dynamics_ros.simulation.robot import FakeBaxter, JOINT_STATE_NAMES  # noqa: E402
from baxter_dynamics_ros.simulation.sensors import Sensors  # noqa: E402
from baxter_dynamics_ros.simulation.trajectories import circle  # noqa: E402

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


def residuals(robot, seconds, settings=None, side='right'):
    """Return the residual of the predictor on the robot, (n, 7) [N m]."""
    predictor = Predictor(PredictorSettings.from_parameters({'arm': side, **(settings or {})}))
    result = []
    for k in range(1, round(seconds / PERIOD) + 1):
        robot.advance(k * PERIOD)
        prediction = predictor.handle(round(k * PERIOD * 1e9), JOINT_STATE_NAMES,
                                      *robot.joint_state()).prediction
        if prediction is not None:
            result.append(prediction.residual)
    return np.array(result)


def test_publishes_the_robots_17_joints_in_its_order():
    assert ' '.join(JOINT_STATE_NAMES) == (
        'head_nod head_pan left_e0 left_e1 left_s0 left_s1 left_w0 left_w1 left_w2 right_e0 '
        'right_e1 right_s0 right_s1 right_w0 right_w1 right_w2 torso_t0')
    assert all(field.shape == (17,) for field in FakeBaxter(trajectory='hold').joint_state())


@pytest.mark.parametrize('side', ['right', 'left'])
def test_hand_follows_the_papers_circle(side):
    q, _, _ = run(FakeBaxter(side, noise=False), 8.0, side)
    hand = BaxterArm(mount=mount(side)).forward_kinematics(q)
    t = PERIOD * np.arange(1, len(q) + 1) - 1.0  # the trajectory's own time, once up to speed
    wanted = np.array([circle(x) for x in t])
    if side == 'left':
        wanted[:, 1] *= -1
    assert np.abs(hand[300:, :3, 3] - wanted[300:]).max() < 0.01
    assert hand[300:, 2, 2].max() < -0.99  # hand down
    assert ((q > POSITION_LOWER) & (q < POSITION_UPPER)).all()


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


def test_without_spring_friction_and_noise_effort_is_the_rigid_bodys():
    robot = FakeBaxter(noise=False, truth=EffortModel.rigid())
    residual = residuals(robot, 8.0, {'effort_model.enabled': False})
    assert np.sqrt(np.mean(residual ** 2, axis=0)).max() < 0.02


def test_friction_shows_as_a_residual():
    smooth, rough = (residuals(FakeBaxter(noise=False, truth=default_truth(friction=friction)),
                               8.0)[:, 1] for friction in (False, True))
    assert np.sqrt(np.mean(smooth ** 2)) < 0.02
    assert 0.2 < np.sqrt(np.mean(rough ** 2)) < 0.8


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('robot, force, torque', [
    ({}, 0.0, 0.0), ({}, [3.0, -5.0, -10.0], 0.0),
    ({}, 0.0, [2.0, -3.0, 1.0, -2.0, 0.3, 0.2, -0.1]), ({'payload': LOAD}, 0.0, 0.0),
    ({'gravity': TILTED}, 0.0, 0.0), ({'truth': CABLES}, 0.0, 0.0),
], ids=['spring', 'force', 'torque', 'payload', 'tilt', 'stiffness'])
def test_effort_at_rest_balances_gravity_springs_and_external_loads(side, robot, force, torque):
    robot = {'truth': default_truth(friction=False), **robot}
    arm = BaxterArm(mount=mount(side), **{name: value for name, value in robot.items()
                                          if name != 'truth'})
    fake = FakeBaxter(side, 'hold', noise=False, **robot)
    _, qd, _ = run(fake, 0.2, side)
    assert np.abs(qd).max() < 1e-3  # at rest from the start
    fake.plant.force, fake.plant.torque = np.zeros(3) + force, np.zeros(7) + torque
    settled = 4.0 if np.any(force) or np.any(torque) else 0.1  # [s]
    q, _, effort = (row[-1] for row in run(fake, settled, side))
    expected = (arm.gravity(q) + fake.plant.truth.spring(q) + fake.plant.truth.stiffness * q
                - arm.jacobian(q)[:3].T @ fake.plant.force - fake.plant.torque)
    np.testing.assert_allclose(effort, fake.plant.truth.coupled(expected), atol=0.05)


def test_the_same_seed_gives_the_same_data():
    first, second, other = (run(FakeBaxter(seed=seed), 0.3) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, second)
    assert (first != other).any()


def test_refuses_a_file_that_is_no_description_of_a_baxter(tmp_path):
    from baxter_dynamics_ros.simulation.description import DescriptionError
    wrong = tmp_path / 'wrong.urdf'
    with pytest.raises(DescriptionError, match='wrong.urdf: cannot be read'):
        FakeBaxter(description=wrong)
    wrong.write_text('<robot name="other"/>')
    with pytest.raises(DescriptionError, match='no joint right_s0'):
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


@pytest.mark.parametrize('side', ['right', 'left'])
def test_bias_is_an_offset_of_the_measured_effort_alone(side):
    bias = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.02])
    biased, plain = (run(with_truth('circle', **truth), 0.5, side)
                     for truth in ({'bias': bias}, {}))
    np.testing.assert_array_equal(biased[:2], plain[:2])
    np.testing.assert_allclose(biased[2] - plain[2], np.tile(bias, (50, 1)), atol=1e-9)


@pytest.mark.parametrize('term', ['added_inertia', 'viscous'])
def test_added_inertia_and_viscous_friction_show_in_motion(term):
    robot = with_truth('switch', **{term: one(0, 0.4)})
    rows = []
    for k in range(1, 3001):  # every time step, so that the effort is of this very state
        before = robot.plant.q, robot.plant.qd
        robot.advance(k * 1e-3)
        rows.append((*before, robot.plant.data.qacc.copy(), robot.joint_state()[2][ORDER]))
    q, qd, qdd, effort = np.array(rows).transpose(1, 0, 2)
    shown = (effort - BaxterArm().inverse_dynamics(q, qd, qdd))
    expected = 0.4 * (qdd if term == 'added_inertia' else qd)[:, 0]
    assert np.abs(expected).max() > 0.4
    np.testing.assert_allclose(shown[:, 0], expected, atol=0.02)
    np.testing.assert_allclose(shown[:, 1:], 0.0, atol=0.02)


def test_dahls_friction_is_a_loop_of_twice_its_height_that_turns_within_its_length():
    robot = with_truth('lift', dahl=one(1, 1.5), dahl_length=0.05)
    rows = []
    for k in range(1, 1701):
        robot.advance(k * PERIOD)
        rows.append((robot.plant.q, robot.plant.qd, robot.joint_state()[2][ORDER]))
    q, qd, effort = np.array(rows).transpose(1, 0, 2)
    qdd = np.gradient(qd, PERIOD, axis=0)
    friction = (effort - BaxterArm().inverse_dynamics(q, qd, qdd))[300:, 1]
    s1, speed = q[300:, 1], qd[300:, 1]
    assert np.median(friction[speed > 0.05]) == pytest.approx(1.5, abs=0.03)
    assert np.median(friction[speed < -0.05]) == pytest.approx(-1.5, abs=0.03)
    period = round(4 * np.pi / PERIOD)
    np.testing.assert_allclose(friction[period:], friction[:-period], atol=0.05)  # it closes
    turn = np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))[0]
    for angle in (0.02, 0.05, 0.1):  # after it turns round, from -1.5
        there = turn + np.argmax(s1[turn:] > s1[turn] + angle)
        expected = 1.5 - 3.0 * np.exp(-angle / 0.05)
        assert friction[there] == pytest.approx(expected, abs=0.06)


def test_refuses_impossible_arguments():
    with pytest.raises(ArgumentError, match='truth.added_inertia: expected no negative value'):
        with_truth(added_inertia=one(3, -0.1))
    with pytest.raises(ArgumentError, match='gravity: expected shape'):
        FakeBaxter(gravity=(0.0, -9.81))
    with pytest.raises(ArgumentError, match='trajectory: expected one of circle, switch'):
        FakeBaxter(trajectory='spiral')
