"""Clients that flood the services: every joint state is answered all the same."""

import subprocess
import sys
import time

from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes.messages import joint_state
import numpy as np
import pytest
import rclpy
from rclpy.node import Node

srv = pytest.importorskip('baxter_dynamics_interfaces.srv',
                          reason='needs pip install ./baxter_dynamics_interfaces')

CLIENTS = 8
SERVICES = ((srv.GravityTorques, 'gravity_torques'), (srv.InverseDynamics, 'inverse_dynamics'))
SENT = 150  # joint states


@pytest.fixture
def flood(domain):
    """Return a function that runs the clients for a while, and returns when they have begun."""
    processes = []

    def start(seconds):
        processes.append(subprocess.Popen(
            [sys.executable, __file__, str(seconds)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, text=True))
        assert processes[-1].stdout.readline() == 'flooding\n'
        return processes[-1]
    yield start
    for process in processes:
        process.kill()
        process.wait()
        process.stdout.close()


def test_a_flood_of_requests_costs_no_joint_state(robot, start_predictor, flood, stamps):
    start_predictor()
    clients = flood(3.0)
    phase = 0.01 * np.arange(SENT)[:, None] + np.arange(7.0)
    robot.stream(zip(0.3 + 0.2 * np.sin(phase), 0.2 * np.cos(phase), np.ones((SENT, 7))))
    robot.until(lambda: len(robot.residual) == SENT - 21, 30.0)
    assert set(np.diff(stamps(robot.residual))) == {10_000_000}
    assert int(clients.communicate()[0]) > 0, 'no flood'


def main(seconds):
    """Be the clients: each sends its next request as soon as it has an answer."""
    rclpy.init()
    node = Node('clients', start_parameter_services=False)
    state = joint_state(joint_names('right'), 1, *np.full((2, 7), 0.3))
    answers = []

    def ask(client):
        future = client.call_async(client.srv_type.Request(state=state))
        future.add_done_callback(lambda future: (answers.append(future.result().success),
                                                 ask(client)))
    clients = [node.create_client(kind, f'/torque_predictor/{name}')
               for kind, name in SERVICES * (CLIENTS // len(SERVICES))]
    for client in clients:
        client.wait_for_service(15.0)
        ask(client)
    while len(answers) < CLIENTS:
        rclpy.spin_once(node)
    print('flooding', flush=True)
    begin, before = time.monotonic(), len(answers)
    while time.monotonic() < begin + seconds:
        rclpy.spin_once(node)
    assert all(answers)
    print(len(answers) - before)


if __name__ == '__main__':
    main(float(sys.argv[1]))
