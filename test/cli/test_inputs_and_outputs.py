"""Input and output of the commands: stamps, overwriting, parameter files, the user's settings."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

COMMAND = [sys.executable, '-m', 'baxter_dynamics_ros.cli.main']


@pytest.fixture
def evaluated(make_bag):
    """Return a function that evaluates messages: count and RMS of the residual, and warnings."""
    pytest.importorskip('pinocchio', reason='needs Pinocchio: pip install ".[offline]"')

    def run(messages):
        from baxter_dynamics_ros.estimation.settings import PredictorSettings
        from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator
        from baxter_dynamics_ros.recordings.reader import open_recordings
        (recording,) = open_recordings([make_bag(messages)], None, None)
        with recording:
            evaluation = Evaluator(PredictorSettings()).evaluate(recording)
        errors = evaluation.methods['lagrange_euler']
        return errors.count, errors.rms, [*map(str, evaluation.notices)]
    return run


@pytest.mark.parametrize('change, told', [
    (lambda i, stamp: 0, '600 x unstamped: header stamps are zero: using the time of receipt'),
    (lambda i, stamp: 0 if i < 100 else stamp + 1000, '100 x unstamped'),
], ids=['zero', 'some zero'])
def test_zero_stamps_are_replaced_by_times_of_recording(evaluated, moving_arm, change, told):
    count, rms, warnings = evaluated([
        (topic, received, (change(i, content[0]), *content[1:]))
        for i, (topic, received, content) in enumerate(moving_arm(600))])
    assert any(told in warning for warning in warnings), warnings
    assert 300 < count < 600 - 21 and np.max(rms) < 0.2  # without the time of detection


def test_lost_messages_are_not_times_of_arrival(evaluated, moving_arm):
    messages = moving_arm(600)
    del messages[300:317], messages[100:400:3]
    _, _, warnings = evaluated(messages)
    assert (f'{600 - len(messages)} messages are lost: stamps are missing from their regular '
            'period of 10.0 ms') in warnings
    assert not any('times of arrival' in warning for warning in warnings)


def test_the_arm_is_found_behind_other_messages(evaluated, moving_arm):
    grippers = [('/robot/joint_states', 10**17 + i, (10**17 + i, ['gripper'], *np.zeros((3, 1))))
                for i in range(1200)]
    assert evaluated(grippers + moving_arm(60))[0] == 60 - 21


@pytest.mark.parametrize('arguments, line', [
    (['evaluate', 'run'], '--output: {tmp}/baxter_evaluation exists; choose another name, or '
     'replace it with --force'),
    (['calibrate', 'run', '-o', 'report.yaml'], '--output: {tmp}/report.html exists; choose '
     'another name, or replace it with --force'),
    (['calibrate', 'run', '-o', 'run/metadata.yaml', '--force'],
     '--output: {tmp}/run/metadata.yaml belongs to the input run'),
    (['calibrate', 'run', '--params', 'my_robot.yaml', '-o', 'link.yaml', '--force'],
     '--output: {tmp}/link.yaml belongs to the input my_robot.yaml'),
    (['evaluate', 'run', '-o', 'run', '--force'], '--output: {tmp}/run belongs to the input run'),
], ids=lambda value: ' '.join(value) if isinstance(value, list) else '')
def test_nothing_is_overwritten_without_force_and_inputs_never(
        refused, make_bag, moving_arm, tmp_path, arguments, line):
    make_bag(moving_arm(30))
    (tmp_path / 'my_robot.yaml').write_text('/**:\n  ros__parameters: {payload.mass: 0.3}\n')
    os.link(tmp_path / 'my_robot.yaml', tmp_path / 'link.yaml')
    (tmp_path / 'baxter_evaluation').mkdir()
    (tmp_path / 'baxter_evaluation' / 'notes').write_text('mine')
    (tmp_path / 'report.html').write_text('mine')
    assert refused(*arguments) == line.format(tmp=tmp_path)


def test_parameter_files_of_a_node_merge(command, make_bag, moving_arm, tmp_path):
    bias = [0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.05]
    bag = make_bag(moving_arm(150, truth={'effort_model.bias': bias}))
    for name, text in (('a', f'/robot1/torque_predictor:\n  ros__parameters: {{bias: {bias}}}\n'),
                       ('b', '/**:\n  ros__parameters: {arm: right, publish_rate: 5.0}\n'),
                       ('c', '/other:\n  ros__parameters: {payload.mass: 2.0}\n')):
        (tmp_path / f'{name}.yaml').write_text(text.replace('bias:', 'effort_model.bias:'))
    code, out, err = command(
        'evaluate', bag, *(word for name in 'abc'
                           for word in ('--params', tmp_path / f'{name}.yaml')),
        '--node', '/robot1/torque_predictor', '--output', tmp_path / 'report')
    assert (code, err) == (0, '') and 'ignoring publish_rate' in out
    numbers = json.loads((tmp_path / 'report' / 'summary.json').read_text())
    assert numbers['parameters'] == 'a.yaml, b.yaml, c.yaml'
    assert np.max(numbers['lagrange_euler']['rms']) < 0.05


def test_figures_depend_on_no_setting_of_the_user(make_bag, moving_arm, tmp_path):
    make_bag(moving_arm(60))
    environment = {**os.environ, 'MPLBACKEND': 'module://matplotlib_inline.backend_inline',
                   'PATH': ''}
    (tmp_path / 'matplotlibrc').write_text('text.usetex: True\naxes.prop_cycle: cycler(lw=[9])\n')
    figures = []
    for output in ('one', 'two'):
        done = subprocess.run([*COMMAND, 'evaluate', 'run', '--output', output], cwd=tmp_path,
                              env=environment, text=True, capture_output=True, timeout=120)
        assert (done.returncode, done.stderr) == (0, '')
        figures.append((tmp_path / output / 'figures/01_run_effort_s0.svg').read_text())
        (tmp_path / 'matplotlibrc').unlink(missing_ok=True)
    assert figures[0] == figures[1]
