"""A parameter file as calibrate writes it starts the node, with these very parameters."""

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
import pytest
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python

pytest.importorskip('yaml', reason='parameter files need PyYAML: pip install pyyaml')

from baxter_dynamics_ros.recordings.parameter_file import (  # noqa: E402, I100
    read_parameters, write_parameters)


@pytest.mark.parametrize('written', ['every setting', 'the arm alone'])
def test_the_node_takes_a_written_file(robot, start_predictor, all_changed, tmp_path, written):
    path = tmp_path / 'my robot.yaml'
    settings = all_changed if written == 'every setting' else PredictorSettings(arm='left')
    write_parameters(path, settings, ['Calibration', 'odd: {\nlines: [', ''])
    process = start_predictor('--params-file', str(path))
    answer = robot.call(GetParameters, 'get_parameters', GetParameters.Request(
        names=list(DEFAULTS)))
    wanted = PredictorSettings.from_parameters(read_parameters(path)).parameters()
    for name, value in zip(DEFAULTS, answer.values):
        found = parameter_value_to_python(value)
        if isinstance(wanted[name], tuple):
            found = tuple(found)
        assert found == wanted[name], name
    assert f'predicting {settings.joint_prefix}left_s0' in process.output
    assert 'differ from their defaults: arm' in process.output
