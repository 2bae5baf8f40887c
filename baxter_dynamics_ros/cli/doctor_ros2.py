"""Checks of ROS 2, from the joint states to the residual."""

from collections.abc import Callable, Iterator
import os
import time

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier
from sensor_msgs.msg import JointState

from .doctor_robot import Check
from ..model.joints import JOINTS
from ..nodes import topics
from ..nodes.messages import from_field

_PATIENCE = 5.0  # timeout of discovery, and for a message [s]
_LOOK = 2.0  # duration of the residuals [s]


class _Probe:
    """A node that inspects the graph and collects messages while it waits."""

    def __init__(self) -> None:
        self.node = Node(f'doctor_{os.getpid()}', enable_rosout=False,
                         start_parameter_services=False)

    def collect(self, kind: type, topic: str) -> list[JointState]:
        """Subscribe to a topic; return the list that receives its messages."""
        kept: list[JointState] = []
        self.node.create_subscription(kind, topic, kept.append, topics.SUBSCRIPTION_QOS)
        return kept

    def wait(self, condition: Callable[[], object], seconds: float = _PATIENCE) -> bool:
        """Spin until a condition holds; return whether it does."""
        limit = time.monotonic() + seconds
        while not condition() and time.monotonic() < limit:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return bool(condition())


def ros2_checks(topic: str) -> Iterator[Check]:
    """Yield the checks of ROS 2 in order; a failure ends them."""
    rclpy.init(args=[])
    try:
        probe = _Probe()
        for check in _checks(probe, topic):
            yield check
            if not check.passed:
                return
    finally:
        rclpy.try_shutdown()


def _checks(probe: _Probe, topic: str) -> Iterator[Check]:
    reach = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    domain = os.environ.get('ROS_DOMAIN_ID') or 0
    yield Check('ROS 2', True, f'{get_rmw_implementation_identifier()}, domain {domain}, '
                f'discovery range {reach}')
    diagnostics = probe.collect(DiagnosticArray, topics.DIAGNOSTICS)
    probe.wait(lambda: _named(probe, topic))
    yield _publishers(probe, topic)
    states = probe.collect(JointState, topic)
    yield Check('ROS 2 data', probe.wait(lambda: states), f'joint states on {topic}' if states
                else f'no joint states on {topic}',
                'see the diagnostics of its publisher')
    yield from _predictors(probe, diagnostics)


def _named(probe: _Probe, topic: str) -> bool:
    """Return whether there are publishers whose node names are known."""
    found = probe.node.get_publishers_info_by_topic(topic)
    return bool(found) and not any('UNKNOWN' in info.node_name for info in found)


def _publishers(probe: _Probe, topic: str) -> Check:
    found = probe.node.get_publishers_info_by_topic(topic)
    listed = ', '.join(f'{info.node_name} ({info.qos_profile.reliability.name.lower()}, '
                       f'{info.qos_profile.durability.name.lower()})' for info in found)
    if not found:
        return Check('ROS 2 topic', False, f'{topic} has no publisher',
                     'start joint_state_bridge, or another bridge, with the same ROS_DOMAIN_ID '
                     'and RMW_IMPLEMENTATION')
    return Check('ROS 2 topic', len(found) == 1, f'{topic} is published by {listed}',
                 'joint states may arrive twice: stop all publishers but one')


def _predictors(probe: _Probe, diagnostics: list[DiagnosticArray]) -> Iterator[Check]:
    """Check whether there are predictors, and the residual of each."""
    def found() -> list[str]:
        return [name for name, _ in probe.node.get_topic_names_and_types()
                if name.endswith('/' + topics.EFFORT_RESIDUAL)
                and probe.node.count_publishers(name)]
    if not probe.wait(found):
        yield Check('predictor', False, 'no torque_predictor is running',
                    'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml')
        return
    for name in found():
        residuals = probe.collect(JointState, name)
        if not probe.wait(lambda: residuals):
            yield Check('residual', False, f'nothing arrives on {name}', _advice(diagnostics))
            continue
        probe.wait(lambda: False, _LOOK)
        rms = np.sqrt(np.mean([from_field(each.effort) ** 2 for each in residuals], axis=0))
        yield Check('residual', True, f'RMS on {name} [N m]: ' + ' '.join(
            f'{joint} {value:.2f}' for joint, value in zip(JOINTS, rms)))


def _advice(diagnostics: list[DiagnosticArray]) -> str:
    """Return the problems in the diagnostics of the predictor."""
    said = {status.name: status.message for array in diagnostics for status in array.status
            if 'torque_predictor' in status.name and status.level != status.OK}
    return '; '.join(said.values()) or 'see the diagnostics of torque_predictor'
