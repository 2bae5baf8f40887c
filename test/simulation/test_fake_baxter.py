"""The fake Baxter behaves as the real one was measured to."""

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import joint_names, POSITION_LOWER, POSITION_UPPER
import numpy as np
import pytest

mujoco = pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.plant import Plant  # noqa: E402, I100
from baxter_dynamics_ros.simulation.robot import FakeBaxter, JOINT_STATE_NAMES  # noqa: E402
from baxter_dynamics_ros.simulation.sensors import Sensors  # noqa: E402
from baxter_dynamics_ros.simulation.trajectories import circle  # noqa: E402

PERIOD = 0.01  # [s]
ORDER = [JOINT_STATE_NAMES.index(name) for name in joint_names('right')]


def run(robot, seconds, side='right'):
    """Return q, qd, effort (n, 7) of one arm as published."""
    order = [JOINT_STATE_NAMES.index(name) for name in joint_names(side)]
    start, rows = robot.time, []
    for k in range(1, round(seconds / PERIOD) + 1):
        robot.advance(start + k * PERIOD)
        rows.append([field[order] for field in robot.joint_state()])
    return np.array(rows).transpose(1, 0, 2)


def residuals(robot, seconds, settings=None, side='right'):
    """Return what the predictor leaves over on the robot, (n, 7) [N m]."""
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
    robot = FakeBaxter(side, noise=False)
    q, _, _ = run(robot, 20.0, side)
    hand = BaxterArm(mount=mount(side)).forward_kinematics(q)
    t = PERIOD * np.arange(1, len(q) + 1) - 1.0  # the trajectory's own time, once up to speed
    wanted = np.array([circle(x) for x in t])
    if side == 'left':
        wanted[:, 1] *= -1
    assert np.abs(hand[300:, :3, 3] - wanted[300:]).max() < 0.01
    assert hand[300:, 2, 2].max() < -0.99  # hand down
    assert ((q > POSITION_LOWER) & (q < POSITION_UPPER)).all()


def test_velocity_lags_position_by_13_and_a_half_milliseconds():
    sensors, velocity, t = Sensors(0.001, noise=False), [], 0.001 * np.arange(4000)
    for now in t:
        sensors.read(np.full(7, np.sin(3 * now)), np.zeros(7))
        velocity.append(sensors.publish()[1][0])
    lags = np.arange(0.0, 0.03, 1e-4)
    error = [np.sum((np.array(velocity[100:]) - 3 * np.cos(3 * (t[100:] - lag))) ** 2)
             for lag in lags]
    assert lags[np.argmin(error)] == pytest.approx(0.0135, abs=2e-4)


def test_noise_and_quanta_at_rest_are_those_measured():
    sensors, rows = Sensors(0.001, seed=3), []
    for _ in range(3000):
        for _ in range(10):
            sensors.read(np.full(7, 0.3), np.full(7, 2.0))
        rows.append(np.array(sensors.publish()))
    q, qd, effort = np.array(rows).transpose(1, 0, 2)
    quantum = 2 * np.pi / 16384
    np.testing.assert_allclose(q / quantum, np.round(q / quantum), atol=1e-9)
    np.testing.assert_allclose(effort / 0.004, np.round(effort / 0.004), atol=1e-9)
    np.testing.assert_allclose(qd.std(0), 0.013, rtol=0.1)
    np.testing.assert_allclose(
        effort.std(0), [0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011], rtol=0.1)


def test_without_spring_friction_and_noise_effort_is_the_rigid_bodys():
    robot = FakeBaxter(spring=False, friction=False, noise=False)
    residual = residuals(robot, 8.0, {'effort_model.enabled': False})
    assert np.sqrt(np.mean(residual ** 2, axis=0)).max() < 0.02


def test_spring_is_in_the_effort_as_on_the_robot():
    robot = FakeBaxter(trajectory='hold', friction=False, noise=False)
    q, _, effort = run(robot, 1.0)
    expected = BaxterArm().gravity(q[-1]) + EffortModel().spring(q[-1])
    np.testing.assert_allclose(effort[-1], expected, atol=0.02)


def test_friction_shows_as_a_residual_against_the_motion():
    smooth = residuals(FakeBaxter(noise=False, friction=False), 8.0)
    rough = residuals(FakeBaxter(noise=False), 8.0)
    assert np.sqrt(np.mean(smooth[:, 1] ** 2)) < 0.02
    assert 0.2 < np.sqrt(np.mean(rough[:, 1] ** 2)) < 0.8


def test_force_on_the_hand_shows_in_the_effort_with_the_sign_of_a_reaction():
    robot = FakeBaxter(trajectory='hold', friction=False, noise=False)
    run(robot, 0.5)
    robot.force = (3.0, -5.0, -10.0)
    q, _, effort = run(robot, 4.0)
    arm = BaxterArm(mount=mount('right'))
    external = arm.jacobian(q[-1])[:3].T @ (3.0, -5.0, -10.0)
    residual = effort[-1] - arm.gravity(q[-1]) - EffortModel().spring(q[-1])
    np.testing.assert_allclose(residual, -external, atol=0.05)


def test_external_torque_shows_at_its_joint_with_the_sign_of_a_reaction():
    robot = FakeBaxter(trajectory='hold', friction=False, noise=False)
    run(robot, 0.5)
    robot.torque = external = np.array([2.0, -3.0, 1.0, -2.0, 0.3, 0.2, -0.1])
    q, _, effort = run(robot, 4.0)
    residual = effort[-1] - BaxterArm().gravity(q[-1]) - EffortModel().spring(q[-1])
    np.testing.assert_allclose(residual, -external, atol=0.05)


def test_the_same_seed_gives_the_same_data():
    first, second, other = (run(FakeBaxter(seed=seed), 0.3) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, second)
    assert (first != other).any()


def test_a_description_that_is_none_is_a_clear_error(tmp_path):
    from baxter_dynamics_ros.simulation.description import DescriptionError
    wrong = tmp_path / 'wrong.urdf'
    with pytest.raises(DescriptionError, match='wrong.urdf: cannot be read'):
        FakeBaxter(description=wrong)
    wrong.write_text('<robot name="other"/>')
    with pytest.raises(DescriptionError, match='no joint right_s0'):
        FakeBaxter(description=wrong)


# What the fake Baxter can have beyond the default, one by one.

LOAD = Payload(1.1, (0.04, -0.03, 0.08), (0.05, 0.045, 0.04, 0.012, -0.01, 0.008))


def with_truth(trajectory='hold', **truth):
    """Return a fake Baxter that has that and nothing else: no spring, friction or noise."""
    model = EffortModel(spring_coefficients=np.zeros(5), **truth)
    return FakeBaxter(trajectory=trajectory, noise=False, truth=model)


def one(joint, value):
    """Return zeros (7,) but for one joint."""
    return np.where(np.arange(7) == joint, value, 0.0)


@pytest.mark.parametrize('side', ['right', 'left'])
def test_payload_shows_at_rest_as_its_weight_in_the_joints(side):
    loaded, empty = (FakeBaxter(side, 'hold', friction=False, noise=False, payload=payload)
                     for payload in (LOAD, None))
    (q, qd, effort), (_, _, before) = run(loaded, 0.3, side), run(empty, 0.3, side)
    arm = BaxterArm(mount=mount(side))
    jacobian, rotation = arm.jacobian(q[-1]), arm.forward_kinematics(q[-1])[:3, :3]
    lever = rotation @ LOAD.center_of_mass
    at_center = jacobian[:3] + np.cross(jacobian[3:].T, lever).T
    weight = np.array([0.0, 0.0, -9.81 * LOAD.mass])
    np.testing.assert_allclose(effort[-1] - before[-1], -at_center.T @ weight, atol=0.02)
    assert np.abs(effort[-1] - before[-1]).max() > 4.0
    assert np.abs(qd).max() < 1e-3  # it was at rest before, too


def test_payload_and_tilt_move_as_in_the_model(random_states):
    gravity = (0.3, -0.2, -9.8)
    plant = Plant('left', truth=EffortModel.rigid(), payload=LOAD, gravity=gravity)
    states, expected = random_states(200), []
    for plant.data.qpos, plant.data.qvel, plant.data.qacc in zip(*states):
        mujoco.mj_inverse(plant.model, plant.data)
        expected.append(plant.data.qfrc_inverse.copy())
    arm = BaxterArm(payload=LOAD, gravity=gravity, mount=mount('left'))
    np.testing.assert_allclose(arm.inverse_dynamics(*states), expected, atol=0.03)


def test_the_robot_itself_knows_neither_payload_nor_tilt_nor_cables():
    plain = Plant('right')
    laden = Plant('right', payload=LOAD, gravity=(0.3, -0.2, -9.8),
                  truth=EffortModel(stiffness=np.ones(7), bias=np.ones(7)))
    for plant in (plain, laden):
        plant.place(np.array([0.3, -0.6, 0.1, 1.4, 0.2, 0.8, 0.4]))
    np.testing.assert_allclose(laden.holding_torque(), plain.holding_torque(), atol=1e-12)
    np.testing.assert_allclose(plain.static_torque(), plain.holding_torque(), atol=1e-12)
    assert np.abs(laden.static_torque() - laden.holding_torque()).max() > 5.0


@pytest.mark.parametrize('side', ['right', 'left'])
def test_tilt_shows_on_both_arms_as_gravity_in_another_direction(side):
    gravity = (0.3, -0.2, -9.8)
    robot = FakeBaxter('right', 'hold', friction=False, noise=False, gravity=gravity)
    q, qd, effort = run(robot, 0.3, side)
    spring = EffortModel().spring(q[-1])
    arm = BaxterArm(mount=mount(side), gravity=gravity)
    np.testing.assert_allclose(effort[-1], arm.gravity(q[-1]) + spring, atol=0.02)
    upright = BaxterArm(mount=mount(side)).gravity(q[-1]) + spring
    assert np.abs(effort[-1] - upright).max() > 0.2
    assert np.abs(qd).max() < 1e-3


@pytest.mark.parametrize('side', ['right', 'left'])
def test_bias_is_an_offset_of_the_measured_effort_alone(side):
    bias = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.02])
    biased, plain = (run(with_truth('circle', **truth), 0.5, side)
                     for truth in ({'bias': bias}, {}))
    np.testing.assert_array_equal(biased[:2], plain[:2])
    np.testing.assert_allclose(biased[2] - plain[2], np.tile(bias, (50, 1)), atol=1e-9)


def test_stiffness_of_cables_shows_at_rest():
    stiffness = np.array([2.0, -1.5, 1.0, 0.8, 0.4, -0.3, 0.2])
    q, qd, effort = run(with_truth(stiffness=stiffness), 0.3)
    np.testing.assert_allclose(effort[-1] - BaxterArm().gravity(q[-1]), stiffness * q[-1],
                               atol=0.02)
    assert np.abs(qd).max() < 1e-3


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


def test_what_no_arm_can_have_is_a_clear_error():
    with pytest.raises(ArgumentError, match='truth.added_inertia: expected no negative value'):
        with_truth(added_inertia=one(3, -0.1))
    with pytest.raises(ArgumentError, match='truth: replaces spring and friction'):
        FakeBaxter(truth=EffortModel(), friction=False)
    with pytest.raises(ArgumentError, match='gravity: expected shape'):
        FakeBaxter(gravity=(0.0, -9.81))
    with pytest.raises(ArgumentError, match='trajectory: expected one of circle, switch'):
        FakeBaxter(trajectory='spiral')
