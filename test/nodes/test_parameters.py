"""Parameters: described, read from files, and applied without a restart."""

from pathlib import Path

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.settings import SETTINGS
from baxter_dynamics_ros.model.effort import EffortModel
import numpy as np
import pytest
from rcl_interfaces.srv import DescribeParameters, SetParametersAtomically
from rclpy.parameter import Parameter

CONFIG = Path(__file__).parents[2] / 'config'


def set_parameters(robot, **values):
    """Set parameters of the running node at once; two underscores stand for a dot."""
    request = SetParametersAtomically.Request(parameters=[
        Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
        for name, value in values.items()])
    return robot.call(SetParametersAtomically, 'set_parameters_atomically', request).result


def still(robot, n, start):
    """Stream a still arm; return the last prediction's effort and the arm's position."""
    q = np.array([0.1, -0.5, 0.2, 0.9, 0.3, 0.6, -0.2])
    before = len(robot.predicted)
    robot.stream([(q, np.zeros(7), np.ones(7))] * n, start=start)
    robot.until(lambda: len(robot.predicted) > before)
    robot.spin(0.2)
    return np.array(robot.predicted[-1].effort), q


def test_model_changes_apply_at_once_without_a_reset(robot, predictor):
    before, q = still(robot, 60, 10 ** 18)
    arm, effort = BaxterArm(mount=mount('right')), EffortModel()
    np.testing.assert_allclose(before, arm.gravity(q) + effort.spring(q), atol=1e-9)

    assert set_parameters(robot, payload__mass=2.0, payload__center_of_mass=[0.01, 0.02, 0.1],
                          gravity=[0.5, -0.3, -9.7], method='newton_euler').successful
    after, _ = still(robot, 5, 10 ** 18 + 600_000_000)  # too few to settle anew
    arm = BaxterArm(Payload(2.0, (0.01, 0.02, 0.1)), (0.5, -0.3, -9.7), mount('right'))
    np.testing.assert_allclose(after, arm.gravity(q) + effort.spring(q), atol=1e-9)

    assert set_parameters(robot, effort_model__enabled=False).successful
    after, _ = still(robot, 5, 10 ** 18 + 650_000_000)
    np.testing.assert_allclose(after, arm.gravity(q), atol=1e-9)


def test_filter_changes_make_it_settle_anew(robot, predictor, stamps):
    still(robot, 60, 10 ** 18)
    assert set_parameters(robot, align=False).successful
    still(robot, 60, 10 ** 18 + 600_000_000)
    assert len(robot.predicted) == 2 * (60 - 21)
    assert stamps(robot.predicted)[-1] == 10 ** 18 + 1_190_000_000  # of the newest joint state


def test_each_parameter_says_what_it_is(robot, predictor):
    answer = robot.call(DescribeParameters, 'describe_parameters', DescribeParameters.Request(
        names=[setting.name for setting in SETTINGS]))
    for setting, descriptor in zip(SETTINGS, answer.descriptors):
        assert setting.description in descriptor.description
        assert f'[{setting.unit}]' in descriptor.description or not setting.unit
        assert descriptor.read_only == setting.read_only
        if isinstance(setting.default, float):
            assert descriptor.floating_point_range[0].from_value == setting.lower
            assert descriptor.floating_point_range[0].to_value == setting.upper


@pytest.mark.parametrize('file, side', [('right_arm', 'right'), ('left_arm', 'left'),
                                        ('simulation', 'right')])
def test_parameter_files_are_taken(robot, start, file, side):
    process = start('torque_predictor', '--params-file', str(CONFIG / f'{file}.yaml'))
    robot.until(lambda: 'predicting' in process.output or process.exit_code is not None)
    assert process.exit_code is None, process.output
    assert f'predicting {side}_s0' in process.output


def test_a_misspelt_parameter_file_is_one_clear_line(start, tmp_path):
    for text in ('/**:\n  ros__parameters:\n    acceleration: {cutof: 5.0}\n',
                 '/**:\n  ros__parameters:\n  acceleration: {{\n'):
        file = tmp_path / 'bad.yaml'
        file.write_text(text)
        process = start('torque_predictor', '--params-file', str(file))
        assert process.wait(20.0) == 1
        assert 'Traceback' not in process.output
        assert process.output.strip().splitlines()[-1].startswith('torque_predictor: ')
