"""The robot beside a predictor: a ROS node that publishes joint states and gathers results."""

from itertools import count, cycle
import os
import time

from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.estimation.settings import DEFAULTS
from baxter_dynamics_ros.model import joint_names
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state
from baxter_dynamics_ros.nodes.rclpy_internals import take_waiting
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

PATIENCE = 30.0  # time limit of a condition, long enough for a busy machine [s]

# Tests that count messages must not lose any on a busy machine, so they override the default.
LOSSLESS = ('-p', 'qos_overrides./robot/joint_states.subscription.reliability:=reliable',
            '-p', 'qos_overrides./robot/joint_states.subscription.depth:=5000')

# The order in which the robot publishes, written out: 17 joints, alphabetical within an arm.
SDK_NAMES = ('head_nod head_pan left_e0 left_e1 left_s0 left_s1 left_w0 left_w1 left_w2 right_e0 '
             'right_e1 right_s0 right_s1 right_w0 right_w1 right_w2 torso_t0').split()


class Robot(Node):
    """The robot, and a listener to the predictor's topics."""

    def __init__(self):
        super().__init__('robot')
        self.predicted, self.residual, self.diagnostics = [], [], []
        self.publisher = self.create_publisher(JointState, topics.JOINT_STATES, 5000)
        for topic, kind, kept in (
                ('/torque_predictor/predicted_effort', JointState, self.predicted),
                ('/torque_predictor/effort_residual', JointState, self.residual),
                ('/diagnostics', DiagnosticArray, self.diagnostics)):
            self.create_subscription(kind, topic, kept.append, 1000)
        self._predictor = self._key = None
        self.acts = False  # whether it has a client of an action
        self._own = {*self.subscriptions, *self.publishers}

    def forget(self):
        """Forget all messages, and end what a test has added."""
        for kept in (self.predicted, self.residual, self.diagnostics):
            kept.clear()
        for each in {*self.subscriptions, *self.publishers, *self.clients} - self._own:
            for destroy in (self.destroy_subscription, self.destroy_publisher,
                            self.destroy_client):
                destroy(each)

    def listen(self, kind, topic: str) -> list:
        """Return the list in which the messages of a topic gather, once somebody publishes it."""
        kept = []
        subscription = self.create_subscription(kind, topic, kept.append, 1000)
        self.until(lambda: self.count_publishers(subscription.topic_name) > 0)
        return kept

    def spin(self, seconds: float):
        """Let messages come in for a while."""
        self.until(lambda: False, seconds, fail=False)

    def until(self, condition, seconds: float = PATIENCE, fail: bool = True):
        """Let messages come in until a condition holds; fail when it does not in time."""
        limit = time.monotonic() + seconds
        while True:
            for subscription in list(self.subscriptions):  # cheaper than an executor
                for message, _ in take_waiting(subscription, 1000):
                    subscription.callback(message)
            if self.acts or any(True for _ in self.clients):
                rclpy.spin_once(self, timeout_sec=0.0)
            left = limit - time.monotonic()
            if condition() or left <= 0.0 and not fail:
                return
            assert left > 0.0, f'nothing within {seconds} s'
            time.sleep(min(left, 0.002))

    def start_predictor(self, *arguments, **environment) -> NodeProcess:
        """Return a running predictor: that of the test before, if it has the same arguments."""
        key = arguments, environment
        if self._predictor is None or self._predictor.poll() is not None or key != self._key:
            self.end_predictor()
            self.diagnostics.clear()
            self._key = key
            self._predictor = NodeProcess('torque_predictor', [
                '--ros-args', *LOSSLESS, *arguments], {**os.environ, **environment})
            self.wait_for_node()
        else:
            before = -1
            while len(self.predicted) > before:  # joint states and results of the test before
                before = len(self.predicted)
                self.spin(0.15)
            self.call(Trigger, 'reset')
        self.predicted.clear()
        self.residual.clear()
        return self._predictor

    def end_predictor(self):
        """End the predictor, if there is one."""
        if self._predictor is not None:
            with self._predictor:
                self._predictor = None
            self.until(lambda: self.publisher.get_subscription_count() == 0)

    def wait_for_node(self):
        """Wait until the predictor has found us, which its first diagnostics prove."""
        self.until(lambda: self.publisher.get_subscription_count() > 0 and self.statuses())

    def send(self, stamp: int, names, position, velocity=(), effort=()):
        """Publish a joint state stamped ``stamp`` [ns]."""
        self.publisher.publish(joint_state(
            names, stamp, *(np.array(x, dtype=float) for x in (position, velocity, effort))))

    def send_arm(self, stamp: int, q, qd=None, effort=None, side: str = 'right'):
        """Publish an arm's state as the robot does: among 17 joints, in the robot's order."""
        arm = joint_names(side)
        fields = []
        for values in (q, qd, effort):
            row = [] if values is None else [
                values[arm.index(name)] if name in arm else 0.1 for name in SDK_NAMES]
            fields.append(row)
        self.send(stamp, SDK_NAMES, *fields)

    def stream(self, rows, start: int = 10 ** 18, side: str = 'right', pace: float = 0.001,
               stamps=None, before=lambda stamp: None):
        """
        Publish rows (q, qd, effort) with given stamps or 10 ms apart; return the last stamp.

        They are sent every ``pace`` seconds; the node knows no clock but their stamps.
        """
        begin = time.monotonic()
        for k, (stamp, row) in enumerate(zip(stamps or count(start, 10_000_000), rows)):
            self.until(lambda: time.monotonic() >= begin + k * pace)
            before(stamp)
            self.send_arm(stamp, *row, side=side)
        return stamp

    def move_until(self, condition, rows, start: int = 10 ** 18, period: int = 10_000_000):
        """Publish rows at 100 Hz, with stamps ``period`` [ns] apart, until a condition holds."""
        for k, row in enumerate(cycle(rows)):
            if condition():
                return
            assert k < 100 * PATIENCE, f'nothing within {PATIENCE} s'
            self.send_arm(start + k * period, *row)
            self.spin(0.01)

    def move_until_report(self, condition, rows, *stamps) -> dict:
        """Publish rows as above until new diagnostics meet a condition; return them."""
        self.diagnostics.clear()
        self.move_until(lambda: self.statuses() and condition(self.statuses()[-1]), rows, *stamps)
        return self.statuses()[-1]

    def call(self, kind, name: str, request=None, node: str = 'torque_predictor'):
        """Call a service of a node."""
        client = self.create_client(kind, f'/{node}/{name}')
        assert client.wait_for_service(timeout_sec=PATIENCE), f'no service {name}'
        future = client.call_async(request or kind.Request())
        rclpy.spin_until_future_complete(self, future, timeout_sec=PATIENCE)
        assert future.done(), f'no answer of {name}'
        self.destroy_client(client)
        return future.result()

    def parameters(self, names=DEFAULTS) -> dict:
        """Return the values of parameters of the predictor, all settings by default."""
        answer = self.call(GetParameters, 'get_parameters', GetParameters.Request(names=[*names]))
        values = map(parameter_value_to_python, answer.values)
        return {name: value if isinstance(value, (str, bool, int, float)) else tuple(value)
                for name, value in zip(names, values, strict=True)}

    def configure(self, values: dict, node: str = 'torque_predictor'):
        """Set parameters as one change; return the result."""
        request = SetParametersAtomically.Request(parameters=[
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()])
        return self.call(
            SetParametersAtomically, 'set_parameters_atomically', request, node).result

    def statuses(self, node: str = 'torque_predictor') -> list:
        """Return the diagnostics of a node so far, each as status name to (level, text, keys)."""
        return [{status.name.removeprefix(f'{node}: '): (
            status.level, status.message, {pair.key: pair.value for pair in status.values})
            for status in message.status} for message in self.diagnostics
            if message.status and message.status[0].name.startswith(f'{node}: ')]

    def report(self, node: str = 'torque_predictor') -> dict:
        """Return the next diagnostics."""
        self.diagnostics.clear()
        self.until(lambda: self.statuses(node))
        return self.statuses(node)[-1]
