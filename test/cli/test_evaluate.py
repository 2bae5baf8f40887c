"""The command evaluate: report, numbers and a new bag."""

import csv
import json

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

BIAS = {'right': [0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.05],  # [N m]
        'left': [-0.3, 0.6, -0.1, 0.4, -0.05, 0.1, 0.02]}
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')


@pytest.fixture
def both_arms(moving_arm):
    """Return joint states that hold both arms and the head, each arm with a bias of its own."""
    arms = [moving_arm(150, side, truth={'effort_model.bias': bias})
            for side, bias in BIAS.items()]
    names = ('head_pan', *joint_names('left')[::-1], *joint_names('right'))
    return [(topic, received, (right[0], names, *(
                np.concatenate([[0.0], b[::-1], a]) for a, b in zip(right[2:], left[2:]))))
            for (topic, received, right), (_, _, left) in zip(*arms)]


@pytest.fixture
def summary(command, tmp_path, monkeypatch):
    """Return a function that evaluates without figures; it returns summary.json and stdout."""
    from baxter_dynamics_ros.report import evaluation_report
    from baxter_dynamics_ros.report.drawing import Picture
    monkeypatch.setattr(evaluation_report, 'effort_picture',
                        lambda name, *_: Picture(name, '', b'<svg/>'))

    def run(*arguments):
        code, out, err = command('evaluate', *arguments, '--output', tmp_path / 'report',
                                 '--force')
        assert (code, err) == (0, '')
        return json.loads((tmp_path / 'report' / 'summary.json').read_text()), out
    return run


def results(field, messages, values=None):
    """Return each prediction, or external effort, of the node's predictor for some messages."""
    predictor = Predictor(PredictorSettings.from_parameters(values or {}), external=True)
    found = [getattr(predictor.handle(*content), field) for _, _, content in messages
             if not isinstance(content, str)]
    return [result for result in found if result is not None]


def residuals(messages, values=None):
    """Return the residual of each prediction, (n, 7) [N m]."""
    return np.array([each.residual for each in results('prediction', messages, values)])


def parameter_file(path, arm, **settings):
    """Write a parameter file by hand."""
    path.write_text('/**:\n  ros__parameters:\n' + ''.join(
        f'    {name}: {value}\n' for name, value in {'arm': arm, **settings}.items()))
    return path


def test_the_report_and_its_numbers(command, make_bag, moving_arm, tmp_path, monkeypatch):
    messages = moving_arm(300, truth={'effort_model.bias': BIAS['right']})
    make_bag(messages)
    monkeypatch.chdir(tmp_path)
    code, out, err = command('evaluate', 'run')
    assert (code, err) == (0, '')
    folder = tmp_path / 'baxter_evaluation'
    assert sorted(path.name for path in tmp_path.iterdir()) == ['baxter_evaluation', 'run']
    assert sorted(path.name for path in folder.iterdir()) == ['figures', 'report.html',
                                                              'summary.csv', 'summary.json']
    assert out.startswith('The residual ')
    assert out.splitlines()[-1] == f'report: {folder}/report.html'
    page = (folder / 'report.html').read_text()
    assert 'baxter_dynamics evaluate run' in page and 'defaults of the package' in page
    numbers = json.loads((folder / 'summary.json').read_text())
    assert numbers['joints'] == list(JOINTS)
    error = residuals(messages)
    effort = np.array([each.effort for each in results('prediction', messages)])
    expected = {
        'rms': np.sqrt((error ** 2).mean(0)), 'mean_abs': np.abs(error).mean(0),
        'signed_mean': error.mean(0), 'correlation': [
            np.corrcoef(effort[:, i] + error[:, i], effort[:, i])[0, 1] for i in range(7)]}
    with open(folder / 'summary.csv', encoding='utf-8-sig', newline='') as file:
        rows = list(csv.DictReader(file))
    assert [(row['recording'], row['method'], row['joint']) for row in rows] == [
        ('run', method, joint) for method in ('lagrange_euler', 'newton_euler')
        for joint in JOINTS]
    for name, values in expected.items():
        for method in ('lagrange_euler', 'newton_euler'):
            assert numbers[method]['count'] == len(error)
            np.testing.assert_allclose(numbers[method][name], values, atol=1e-9)
        column = name if name == 'correlation' else f'{name} [N m]'
        assert [float(row[column]) for row in rows[:7]] == numbers['lagrange_euler'][name]
    np.testing.assert_allclose(error.mean(0), BIAS['right'], atol=0.02)
    for joint, value in zip(JOINTS, expected['rms']):
        assert any(line.split()[:2] == [joint, f'{value:.3f}'] for line in out.splitlines())


def test_arm_and_parameter_files(summary, make_bag, both_arms, tmp_path):
    """The arm is the one that is named, or else the parameter files'; later files override."""
    bag = make_bag(both_arms)
    named, _ = summary(bag, '--arm', 'left')
    assert named['arm'] == 'left'
    np.testing.assert_allclose(named['lagrange_euler']['signed_mean'], BIAS['left'], atol=0.02)
    values = {'effort_model.bias': BIAS['left'], 'payload.mass': 0.4}
    files = [parameter_file(tmp_path / 'a.yaml', 'right', **values, publish_rate=5.0),
             tmp_path / 'b.yaml', tmp_path / 'c.yaml']
    files[1].write_text('/robot1/torque_predictor:\n  ros__parameters: {arm: left}\n')
    files[2].write_text('/other:\n  ros__parameters: {payload.mass: 2.0}\n')
    told, out = summary(bag, *(word for file in files for word in ('--params', file)),
                        '--node', '/robot1/torque_predictor')
    assert (told['arm'], told['parameters']) == ('left', 'a.yaml, b.yaml, c.yaml')
    assert 'ignoring publish_rate' in out
    rms = np.sqrt(np.mean(residuals(both_arms, {'arm': 'left', **values}) ** 2, axis=0))
    for method in ('lagrange_euler', 'newton_euler'):
        np.testing.assert_allclose(told[method]['rms'], rms, atol=1e-9)


def test_wrong_data_are_stated_once(summary, make_bag, moving_arm, tmp_path):
    _, out = summary(make_bag(moving_arm(600, truth={'effort_model.enabled': False})))
    assert out.count('torque, instead of 1') == 1
    assert f'-o {tmp_path}/report --force --params ' in out


def test_several_bags(summary, make_bag, moving_arm):
    """Of different arms, too: the numbers at the top are of all their samples."""
    right, left = moving_arm(60), moving_arm(100, 'left')
    numbers, _ = summary(make_bag(right, 'sqlite3', 'one'), make_bag(left, 'ros1', 'two'))
    assert numbers['arm'] == 'left, right'
    assert [(each['name'], each['arm']) for each in numbers['recordings']] == [
        ('one', 'right'), ('two', 'left')]
    error = np.concatenate([residuals(right), residuals(left, {'arm': 'left'})])
    assert numbers['lagrange_euler']['count'] == len(error) == 160 - 2 * 21
    np.testing.assert_allclose(numbers['lagrange_euler']['signed_mean'], np.mean(error, axis=0),
                               atol=1e-9)


@pytest.mark.parametrize('unstamped', [600, 100])
def test_zero_stamps_are_replaced_by_times_of_recording(summary, make_bag, moving_arm, unstamped):
    numbers, out = summary(make_bag([
        (topic, received, (0 if i < unstamped else content[0] + 1000, *content[1:]))
        for i, (topic, received, content) in enumerate(moving_arm(600))]))
    assert f'{unstamped} x unstamped: header stamps are zero: using the time of receipt' in out
    assert 300 < numbers['lagrange_euler']['count'] < 600 - 21  # without the time of detection
    assert np.max(numbers['lagrange_euler']['rms']) < 0.2


def test_the_new_bag_holds_what_the_node_would_publish(
        summary, make_bag, read_bag, moving_arm, tmp_path):
    names = tuple(f'robot_1/{name}' for name in joint_names('right'))
    messages = [(topic, received, (content[0], names, *content[2:]))
                for topic, received, content in moving_arm(120)]
    for i in range(40, 45):  # effort is missing
        topic, received, content = messages[i]
        messages[i] = topic, received, (*content[:4], ())
    gripper = (10 ** 18, GRIPPER, [0.0, 0.1], [0.0, 0.0], [0.0, 0.0])
    messages.insert(40, (messages[39][0], messages[39][1] + 5, gripper))
    messages.append(('/talk', messages[-1][1] + 1, 'hello'))
    values = {'effort_model.bias': BIAS['right'], 'effort_model.dahl': [0.3] * 7,
              'joint_prefix': 'robot_1/', 'frame_id': 'world'}
    file = parameter_file(tmp_path / 'p.yaml', 'right', **values)
    numbers, _ = summary(make_bag(messages), '--params', file, '--save-bag', tmp_path / 'new',
                         '--node', 'torque_predictor')

    found = read_bag(tmp_path / 'new')
    wanted = results('prediction', messages, values)
    with_residual = [prediction for prediction in wanted if prediction.residual is not None]
    assert len(wanted) == 120 - 21 > len(with_residual) == numbers['lagrange_euler']['count']
    expected = {
        'predicted_effort': (wanted, 'effort'), 'effort_residual': (with_residual, 'residual'),
        'residual_deviation': (with_residual, 'deviation'),
        'external_effort': (results('external', messages, values), 'effort')}
    assert set(found) == {f'/torque_predictor/{topic}' for topic in expected}
    arm_received = {received for _, received, content in messages if content[1] == names}
    for topic, (all_results, field) in expected.items():
        for (received, message), result in zip(found[f'/torque_predictor/{topic}'], all_results,
                                               strict=True):
            stamp = message.header.stamp
            assert stamp.sec * 10 ** 9 + stamp.nanosec == result.stamp_ns
            assert received in arm_received and message.name == list(names)
            assert message.header.frame_id == 'world'
            for name, row in (('position', result.q), ('velocity', result.qd),
                              ('effort', getattr(result, field))):
                np.testing.assert_allclose(getattr(message, name), row, rtol=0, atol=1e-9)
