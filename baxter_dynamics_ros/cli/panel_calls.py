"""Calls of a predictor's services and of its calibration, without waiting for their answers."""

from collections.abc import Callable
from typing import Any

from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

try:
    from baxter_dynamics_interfaces.action import Calibrate
except ImportError:
    Calibrate = None

DURATION = 60.0  # of the calibration's motion [s]

Report = Callable[[str, float | None], None]  # a text, and the progress from 0 to 1


class Calls:
    """One call at a time; ``report`` receives progress and the answer."""

    def __init__(self, report: Report) -> None:
        self._is_busy = False
        self._report = report
        self._node = Node('panel_calls', enable_rosout=False, start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._clients: dict[str, Any] = {}
        self._predictor = ''
        self._goal: Any = None  # of the calibration

    def offer(self, predictor: str) -> list[str]:
        """Return the verbs that a predictor offers now; only to cancel while it calibrates."""
        if predictor != self._predictor:
            self._predictor = predictor
            self._clients = {verb: self._node.create_client(Trigger, f'{predictor}/{verb}')
                             for verb in ('zero', 'reset')}
            if Calibrate is not None:
                self._clients['calibrate'] = ActionClient(self._node, Calibrate,
                                                          f'{predictor}/calibrate')
        if self._goal is not None:
            return ['cancel']
        return [verb for verb in ('zero', 'calibrate', 'reset') if verb in self._clients and (
            self._clients[verb].server_is_ready() if verb == 'calibrate'
            else self._clients[verb].service_is_ready())]

    def start(self, verb: str) -> None:
        """Start a call, unless another one has no answer yet."""
        if verb == 'cancel' and self._goal is not None:
            self._goal.cancel_goal_async()
        elif not self._is_busy:
            self._is_busy = True
            if verb == 'calibrate':
                self._report('', 0.0)
                self._clients[verb].send_goal_async(
                    Calibrate.Goal(duration=DURATION), self._on_feedback
                ).add_done_callback(self._on_goal)
            else:
                self._report(f'{verb} …', None)
                self._clients[verb].call_async(Trigger.Request()).add_done_callback(
                    lambda future: self._end(future.result().message))

    def poll(self) -> None:
        """Process what has arrived."""
        for _ in range(20 if self._is_busy else 0):
            self._executor.spin_once(timeout_sec=0.0)

    def _on_goal(self, future: Any) -> None:
        goal = future.result()
        if goal.accepted:
            self._goal = goal
            goal.get_result_async().add_done_callback(
                lambda result: self._end(result.result().result.message))
        else:
            self._end('the predictor refuses to calibrate now')

    def _on_feedback(self, message: Any) -> None:
        feedback = message.feedback
        seen = ', '.join(f'{joint.rpartition("_")[2]} {100.0 * part:.0f} %'
                         for joint, part in zip(feedback.joint_names, feedback.seen))
        self._report(f'{feedback.advice}\nSeen: {seen}', min(feedback.elapsed / DURATION, 1.0))

    def _end(self, message: str) -> None:
        self._is_busy, self._goal = False, None
        self._report(message or 'done', None)
