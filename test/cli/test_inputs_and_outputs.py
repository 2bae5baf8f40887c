"""What the commands read and write: stamps, overwriting, parameter files, a user's settings."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

COMMAND = [sys.executable, '-m', 'baxter_dynamics_ros.cli.main']


@pytest.mark.parametrize('change, told', [
    (lambda i, stamp: 0, '300 of 300 messages have no stamp: using times of recording'),
    (lambda i, stamp: 10**18, 'all stamps are the same: using times of recording'),
    (lambda i, stamp: 0 if i < 100 else stamp + 1000, '100 of 300 messages have no stamp'),
], ids=['zero', 'still', 'some zero'])
def test_unusable_stamps_are_replaced_by_times_of_recording(
        command, make_bag, moving_arm, tmp_path, change, told):
    messages = [(topic, received, (change(i, content[0]), *content[1:]))
                for i, (topic, received, content) in enumerate(moving_arm(300))]
    code, out, err = command('evaluate', make_bag(messages), '--output', tmp_path / 'report')
    assert (code, err) == (0, '') and f'warning: run: {told}' in out
    numbers = json.loads((tmp_path / 'report' / 'summary.json').read_text())
    assert numbers['lagrange_euler']['count'] == 300 - 21
    assert np.max(numbers['lagrange_euler']['rms']) < 0.2


def test_lost_messages_are_not_times_of_arrival(command, make_bag, moving_arm, tmp_path):
    messages = moving_arm(600)
    del messages[300:317], messages[100:400:3]
    code, out, _ = command('evaluate', make_bag(messages), '--output', tmp_path / 'report')
    assert code == 0 and 'times of arrival' not in out
    (lost,) = [line for line in out.splitlines() if 'messages are lost' in line]
    assert lost == (f'warning: run: {600 - len(messages)} messages are lost: stamps are missing '
                    'from their regular period of 10.0 ms')


def test_the_arm_is_found_behind_other_messages(command, make_bag, moving_arm, tmp_path):
    grippers = [('/robot/joint_states', 10**17 + i, (10**17 + i, ['gripper'], *np.zeros((3, 1))))
                for i in range(1200)]
    bag = make_bag(grippers + moving_arm(60))
    assert command('evaluate', bag, '--output', tmp_path / 'report')[0] == 0
    other = make_bag(grippers + moving_arm(60, topic='/joint_states'), name='other')
    code, _, err = command('evaluate', other, '--output', tmp_path / 'other_report')
    assert code == 1
    assert err.endswith('/robot/joint_states has no joints of an arm, only gripper; choose '
                        '--topic /joint_states\n')


@pytest.mark.parametrize('arguments, line', [
    (['evaluate', 'run'], '--output: {tmp}/baxter_evaluation exists; choose another name, or '
     'replace it with --force'),
    (['calibrate', 'run'], '--output: {tmp}/my_robot.yaml exists; choose another name, or '
     'replace it with --force'),
    (['calibrate', 'run', '-o', 'report.yaml'], '--output: {tmp}/report.html exists; choose '
     'another name, or replace it with --force'),
    (['calibrate', 'run', '-o', 'run/metadata.yaml', '--force'],
     '--output: {tmp}/run/metadata.yaml belongs to the input run'),
    (['calibrate', 'run', '--params', 'my_robot.yaml', '--force'],
     '--output: {tmp}/my_robot.yaml belongs to the input my_robot.yaml'),
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
    (tmp_path / 'a.yaml').write_text(
        f'/robot1/torque_predictor:\n  ros__parameters: {{effort_model: {{bias: {bias}}}}}\n')
    (tmp_path / 'b.yaml').write_text('/**:\n  ros__parameters: {arm: right, publish_rate: 5.0}\n')
    for node, limit in {'/robot1/torque_predictor': 0.05, '/torque_predictor': 0.6}.items():
        code, out, err = command(
            'evaluate', bag, '--params', tmp_path / 'a.yaml', '--params', tmp_path / 'b.yaml',
            '--node', node, '--output', tmp_path / 'report', '--force')
        assert (code, err) == (0, '') and 'ignoring publish_rate' in out
        numbers = json.loads((tmp_path / 'report' / 'summary.json').read_text())
        assert numbers['parameters'] == 'a.yaml, b.yaml'
        assert limit / 4 < np.max(numbers['lagrange_euler']['rms']) < limit


def test_figures_depend_on_no_setting_of_the_user(make_bag, moving_arm, tmp_path):
    make_bag(moving_arm(1100))
    (tmp_path / 'matplotlibrc').write_text('text.usetex: True\naxes.prop_cycle: cycler(lw=[9])\n')
    environment = {**os.environ, 'MPLBACKEND': 'module://matplotlib_inline.backend_inline',
                   'PATH': ''}
    svg = []
    for arguments in (['evaluate', 'run'], ['calibrate', 'run', '--only', 'bias']):
        answer = subprocess.run([*COMMAND, *arguments], cwd=tmp_path, env=environment, text=True,
                                capture_output=True, timeout=120)
        assert (answer.returncode, answer.stderr) == (0, '')
    svg.append((tmp_path / 'baxter_evaluation/figures/01_run_effort_s0.svg').read_text())
    (tmp_path / 'matplotlibrc').unlink()
    subprocess.run([*COMMAND, 'evaluate', 'run', '--force'], cwd=tmp_path, check=True,
                   capture_output=True, timeout=120)
    svg.append((tmp_path / 'baxter_evaluation/figures/01_run_effort_s0.svg').read_text())
    assert svg[0] == svg[1]


def test_sigterm_leaves_nothing(make_bag, moving_arm, tmp_path):
    make_bag(moving_arm(8000))
    process = subprocess.Popen([*COMMAND, 'evaluate', 'run', '--save-bag', 'new'], cwd=tmp_path,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        limit = time.monotonic() + 60.0
        while not list(tmp_path.glob('.baxter_dynamics.*')) and time.monotonic() < limit:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=20)
    finally:
        process.kill()
    assert (process.returncode, out, err) == (128 + signal.SIGTERM, '', '')
    assert [path.name for path in tmp_path.iterdir()] == ['run']
