"""Parameters: described, read from files, applied without a restart, refused with the reason."""

import math

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.settings import PredictorSettings, SETTINGS
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
from baxter_dynamics_ros.nodes.messages import stamp_ns
from baxter_dynamics_ros.nodes.process import _reject_arguments
from baxter_dynamics_ros.nodes.ros_parameters import ParameterNode
import numpy as np
import pytest
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

START = 10 ** 18  # [ns]
# Arguments with which the node must not start, and a part of the reason.
REFUSED = {
    'arm:=both': "arm: expected one of right, left, got 'both'",
    'align:=1': 'align: expected true or false, got 1',
    'contact.samples:=0': 'contact.samples: expected a value in [1, 1000], got 0',
    'acceleration.cutoff:=1': 'expected a number with a decimal point such as 1.0, got 1',
    'payload.mass:=11.0': 'payload.mass: expected a value in [0, 10] kg, got 11',
    'payload.mass:=.nan': 'payload.mass',
    'payload.inertia:=[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]': 'payload.mass is zero',
    'gravity:=[0.0, 9.81]': 'gravity: expected shape (3,), got (2,)',
    'gravity:=[0.0, 0.0, "g"]': 'gravity',
    'effort_model.spring_range:=[1.0, -1.0]': 'spring_range: expected lower < upper',
    'links.mass:=[0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]': 'links',
    'payload.mas:=1.0': 'payload.mas: no such parameter; did you mean payload.mass?',
    'use_sim_tme:=true': 'did you mean use_sim_time?',
    'acceleration.cutoff:=': 'acceleration.cutoff',
    'qos_overrides./robot/joint_states.subscription.reliability:=foo': 'foo'}


def bad_values(setting) -> list:
    """Return values that the setting must refuse, of the kinds that a parameter can have."""
    default, lower, upper = setting.default, setting.lower, setting.upper
    if isinstance(default, bool):
        return [1, 1.0, 'magic', [True], []]
    if isinstance(default, str):
        return ['magic', True, 1.0, [default], []] if setting.choices else [True, 1.0]
    if isinstance(default, int):
        return [lower - 1, upper + 1, True, float(lower), math.nan, 'magic', []]
    margin = 1e-3 * (upper - lower)
    beyond = [lower - margin, upper + margin, 1e308, math.nan, math.inf, -math.inf]
    if isinstance(default, float):
        return [*beyond, True, 1, 'magic', [default], []]
    n, rest = len(default), list(default[1:])
    return [*([x, *rest] for x in beyond[:4]), *([*rest, x] for x in beyond[4:]),
            rest, [*default, 0.0], [], [True] * n, [0] * n, ['magic'] * n, 'magic', 1.0]


def still(robot, n, start):
    """Stream a still arm; return the last prediction's effort and the arm's position."""
    q = np.array([0.1, -0.5, 0.2, 0.9, 0.3, 0.6, -0.2])
    last = robot.stream([(q, np.zeros(7), np.ones(7))] * n, start=start)
    robot.until(lambda: robot.predicted
                and stamp_ns(robot.predicted[-1].header) >= last - 60_000_000)
    return np.array(robot.predicted[-1].effort), q


def test_each_parameter_has_a_description(robot, predictor):
    answer = robot.call(DescribeParameters, 'describe_parameters', DescribeParameters.Request(
        names=[setting.name for setting in SETTINGS]))
    for setting, descriptor in zip(SETTINGS, answer.descriptors):
        assert setting.description in descriptor.description
        assert f'[{setting.unit}]' in descriptor.description or not setting.unit
        assert descriptor.read_only == setting.read_only
        if isinstance(setting.default, float):
            assert descriptor.floating_point_range[0].from_value == setting.lower
            assert descriptor.floating_point_range[0].to_value == setting.upper


def test_at_run_time_bad_values_are_refused_and_nothing_changes(robot, predictor):
    before = robot.parameters()
    bad = [(setting, value) for setting in SETTINGS if not setting.read_only
           for value in bad_values(setting)]
    results = robot.call(SetParameters, 'set_parameters', SetParameters.Request(parameters=[
        Parameter(setting.name, value=value).to_parameter_msg() for setting, value in bad])
    ).results
    assert len(results) == len(bad) > 200
    for (setting, value), result in zip(bad, results):
        assert not result.successful, (setting, value)
        assert len(result.reason.splitlines()) == 1
        assert setting.name in result.reason

    for values, problem in (
            ({'arm': 'left'}, 'read-only parameter: arm'),
            ({'effort_model.spring_range': [1.0, -1.0]}, 'spring_range: expected lower < upper'),
            ({'payload.inertia': [0.1] * 3 + [0.0] * 3}, 'payload.inertia: expected zero where'),
            ({'payload.mass': 1.0, 'contact.samples': 0}, 'contact.samples'),
            ({'payload.mass': 1.0, 'align': 'no'}, 'align: expected true or false'),
            ({'payload.mass': 1.0, 'payload.mas': 1.0}, 'did you mean payload.mass?')):
        result = robot.configure(values)
        assert not result.successful and problem in result.reason, values
    assert robot.parameters() == before
    assert 'Traceback' not in predictor.output


def restore(robot):
    """Set the defaults again, for the test that shares the predictor next."""
    defaults = {each.name: each.default for each in SETTINGS if not each.read_only}
    robot.until(lambda: robot.configure(defaults).successful)


def test_changes_in_the_process_are_checked_too(robot):
    node = ParameterNode('own')
    node.declare_settings(SETTINGS)
    results = node.set_parameters([Parameter('payload.mass', value=x) for x in (1.0, 11.0)])
    node.destroy_node()
    assert results[0].successful and '[0, 10] kg' in results[1].reason
    assert node.values['payload.mass'] == 1.0


def test_a_large_request_is_bounded(robot, predictor):
    answer = robot.call(SetParameters, 'set_parameters', SetParameters.Request(parameters=[
        Parameter('payload.mass', value=0.001 * k).to_parameter_msg() for k in range(2000)]))
    assert 100 <= sum(result.successful for result in answer.results) < 1000
    assert 'too many changes' in answer.results[-1].reason
    restore(robot)


def test_changes_apply_in_mid_stream(robot, predictor, stamps):
    before, q = still(robot, 60, START)
    arm, effort = BaxterArm(mount=mount('right')), EffortModel()
    np.testing.assert_allclose(before, effort.coupled(arm.gravity(q) + effort.spring(q)),
                               atol=1e-9)

    assert robot.configure({
        'payload.mass': 2.0, 'payload.center_of_mass': [0.01, 0.02, 0.1],
        'gravity': [0.5, -0.3, -9.7], 'method': 'newton_euler'}).successful
    after, _ = still(robot, 5, START + 600_000_000)  # too few to settle anew
    arm = BaxterArm(Payload(2.0, (0.01, 0.02, 0.1)), (0.5, -0.3, -9.7), mount('right'))
    np.testing.assert_allclose(after, effort.coupled(arm.gravity(q) + effort.spring(q)), atol=1e-9)

    assert robot.configure({'effort_model.enabled': False}).successful
    after, _ = still(robot, 5, START + 650_000_000)
    np.testing.assert_allclose(after, arm.gravity(q), atol=1e-9)

    robot.predicted.clear()
    assert robot.configure({'align': False}).successful  # the filter settles anew
    still(robot, 60, START + 700_000_000)
    robot.until(lambda: len(robot.predicted) == 60 - 21)
    assert stamps(robot.predicted)[-1] == START + 1_290_000_000  # of the newest joint state
    restore(robot)


def test_node_accepts_a_written_file(robot, all_changed, tmp_path):
    files = pytest.importorskip('baxter_dynamics_ros.recordings.parameter_file')
    path = tmp_path / 'my robot.yaml'
    files.write_parameters(path, all_changed, ['Calibration', 'odd: {\nlines: [', ''])
    process = robot.start_predictor('--params-file', str(path), '-p', 'camera_frame:=wrist')
    wanted = PredictorSettings.from_parameters(files.read_parameters(path)).parameters()
    assert robot.parameters() == wanted
    assert f'predicting {all_changed.joint_prefix}left_s0' in process.output
    assert 'differ from their defaults: arm' in process.output
    assert 'ignoring camera_frame: not a parameter of this node' in process.output


def test_refusals_at_the_start_are_one_line(refusals, tmp_path):
    broken = tmp_path / 'broken.yaml'
    broken.write_text('/**:\n  ros__parameters:\n  acceleration: {{\n')
    refused = {**REFUSED, str(broken): str(broken)}
    lines = refusals('torque_predictor', [[argument] for argument in refused])
    for problem, line in zip(refused.values(), lines, strict=True):
        assert problem in line


def test_plain_arguments_are_refused_with_those_to_use(capsys):
    with pytest.raises(SystemExit, match='2'):
        _reject_arguments(Node, 'torque_predictor', ['x', 'align:=false'])
    assert ': align:=false. ROS parameters: --ros-args -p' in capsys.readouterr().err
    with pytest.raises(BaxterDynamicsError, match=r"\['align:=false'\]\. ROS parameters: -"):
        _reject_arguments(Node, 'torque_predictor', ['x', '--ros-args', 'align:=false'])
