"""The launch files run: beside a fake Baxter predictions arrive where they are asked for."""

import os

from document_setup import REPOSITORY
import pytest

for module in ('rclpy', 'mujoco', 'markdown_it', 'yaml'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')

from document_checkout import launchers  # noqa: E402, I100
from document_launch import LaunchError, nodes  # noqa: E402
from document_page import Page  # noqa: E402
from document_stand_ins import StandIns  # noqa: E402

HEAVY = '/**:\n  ros__parameters:\n    payload:\n      mass: 1.25\n'


@pytest.fixture
def reader(tmp_path, monkeypatch):
    """Return a function that makes a page of commands, in an empty folder."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    path = launchers(tmp_path / 'bin', REPOSITORY)

    def page(*lines):
        page = Page('launch', '\n'.join(['```bash', *lines, '```']), REPOSITORY, path,
                    StandIns(tmp_path))
        page.folder = tmp_path
        assert page.work_through() == []
        return page.said
    return page


def test_the_predictors_launch_file_takes_arm_parameters_namespace_and_input(reader, tmp_path):
    (tmp_path / 'heavy.yaml').write_text(HEAVY)
    echo = 'ros2 topic echo --once --field name /left_side/torque_predictor/predicted_effort'
    get = 'ros2 param get /left_side/torque_predictor payload.mass'
    said = reader(
        'ros2 run baxter_dynamics_ros fake_baxter --ros-args -p arm:=left '
        '-r /robot/joint_states:=/elsewhere',
        'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml arm:=left '
        f'namespace:=left_side joint_states:=/elsewhere params:={tmp_path}/heavy.yaml',
        echo, get)
    assert said[echo].count('left_') == 7 and 'right_' not in said[echo]
    assert '1.25' in said[get]


def test_the_demos_launch_file_needs_nothing_and_leaves_a_robots_topic_alone(reader):
    echo = 'ros2 topic echo --once --field name /torque_predictor/effort_residual'
    info = 'ros2 topic list'
    said = reader('ros2 launch baxter_dynamics_ros demo.launch.xml arm:=left', echo, info)
    assert said[echo].count('left_') == 7
    topics = said[info].split()
    assert '/torque_predictor/contact' in topics and '/robot/joint_states' not in topics


def test_without_arguments_it_is_the_right_arm_with_its_parameter_file():
    (command,) = nodes(REPOSITORY / 'launch' / 'torque_predictor.launch.xml', {})
    assert command == [
        'torque_predictor', '--ros-args', '--params-file',
        str(REPOSITORY / 'config' / 'right_arm.yaml'), '-r', '__node:=torque_predictor', '-p',
        'arm:=right', '-p', 'use_sim_time:=false', '-r',
        '/robot/joint_states:=/robot/joint_states']


def test_a_robot_is_bridged_by_the_same_file():
    predictor, bridge = nodes(REPOSITORY / 'launch' / 'torque_predictor.launch.xml', {
        'robot': 'http://011303P0017.local:11311'})
    assert predictor[0] == 'torque_predictor'
    assert bridge == ['joint_state_bridge', '--ros-args', '-r', '__node:=joint_state_bridge', '-p',
                      'master_uri:=http://011303P0017.local:11311', '-r',
                      '/robot/joint_states:=/robot/joint_states']


def test_a_simulated_robot_has_simulated_time_and_no_springs():
    (command,) = nodes(REPOSITORY / 'launch' / 'torque_predictor.launch.xml', {
        'simulation': 'true', 'joint_states': '/joint_states', 'arm': 'left'})
    assert str(REPOSITORY / 'config' / 'simulation.yaml') in command
    assert {'use_sim_time:=true', 'arm:=left',
            '/robot/joint_states:=/joint_states'} <= set(command)


def test_both_arms_have_a_parameter_file():
    (command,) = nodes(REPOSITORY / 'launch' / 'torque_predictor.launch.xml', {'arm': 'both'})
    assert str(REPOSITORY / 'config' / 'both_arm.yaml') in command and 'arm:=both' in command


@pytest.mark.parametrize('given, problem', [
    ({'speed': '3'}, 'has no arguments'), ({'arm': 'head'}, 'head')])
def test_a_wrong_argument_is_refused(given, problem):
    with pytest.raises(LaunchError, match=problem):
        nodes(REPOSITORY / 'launch' / 'torque_predictor.launch.xml', given)


@pytest.mark.parametrize('text, problem', [
    ('<group/><push-ros-namespace/>', 'push-ros-namespace'),
    ('<node pkg="baxter_dynamics_ros" exec="gone"/>', 'no gone in'),
    ('<node pkg="baxter_dynamics_ros" exec="fake_baxter" nam="x"/>', 'nam'),
    ('<node pkg="baxter_dynamics_ros" exec="fake_baxter"><param from="gone.yaml"/></node>',
     'there is no gone.yaml'),
    ('<include file="$(dirname)/gone.launch.xml"/>', 'dirname'),
    ('<arg name="arm"/>', 'is not given'),
])
def test_a_wrong_launch_file_is_refused(tmp_path, text, problem):
    file = tmp_path / 'wrong.launch.xml'
    file.write_text(f'<launch>{text}</launch>')
    with pytest.raises(LaunchError, match=problem):
        nodes(file, {})
