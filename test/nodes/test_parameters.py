"""Parameters: described, read from files, applied without a restart, refused with the reason."""

import math
from pathlib import Path

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings, SETTINGS
from baxter_dynamics_ros.model.effort import EffortModel
import numpy as np
import pytest
from rcl_interfaces.srv import (DescribeParameters, GetParameters, SetParameters,
                                SetParametersAtomically)
from rclpy.parameter import Parameter, parameter_value_to_python

CONFIG = Path(__file__).parents[2] / 'config'


def bad_values(setting) -> list:
    """Return values that the setting must refuse, of the kinds that a parameter can have."""
    default, lower, upper = setting.default, setting.lower, setting.upper
    if isinstance(default, bool):
        return [1, 1.0, 'magic', [True], []]
    if isinstance(default, str) and not setting.choices:
        return [True, 1, 1.0]
    if isinstance(default, str):
        return ['magic', True, 1, 1.0, default.upper(), [default], []]
    if isinstance(default, int):
        return [lower - 1, upper + 1, 2 ** 62, True, float(lower), math.nan, 'magic', [lower], []]
    margin = 1e-3 * (upper - lower)
    beyond = [lower - margin, upper + margin, 1e308, math.nan, math.inf, -math.inf]
    if isinstance(default, float):
        return [*beyond, True, 1, 'magic', [default], []]
    n, rest = len(default), list(default[1:])
    return [*([x, *rest] for x in beyond[:4]), *([*rest, x] for x in beyond[4:]),
            rest, [*default, 0.0], [], [True] * n, [0] * n, ['magic'] * n, 'magic', 1.0]


def text(value) -> str:
    """Write a value as it stands on a command line."""
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(map(text, value))}]'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return '.nan' if math.isnan(value) else f'{value:+}'.replace('inf', '.inf')
    return str(value)


def expected(setting) -> str:
    """Return what the reason must say about a value of another type or length."""
    default = setting.default
    if isinstance(default, bool):
        return 'true or false'
    if isinstance(default, str):
        return ', '.join(setting.choices) or 'text'
    if isinstance(default, tuple):
        return str(len(default))
    return 'whole number' if isinstance(default, int) else 'decimal point'


def is_of_its_kind(setting, value) -> bool:
    """Tell whether only the size of the value is wrong."""
    if isinstance(setting.default, tuple):
        return (isinstance(value, list) and len(value) == len(setting.default)
                and type(value[0]) is float)
    return type(value) is type(setting.default)


def assert_reason(setting, value, reason):
    """Assert that a refusal is one line that names the parameter and its type."""
    assert len(reason.splitlines()) == 1, reason
    assert setting.name in reason
    if not is_of_its_kind(setting, value):
        assert expected(setting) in reason, (value, reason)


def set_parameters(robot, values):
    """Set parameters of the running node as one change."""
    request = SetParametersAtomically.Request(parameters=[
        Parameter(name, value=value).to_parameter_msg() for name, value in values.items()])
    return robot.call(SetParametersAtomically, 'set_parameters_atomically', request).result


def parameters(robot):
    """Return the value of every setting in the running node."""
    answer = robot.call(GetParameters, 'get_parameters', GetParameters.Request(
        names=list(DEFAULTS)))
    values = map(parameter_value_to_python, answer.values)
    return {name: value if isinstance(value, (str, bool, int, float)) else tuple(value)
            for name, value in zip(DEFAULTS, values)}


def still(robot, n, start):
    """Stream a still arm; return the last prediction's effort and the arm's position."""
    q = np.array([0.1, -0.5, 0.2, 0.9, 0.3, 0.6, -0.2])
    last = robot.stream([(q, np.zeros(7), np.ones(7))] * n, start=start)
    robot.until(lambda: robot.predicted and last - 60_000_000 < 1 + (
        robot.predicted[-1].header.stamp.sec * 10 ** 9
        + robot.predicted[-1].header.stamp.nanosec))
    return np.array(robot.predicted[-1].effort), q


def test_changes_apply_in_mid_stream(robot, predictor, stamps):
    before, q = still(robot, 60, 10 ** 18)
    arm, effort = BaxterArm(mount=mount('right')), EffortModel()
    np.testing.assert_allclose(before, effort.coupled(arm.gravity(q) + effort.spring(q)),
                               atol=1e-9)

    assert set_parameters(robot, {
        'payload.mass': 2.0, 'payload.center_of_mass': [0.01, 0.02, 0.1],
        'gravity': [0.5, -0.3, -9.7], 'method': 'newton_euler'}).successful
    after, _ = still(robot, 5, 10 ** 18 + 600_000_000)  # too few to settle anew
    arm = BaxterArm(Payload(2.0, (0.01, 0.02, 0.1)), (0.5, -0.3, -9.7), mount('right'))
    np.testing.assert_allclose(after, effort.coupled(arm.gravity(q) + effort.spring(q)), atol=1e-9)

    assert set_parameters(robot, {'effort_model.enabled': False}).successful
    after, _ = still(robot, 5, 10 ** 18 + 650_000_000)
    np.testing.assert_allclose(after, arm.gravity(q), atol=1e-9)

    robot.predicted.clear()
    assert set_parameters(robot, {'align': False}).successful  # the filter settles anew
    still(robot, 60, 10 ** 18 + 700_000_000)
    robot.until(lambda: len(robot.predicted) == 60 - 21)
    assert stamps(robot.predicted)[-1] == 10 ** 18 + 1_290_000_000  # of the newest joint state


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


def test_node_accepts_a_written_file(robot, start_predictor, all_changed, tmp_path):
    files = pytest.importorskip('baxter_dynamics_ros.recordings.parameter_file')
    path = tmp_path / 'my robot.yaml'
    files.write_parameters(path, all_changed, ['Calibration', 'odd: {\nlines: [', ''])
    process = start_predictor('--params-file', str(path))
    wanted = PredictorSettings.from_parameters(files.read_parameters(path)).parameters()
    assert parameters(robot) == wanted
    assert f'predicting {all_changed.joint_prefix}left_s0' in process.output
    assert 'differ from their defaults: arm' in process.output


@pytest.mark.parametrize('file, side', [('left_arm', 'left'), ('simulation', 'right')])
def test_node_accepts_the_shipped_files(robot, start, file, side):
    process = start('torque_predictor', '--params-file', str(CONFIG / f'{file}.yaml'))
    robot.until(lambda: 'predicting' in process.output or process.exit_code is not None)
    assert process.exit_code is None, process.output
    assert f'predicting {side}_s0' in process.output


def test_a_misspelt_parameter_file_is_one_clear_line(start, tmp_path):
    for content in ('/**:\n  ros__parameters:\n    acceleration: {cutof: 5.0}\n',
                    '/**:\n  ros__parameters:\n  acceleration: {{\n'):
        file = tmp_path / 'bad.yaml'
        file.write_text(content)
        process = start('torque_predictor', '--params-file', str(file))
        assert process.wait(20.0) == 1
        assert 'Traceback' not in process.output
        assert process.output.strip().splitlines()[-1].startswith('torque_predictor: ')


def test_at_the_start_a_bad_value_is_one_line_and_exit_code_1(refusals):
    """All bad values of one setting of each kind, and one of each other setting."""
    kinds, cases = set(), []
    for k, setting in enumerate(SETTINGS):
        values, kind = bad_values(setting), (type(setting.default), bool(setting.choices))
        cases += [(setting, value) for value in (
            [values[k % len(values)]] if kind in kinds else values)]
        kinds.add(kind)
    lines = refusals('torque_predictor', [
        [f'{setting.name}:={text(value)}'] for setting, value in cases])
    for case, line in zip(cases, lines):
        assert_reason(*case, line.removeprefix('torque_predictor: '))


def test_inconsistent_values_are_refused_at_the_start(refusals):
    cases = {
        'payload.inertia:=[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]': 'payload.mass is zero',
        'arm:=both': "arm: expected one of right, left, got 'both'",
        'payload.mass:=11.0': 'payload.mass: expected a value in [0, 10] kg, got 11',
        'acceleration.cutoff:=1': 'a number with a decimal point, such as 1.0, got 1',
        'effort_model.spring_range:=[1.0, -1.0]': 'spring_range: expected lower < upper',
        'links.mass:=[0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]': 'links',
        'payload.mas:=1.0': 'payload.mas: no such parameter; did you mean payload.mass?',
        'acceleration.cutoff:=': 'acceleration.cutoff',
        'gravity:=[0.0, 0.0, "g"]': 'gravity',
        'qos_overrides./robot/joint_states.subscription.reliability:=foo': 'foo'}
    lines = refusals('torque_predictor', [[argument] for argument in cases])
    for problem, line in zip(cases.values(), lines):
        assert problem in line


def test_unknown_parameters_are_logged_and_plain_arguments_refused(robot, start):
    process = start('torque_predictor', '-p', 'camera_frame:=wrist')
    robot.until(lambda: 'camera_frame is given, but this node has none' in process.output)
    with NodeProcess('torque_predictor', ['-p', 'align:=false']) as process:
        assert process.wait(20.0) == 2
        assert 'torque_predictor --ros-args -p align:=false' in process.output


def test_at_run_time_bad_values_are_refused_and_nothing_changes(robot, predictor):
    before = parameters(robot)
    bad = [(setting, value) for setting in SETTINGS if not setting.read_only
           for value in bad_values(setting)]
    results = robot.call(SetParameters, 'set_parameters', SetParameters.Request(parameters=[
        Parameter(setting.name, value=value).to_parameter_msg() for setting, value in bad])
    ).results
    assert len(results) == len(bad) > 200
    for case, result in zip(bad, results):
        assert not result.successful, case
        assert_reason(*case, result.reason)

    for values, problem in (
            ({'arm': 'left'}, 'arm: is fixed when the node starts'),
            ({'effort_model.spring_range': [1.0, -1.0]}, 'spring_range: expected lower < upper'),
            ({'payload.inertia': [0.1] * 3 + [0.0] * 3}, 'payload.inertia: expected zero where'),
            ({'payload.mass': 1.0, 'contact.samples': 0}, 'contact.samples'),
            ({'payload.mass': 1.0, 'align': 'no'}, 'align: expected true or false'),
            ({'payload.mass': 1.0, 'payload.mas': 1.0},
             'payload.mas: no such parameter; did you mean payload.mass?')):
        result = set_parameters(robot, values)
        assert not result.successful and problem in result.reason, values
    assert parameters(robot) == before
    assert 'Traceback' not in predictor.output


def test_a_large_request_is_bounded(robot, start_predictor):
    start_predictor()
    request = SetParameters.Request(parameters=[
        Parameter('payload.mass', value=0.001 * k).to_parameter_msg() for k in range(2000)])
    answer = robot.call(SetParameters, 'set_parameters', request)
    assert len(answer.results) == 2000
    assert 100 <= sum(result.successful for result in answer.results) < 1000
    assert 'too many changes' in answer.results[-1].reason
