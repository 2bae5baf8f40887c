"""Checks of ROS 2, from the joint states to the residual."""

from collections.abc import Iterator
import os

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.utilities import get_rmw_implementation_identifier
from sensor_msgs.msg import JointState

from .doctor import Check
from .listener import Listener
from ..model.joints import JOINTS
from ..nodes import topics
from ..nodes.messages import from_field

_PATIENCE = 5.0  # timeout of discovery, and for a message [s]
_LOOK = 2.0  # duration of the residuals [s]


def ros2_checks(topic: str) -> Iterator[Check]:
    """Yield the checks of ROS 2 in order; a failure ends them."""
    with Listener('doctor') as listener:
        for check in _checks(listener, topic):
            yield check
            if not check.passed:
                return


def _checks(listener: Listener, topic: str) -> Iterator[Check]:
    yield Check('ROS 2', True, f'{get_rmw_implementation_identifier()}, domain '
                f'{os.environ.get("ROS_DOMAIN_ID") or 0}, discovery range '
                f'{os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")}')
    diagnostics = listener.collect(DiagnosticArray, topics.DIAGNOSTICS)
    yield _publishers(listener, topic)
    states = listener.collect(JointState, topic)
    found = listener.wait(lambda: states, _PATIENCE)
    yield Check('ROS 2 data', found, f'{"" if found else "no "}joint states on {topic}',
                'see the diagnostics of its publisher')
    yield from _residuals(listener, diagnostics)


def _publishers(listener: Listener, topic: str) -> Check:
    """Check that one node publishes the joint states."""
    listener.wait(lambda: (found := listener.node.get_publishers_info_by_topic(topic)) and all(
        'UNKNOWN' not in each.node_name for each in found), _PATIENCE)
    publishers = [f'{each.node_name} ({each.qos_profile.reliability.name.lower()}, '
                  f'{each.qos_profile.durability.name.lower()})'
                  for each in listener.node.get_publishers_info_by_topic(topic)]
    if not publishers:
        return Check('ROS 2 topic', False, f'{topic} has no publisher',
                     'start joint_state_bridge, or another bridge, with the same ROS_DOMAIN_ID '
                     'and RMW_IMPLEMENTATION')
    return Check('ROS 2 topic', len(publishers) == 1,
                 f'{topic} is published by {", ".join(publishers)}',
                 'joint states may arrive twice: stop all publishers but one')


def _residuals(listener: Listener, diagnostics: list[DiagnosticArray]) -> Iterator[Check]:
    """Check that there are predictors, and the residual of each."""
    def found() -> list[str]:
        return [name for name, _ in listener.node.get_topic_names_and_types()
                if name.endswith('/' + topics.EFFORT_RESIDUAL)
                and listener.node.count_publishers(name)]
    if not listener.wait(found, _PATIENCE):
        yield Check('predictor', False, 'no torque_predictor is running',
                    'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml')
    for name in found():
        residuals = listener.collect(JointState, name)
        if listener.wait(lambda: residuals, _PATIENCE):
            listener.wait(lambda: False, _LOOK)
            rms = np.sqrt(np.mean([from_field(each.effort) ** 2 for each in residuals], axis=0))
            yield Check('residual', True, f'RMS on {name} [N m]: ' + ' '.join(
                f'{joint} {value:.2f}' for joint, value in zip(JOINTS, rms)))
        else:
            said = {status.name: status.message for array in diagnostics
                    for status in array.status
                    if 'torque_predictor' in status.name and status.level != status.OK}
            yield Check('residual', False, f'nothing arrives on {name}',
                        '; '.join(said.values()) or 'see the diagnostics of torque_predictor')
