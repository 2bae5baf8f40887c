"""Node joint_state_bridge: republishes joint states of a ROS 1 robot in ROS 2, read-only."""

from contextlib import suppress
from functools import partial
import os
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidTopicNameException
from sensor_msgs.msg import JointState

from . import topics
from .diagnostic_updater import DiagnosticUpdater, ERROR, first_case, OK, WARN
from .messages import set_stamp
from .process import run
from .ros_parameters import ParameterNode
from ..model import ArgumentError, Setting
from ..ros1 import wire
from ..ros1.source import Source
from ..ros1.subscriber import Subscriber

CLOCKS = ('local', 'robot', 'receipt')


class JointStateBridge(ParameterNode):
    """Republishes the joint states of a ROS 1 robot in ROS 2; never publishes to the robot."""

    def __init__(self) -> None:
        super().__init__('joint_state_bridge')
        values = self.declare_settings((
            Setting('master_uri', os.environ.get('ROS_MASTER_URI', ''),
                    'URI of the ROS 1 master, such as http://011303P0017.local:11311; '
                    'ROS_MASTER_URI by default.', read_only=True),
            Setting('clock', CLOCKS[0], "Stamps. local: the robot's stamps, shifted to this "
                    "machine's clock. robot: the robot's stamps. receipt: times of arrival.",
                    choices=CLOCKS, read_only=True)))
        names = self.declare_parameter('topics', [topics.JOINT_STATES], ParameterDescriptor(
            description='Topics of sensor_msgs/JointState to republish.', read_only=True)).value
        self.check_given_names()
        master_uri, self._clock_mode = values['master_uri'], values['clock']
        if not master_uri:
            raise ArgumentError('master_uri', 'expected the URI of the ROS 1 master: set '
                                '-p master_uri:=http://HOST:11311 or ROS_MASTER_URI')
        # rclpy declares an empty list as None.
        self._topics = {name: self._publisher(name) for name in dict.fromkeys(names or [''])}
        DiagnosticUpdater(self, 'baxter', self._report)
        try:  # last: from here on the node is registered with the master, until it is destroyed
            self._subscriber = Subscriber(master_uri, self._topics, self._on_joint_state,
                                          self.get_logger().info)
        except wire.Ros1Error as error:
            raise ArgumentError('master_uri', str(error)) from None
        self.get_logger().info(f'subscribing to {", ".join(self._topics)} on {master_uri}')

    def destroy_node(self) -> None:
        """Unregister from the master, then destroy the node."""
        if hasattr(self, '_subscriber'):  # otherwise a parameter was invalid
            self._subscriber.close()
        super().destroy_node()

    def _on_joint_state(self, topic: str, source: Source, state: wire.JointState,
                        arrival_ns: int) -> None:
        """Publish a joint state; called from one thread at a time."""
        message = JointState(name=state.name, position=state.position, velocity=state.velocity,
                             effort=state.effort)
        message.header.frame_id = state.frame_id
        set_stamp(message.header, self._stamp(source, state.stamp_ns, arrival_ns))
        if self.context.ok():
            self._topics[topic].publish(message)

    def _stamp(self, source: Source, stamp_ns: int, arrival_ns: int) -> int:
        if self._clock_mode == 'robot':
            return stamp_ns
        if self._clock_mode == 'receipt' or not stamp_ns:
            return arrival_ns
        return stamp_ns + source.clock.offset_ns

    def _report(self, period: float) -> dict[str, DiagnosticStatus]:
        """Return all statuses, given the time since the last report [s]."""
        subscriber = self._subscriber
        master, problem = subscriber.master, subscriber.problem
        return {'master': first_case(
            {'address': master.address, 'reachable from the master': subscriber.is_called,
             'malformed headers and messages': subscriber.malformed,
             'reconnections': subscriber.reconnections},
            (problem, ERROR, str(problem)),
            (True, OK, f'connected to http://{master.host}:{master.port}/')),
            **{topic: self._topic_status(topic, period) for topic in self._topics}}

    def _topic_status(self, topic: str, period: float) -> DiagnosticStatus:
        subscriber, sources = self._subscriber, self._subscriber.sources(topic)
        for source in sources:
            source.close_period(period)
        problems = '; '.join(dict.fromkeys(map(str, subscriber.problems(topic))))
        others = self.count_publishers(self._topics[topic].topic_name) - 1
        return first_case(
            {'publishers': len(subscriber.connections(topic)),
             'other publishers in ROS 2': others,
             **{f'{source.publisher} {key}': value for source in sources for key, value in (
                 ('rate [Hz]', f'{source.rate:.1f}'), ('received', source.received),
                 ('lost', source.lost), ('repeated', source.repeated),
                 ('clock offset [s]', f'{source.clock.offset_ns * 1e-9:.6f}'),
                 ('jitter of arrival [s]', f'{source.jitter:.6f}'),
                 ('clock steps', source.clock.steps))}},
            (subscriber.is_silent(topic), ERROR, problems or f'waiting for {topic}'),
            (problems, WARN, problems),
            (others > 0, WARN, f'{topic} has other publishers in ROS 2: joint states may arrive '
             'twice; check for a second bridge'),
            (True, OK, f'receiving joint states on {topic}'))

    def _publisher(self, topic: str) -> Any:
        with suppress(InvalidTopicNameException):
            if topic.startswith('/'):
                return self.create_publisher(JointState, topic, topics.PUBLISHER_QOS)
        raise ArgumentError('topics', f'expected full topic names such as {topics.JOINT_STATES}, '
                            f'got {topic!r}')


main = partial(run, JointStateBridge, 'joint_state_bridge')

if __name__ == '__main__':
    sys.exit(main())
