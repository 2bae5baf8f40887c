"""The command calibrate, from a recording to a parameter file."""

import json

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('yaml', reason='needs PyYAML: pip install ".[offline]"')

from baxter_dynamics_ros.recordings.parameter_file import read_parameters  # noqa: E402, I100

COULOMB = [0.6, 0.9, 0.4, 0.3, 0.15, 0.12, 0.05]  # [N m]
BIAS = [0.5, -0.4, 0.3, 0.2, -0.1, 0.12, 0.05]  # [N m]
TRUTH = {'effort_model.coulomb': COULOMB, 'effort_model.bias': BIAS}


def test_a_calibration_improves_another_recording(command, make_bag, moving_arm, tmp_path):
    bag = make_bag(moving_arm(2000, 'left', truth=TRUTH))
    file = tmp_path / 'my_robot.yaml'
    code, out, err = command('calibrate', bag, '--output', file)
    assert (code, err) == (0, '')
    assert sorted(path.name for path in tmp_path.iterdir()) == ['my_robot.html', 'my_robot.yaml',
                                                                'run']
    assert out.splitlines()[-2:] == [f'parameters: {file}', f'report: {tmp_path}/my_robot.html']
    assert 'velocity lag: 14' in out and 'one recording: each of its 5 parts' in out
    assert '<html' in (tmp_path / 'my_robot.html').read_text()
    assert f'baxter_dynamics calibrate {bag}' in file.read_text()
    values = PredictorSettings.from_parameters(read_parameters(file)).parameters()
    assert values['arm'] == 'left'
    np.testing.assert_allclose(values['effort_model.coulomb'], COULOMB, atol=0.05)
    np.testing.assert_allclose(values['effort_model.bias'], BIAS, atol=0.05)

    report = tmp_path / 'report'
    other = make_bag(moving_arm(600, 'left', truth=TRUTH), name='other')
    assert command('evaluate', other, '--params', file, '--output', report)[0] == 0
    rms = json.loads((report / 'summary.json').read_text())['lagrange_euler']['rms']
    assert np.max(rms / np.hypot(COULOMB, BIAS)) < 0.4


def test_fits_only_the_given_terms_from_a_parameter_file(command, make_bag, moving_arm, tmp_path):
    """Also with names in the command line that would break the comments of a file."""
    start = tmp_path / 'start.yaml'
    start.write_text('/**:\n  ros__parameters:\n    arm: right\n    effort_model:\n'
                     f'      coulomb: {COULOMB}\n')
    both = [(topic, received, (stamp, names + joint_names('left'), *(
        np.concatenate([row, np.zeros(7)]) for row in rows)))
            for topic, received, (stamp, names, *rows) in moving_arm(1200, truth=TRUTH)]
    bag = make_bag(both).rename(tmp_path / 'a\nb: {\a\u2028[ caf\udce9')
    file = tmp_path / 'robot.yml'
    file.write_text('of an earlier calibration')
    code, _, err = command('calibrate', bag, '--params', start, '--output', file,
                           '--only', 'bias', '--force')
    assert (code, err) == (0, '')
    values = read_parameters(file)
    assert {name for name in values if 'deviation' not in name} == {
        'arm', 'effort_model.coulomb', 'effort_model.bias'} and values.keys() < DEFAULTS.keys()
    assert values['arm'] == 'right' and values['effort_model.coulomb'] == COULOMB
    np.testing.assert_allclose(values['effort_model.bias'], BIAS, atol=0.05)
    assert file.name in (tmp_path / 'robot.html').read_text()


@pytest.mark.parametrize('n, fields, line', [
    (500, {}, '4.8 s of motion are too short: expected at least 10 s in recordings of 1 s or '
     'more, preferably a minute (--plan writes one)'),
    (1200, {'effort': np.full(7, np.nan)}, '1200 of 1200 joint states have no valid effort ('),
    (30, {'names': [*joint_names('right')[:6], 'right_w3']}, 'no valid joint states of the arm'),
], ids=['too_short', 'effort_not_a_number', 'one_wrong_joint'])
def test_unusable_recordings_are_refused_with_the_reason_and_files_kept(
        refused, make_bag, moving_arm, tmp_path, n, fields, line):
    messages = []
    for topic, received, content in moving_arm(n):
        content = dict(zip(('stamp', 'names', 'position', 'velocity', 'effort'), content))
        messages.append((topic, received, tuple({**content, **fields}.values())))
    make_bag(messages)
    for file in 'robot.yaml', 'robot.html':
        (tmp_path / file).write_text('mine')
    assert refused('calibrate', 'run', '--output', 'robot.yaml', '--force').startswith(line)
