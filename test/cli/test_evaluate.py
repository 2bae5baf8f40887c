"""The command evaluate: report, numbers, a new bag, and what is refused."""

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
NUMBERS = ('rms', 'mean_abs', 'signed_mean', 'correlation')


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
    """Return a function that evaluates without drawing figures, and returns summary.json."""
    from baxter_dynamics_ros.report import evaluation_report
    from baxter_dynamics_ros.report.drawing import Picture
    monkeypatch.setattr(evaluation_report, 'effort_picture',
                        lambda name, *_: Picture(name, '', b'<svg/>'))

    def run(*arguments):
        code, _, err = command('evaluate', *arguments, '--output', tmp_path / 'report', '--force')
        assert (code, err) == (0, '')
        return json.loads((tmp_path / 'report' / 'summary.json').read_text())
    return run


def predictions(messages, values=None):
    """Return the node's predictions of some joint states, one after the other."""
    predictor = Predictor(PredictorSettings.from_parameters(values or {}))
    found = [predictor.handle(*content).prediction for _, _, content in messages
             if not isinstance(content, str)]
    return [prediction for prediction in found if prediction is not None]


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
    effort, error = (np.array([getattr(p, field) for p in predictions(messages)])
                     for field in ('effort', 'residual'))
    correlation = [np.corrcoef(effort[:, i] + error[:, i], effort[:, i])[0, 1] for i in range(7)]
    for method in ('lagrange_euler', 'newton_euler'):
        found = numbers[method]
        assert found['count'] == len(error)
        np.testing.assert_allclose(found['rms'], np.sqrt((error ** 2).mean(0)), atol=1e-9)
        np.testing.assert_allclose(found['mean_abs'], np.abs(error).mean(0), atol=1e-9)
        np.testing.assert_allclose(found['signed_mean'], error.mean(0), atol=1e-9)
        np.testing.assert_allclose(found['correlation'], correlation, atol=1e-9)
    np.testing.assert_allclose(numbers['lagrange_euler']['signed_mean'], BIAS['right'], atol=0.02)
    with open(folder / 'summary.csv', encoding='utf-8-sig', newline='') as file:
        rows = list(csv.DictReader(file))
    assert [(row['recording'], row['method'], row['joint']) for row in rows] == [
        ('run', method, joint) for method in ('lagrange_euler', 'newton_euler')
        for joint in JOINTS]
    for name in NUMBERS:
        column = name if name == 'correlation' else f'{name} [N m]'
        assert [float(row[column]) for row in rows[:7]] == numbers['lagrange_euler'][name]
    for joint, value in zip(JOINTS, numbers['lagrange_euler']['rms']):
        assert any(line.split()[:2] == [joint, f'{value:.3f}'] for line in out.splitlines())


def test_arm_and_parameter_file(summary, make_bag, both_arms, tmp_path):
    """The arm is the one that is named, or else the parameter file's."""
    bag = make_bag(both_arms)
    named = summary(bag, '--arm', 'left')
    assert named['arm'] == 'left'
    np.testing.assert_allclose(named['lagrange_euler']['signed_mean'], BIAS['left'], atol=0.02)
    values = {'effort_model.bias': BIAS['left'], 'payload.mass': 0.4}
    told = summary(bag, '--params', parameter_file(tmp_path / 'my_robot.yaml', 'left', **values))
    assert (told['arm'], told['parameters']) == ('left', 'my_robot.yaml')
    error = [p.residual for p in predictions(both_arms, {'arm': 'left', **values})]
    for method in ('lagrange_euler', 'newton_euler'):
        np.testing.assert_allclose(told[method]['rms'], np.sqrt(np.mean(np.square(error), axis=0)),
                                   atol=1e-9)


def test_several_bags(summary, make_bag, moving_arm):
    """Of different arms, too: the numbers at the top are of all their samples."""
    right, left = moving_arm(60), moving_arm(100, 'left')
    numbers = summary(make_bag(right, 'sqlite3', 'one'), make_bag(left, 'ros1', 'two'))
    assert numbers['arm'] == 'left, right'
    assert [(each['name'], each['arm']) for each in numbers['recordings']] == [
        ('one', 'right'), ('two', 'left')]
    error = [p.residual for p in predictions(right) + predictions(left, {'arm': 'left'})]
    assert numbers['lagrange_euler']['count'] == len(error) == 160 - 2 * 21
    np.testing.assert_allclose(numbers['lagrange_euler']['signed_mean'], np.mean(error, axis=0),
                               atol=1e-9)


def test_the_new_bag_holds_what_the_node_would_publish(summary, make_bag, moving_arm, tmp_path):
    messages = moving_arm(120)
    for i in range(40, 45):  # effort is missing
        topic, received, content = messages[i]
        messages[i] = topic, received, (*content[:4], ())
    gripper = (10 ** 18, GRIPPER, [0.0, 0.1], [0.0, 0.0], [0.0, 0.0])
    messages.insert(40, (messages[39][0], messages[39][1] + 5, gripper))
    messages += [('/talk', messages[-1][1] + 1, 'hello'), ('/talk', messages[-1][1] + 2, 'you')]
    values = {'effort_model.bias': BIAS['right'], 'effort_model.dahl': [0.3] * 7}
    file = parameter_file(tmp_path / 'p.yaml', 'right', **values)
    bag, new = make_bag(messages), tmp_path / 'new'
    numbers = summary(bag, '--params', file, '--save-bag', new)

    from rosbags.highlevel import AnyReader
    with AnyReader([new]) as reader:
        found = {}
        for connection, received, raw in reader.messages():
            found.setdefault(connection.topic, []).append(
                (received, reader.deserialize(raw, connection.msgtype)))
    assert set(found) == {f'/torque_predictor/{topic}' for topic in (
        'predicted_effort', 'effort_residual', 'residual_deviation', 'external_effort')}
    wanted, external = predictions(messages, values), []
    predictor = Predictor(PredictorSettings.from_parameters(values), external=True)
    for _, _, content in messages:
        if not isinstance(content, str):
            step = predictor.handle(*content)
            external += [step.external] if step.external else []
    without = [p for p in wanted if p.residual is None]
    assert len(wanted) == 120 - 21 and without
    residuals = [p for p in wanted if p.residual is not None]
    arm_received = [received for _, received, content in messages
                    if content[1] == joint_names('right')]
    for topic, expected, field in (('predicted_effort', wanted, 'effort'),
                                   ('effort_residual', residuals, 'residual'),
                                   ('residual_deviation', residuals, 'deviation'),
                                   ('external_effort', external, 'effort')):
        published = found[f'/torque_predictor/{topic}']
        assert len(published) == len(expected)
        for (received, message), prediction in zip(published, expected):
            stamp = message.header.stamp.sec * 10 ** 9 + message.header.stamp.nanosec
            assert stamp == prediction.stamp_ns
            assert received in arm_received
            assert message.name == list(joint_names('right'))
            for name, values in (('position', prediction.q), ('velocity', prediction.qd),
                                 ('effort', getattr(prediction, field))):
                np.testing.assert_allclose(getattr(message, name), values, rtol=0, atol=1e-9)
    assert numbers['lagrange_euler']['count'] == len(residuals)


@pytest.mark.parametrize('options, line', [
    (['--output', 'file'], '--output: {tmp}/file is not a folder'),
    (['--output', 'file/below', '--save-bag', 'new'], '--output: {tmp}/file is not a folder'),
    (['--save-bag', 'run'], 'run: exists; choose a new folder or remove it first'),
    (['--save-bag', 'none/new'], 'none/new: no folder none'),
    (['--save-bag', 'out', '--output', 'out'],
     '--save-bag: {tmp}/out is the folder of the report'),
    (['--params', 'none.yaml'], 'none.yaml: cannot be read (No such file or directory)'),
    (['--params', 'left.yaml'], 'run: /robot/joint_states has no joints of the left arm, only '
     'right_e0, right_e1, right_s0, right_s1, right_w0, right_w1, right_w2'),
    (['--topic', '/none'], 'run: no joint states in CDR or ROS 1 encoding on /none; it has '
     '/robot/joint_states (sensor_msgs/msg/JointState, cdr)'),
    (['run', '--save-bag', 'new'], '--save-bag: expected one recording, got 2'),
], ids=lambda value: ' '.join(value) if isinstance(value, list) else '')
def test_a_refusal_is_one_line_and_writes_nothing(
        refused, make_bag, moving_arm, tmp_path, options, line):
    make_bag(moving_arm(30))
    (tmp_path / 'file').write_text('mine')
    parameter_file(tmp_path / 'left.yaml', 'left')
    assert refused('evaluate', 'run', *options) == line.format(tmp=tmp_path)


def test_a_folder_that_cannot_be_written_is_refused_before_work_begins(
        refused, make_bag, moving_arm, closed, tmp_path):
    make_bag(moving_arm(30))
    folder = tmp_path / 'locked'
    folder.mkdir()
    for arguments in (('evaluate', 'run', '--output', 'locked/below'),
                      ('calibrate', 'run', '--output', 'locked/robot.yaml')):
        with closed(folder, 0o555):
            assert refused(*arguments) == (
                f'--output: {folder} cannot be written (Permission denied)')


def test_a_report_that_cannot_be_written_leaves_no_new_bag(
        command, make_bag, moving_arm, tmp_path):
    bag = make_bag(moving_arm(30))
    (tmp_path / 'report').mkdir()
    (tmp_path / 'report' / 'figures').write_text('mine')
    code, _, err = command('evaluate', bag, '--output', tmp_path / 'report', '--save-bag',
                           tmp_path / 'new', '--force')
    assert code == 1 and 'report: cannot be written' in err and 'figures is a file' in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ['report', 'run']


def test_a_file_without_recordings_is_refused(refused, tmp_path):
    nothing = np.zeros((0, 7))
    np.savez(tmp_path / 'run.npz', joint_names=JOINTS, period=0.01, recording=np.zeros(0, int),
             recording_names=np.array([], str), position=nothing, velocity=nothing,
             effort=nothing)
    assert refused('evaluate', 'run.npz') == 'run.npz: no recordings'
