"""The page of the panel: 3D view, sentences, buttons and charts, shared by all viewers."""

import argparse
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from html import escape
import io
import math
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
import viser

from .listener import Listener
from .monitor import Monitor, Predictor
from .panel_views import Charts, force_of, Scene
from .terminal import say
from ..model.effort import BAND
from ..model.joints import JOINTS
from ..nodes import topics

try:
    from baxter_dynamics_interfaces.action import Calibrate
except ImportError:
    Calibrate = None

_PERIOD = 0.067  # of the 3D view [s]
_SLOWER = 5  # of the page's other parts, in such periods
_LEVELS = ('#2f9e5b', '#d9910a', '#d1402b', '#8a949e')  # OK, WARN, ERROR, STALE
_CALIBRATION = 60.0  # duration of its motion [s]


def serve(listener: Listener, args: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C."""
    monitor = Monitor(listener, args.node, args.topic, args.arm)
    with redirect_stdout(io.StringIO()):  # its banner
        server = viser.ViserServer(args.host, args.port, 'baxter_dynamics', verbose=False)
    host = f'[{args.host}]' if ':' in args.host else args.host
    say(f'panel: http://{host}:{server.get_port()}')
    try:
        page = Page(server)
        for k, now in enumerate(monitor.ticks(_PERIOD, math.inf)):
            page.update(monitor, now, is_slow=k % _SLOWER == 0)
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


class Page:
    """Content of the page."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        gui = server.gui
        gui.configure_theme(control_layout='floating', control_width='large', show_logo=False,
                            show_share_button=False, brand_color=(31, 119, 201))
        self._summary = gui.add_html('')
        self._pressed: SimpleQueue[str] = SimpleQueue()  # from the threads of the server
        self._buttons = gui.add_button_group('', ('Reset',), visible=False)
        self._buttons.on_click(lambda _: self._pressed.put(self._buttons.value))
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._answer = gui.add_html('')
        self._charts = Charts(gui)
        with self._charts.tabs.add_tab('Diagnostics'):
            self._diagnostics = gui.add_html('')
        self._scene = Scene(server)
        self._calls = Calls(self._report)

    def update(self, monitor: Monitor, now: float, is_slow: bool) -> None:
        """Show the state at monotonic time now [s]; sentences and charts only if ``is_slow``."""
        shown = monitor.shown(now)
        with self._server.atomic():
            if shown:
                self._update_scene(shown[0], now)
                self._charts.add(shown[0].efforts(now), now)
                self._call(shown[0])
            if is_slow and self._server.get_clients():
                problem = monitor.problem(now)
                self._summary.content = (_paragraph(escape(problem), _LEVELS[1]) if problem else
                                         _summary(shown[0], now))
                if shown:
                    self._charts.show(now)
                    self._diagnostics.content = _diagnostics(shown[0], now)

    def _update_scene(self, predictor: Predictor, now: float) -> None:
        self._scene.touch({f'{predictor.side}_{joint}' for joint in predictor.contact_joints(now)})
        state = predictor.newest(topics.JOINT_STATES, now)
        positions = dict(zip(state.name, state.position)) if state else {}
        self._scene.move(positions)
        q = [positions.get(f'{predictor.side}_{joint}', math.nan) for joint in JOINTS]
        if np.isfinite(q).all():
            self._scene.push(predictor.side, np.array(q),
                             predictor.newest(topics.EXTERNAL_WRENCH, now))

    def _call(self, predictor: Predictor) -> None:
        offered = self._calls.offer(predictor.name)
        self._buttons.visible = bool(offered)
        if offered and offered != self._buttons.options:
            self._buttons.options = offered
        with suppress(Empty):
            self._calls.start(self._pressed.get_nowait())
        self._calls.poll()

    def _report(self, text: str, progress: float | None) -> None:
        self._bar.visible = progress is not None
        self._bar.value = 100.0 * (progress or 0.0)  # type: ignore[misc]
        self._answer.content = _paragraph(escape(_sentence(text)).replace('\n', '<br>'))


class Calls:
    """Calls of a predictor's services and its calibration, one at a time, without waiting."""

    def __init__(self, report: Callable[[str, float | None], None]) -> None:
        self._report = report  # of a text, and progress from 0 to 1
        self._node = Node('panel_calls', enable_rosout=False, start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._clients: dict[str, Any] = {}
        self._predictor = ''
        self._call: Any = None  # the task of the last one
        self._goal: Any = None  # of the calibration

    def offer(self, predictor: str) -> tuple[str, ...]:
        """Return what a predictor offers now; only to cancel while it calibrates."""
        if predictor != self._predictor:
            self._predictor, create = predictor, self._node.create_client
            self._clients = {'Zero': create(Trigger, f'{predictor}/{topics.ZERO}')}
            if Calibrate is not None:
                self._clients['Calibrate'] = ActionClient(
                    self._node, Calibrate, f'{predictor}/{topics.CALIBRATE}')
            self._clients['Reset'] = create(Trigger, f'{predictor}/{topics.RESET}')
        if self._goal is not None:
            return ('Cancel',)
        return tuple(verb for verb, client in self._clients.items() if (
            client.server_is_ready if verb == 'Calibrate' else client.service_is_ready)())

    def start(self, verb: str) -> None:
        """Start a call, unless another one has no answer yet."""
        if verb == 'Cancel' and self._goal is not None:
            self._goal.cancel_goal_async()
        elif verb in self._clients and (self._call is None or self._call.done()):
            self._call = self._executor.create_task(
                self._calibrate if verb == 'Calibrate' else self._trigger, verb)

    def poll(self) -> None:
        """Process what has arrived."""
        if self._call is not None and not self._call.done():
            for _ in range(20):
                self._executor.spin_once(timeout_sec=0.0)

    async def _trigger(self, verb: str) -> None:
        self._report(f'{verb} …', None)
        answer = await self._clients[verb].call_async(Trigger.Request())
        self._report(answer.message or 'done', None)

    async def _calibrate(self, verb: str) -> None:
        self._report('', 0.0)
        goal = await self._clients[verb].send_goal_async(
            Calibrate.Goal(duration=_CALIBRATION), self._on_feedback)
        if goal.accepted:
            self._goal = goal
            answer = await goal.get_result_async()
            self._goal = None
            self._report(answer.result.message or 'done', None)
        else:
            self._report('the predictor refuses to calibrate now', None)

    def _on_feedback(self, message: Any) -> None:
        feedback = message.feedback
        seen = ', '.join(f'{joint.rpartition("_")[2]} {100.0 * part:.0f} %'
                         for joint, part in zip(feedback.joint_names, feedback.seen))
        self._report(f'{feedback.advice}\nSeen: {seen}', min(feedback.elapsed / _CALIBRATION, 1.0))


def _summary(predictor: Predictor, now: float) -> str:
    """Return sentences on contact, force, residual and rates, as HTML."""
    delay = predictor.delay(now)
    states, residuals = (predictor.rate(topic, now)
                         for topic in (topics.JOINT_STATES, topics.EFFORT_RESIDUAL))
    sentences = [
        f'<b>{predictor.side.capitalize()} arm</b>', _contact(predictor, now),
        _residual(predictor, now), escape(_sentence(predictor.explanation(now))),
        f'{states:.0f} joint states and {residuals:.0f} residuals a second'
        + ('' if delay is None else f', {1e3 * delay:.0f} ms behind the robot')]
    return ''.join(map(_paragraph, filter(None, sentences)))


def _contact(predictor: Predictor, now: float) -> str:
    in_contact = predictor.in_contact(now)
    if not in_contact:
        return 'Contact is not known yet' if in_contact is None else 'No contact'
    joints = ', '.join(predictor.contact_joints(now))
    wrench = predictor.newest(topics.EXTERNAL_WRENCH, now)
    return (f'<b style="color:{_LEVELS[2]}">Contact</b> for '
            f'{now - predictor.contact_since:.1f} s' + (f' at {joints}' if joints else '')
            + (f', {np.linalg.norm(force_of(wrench)):.0f} N at the hand' if wrench else ''))


def _residual(predictor: Predictor, now: float) -> str:
    _, _, residual, deviation = predictor.efforts(now)
    if np.isnan(deviation).all():
        return ''
    beyond = [joint for joint, is_beyond in zip(JOINTS, np.abs(residual) > BAND * deviation)
              if is_beyond]
    return ('Residual beyond its expected range at ' + ', '.join(beyond) if beyond else
            'All residuals are within their expected range')


def _diagnostics(predictor: Predictor, now: float) -> str:
    """Return the diagnostics as HTML, one sentence per status."""
    return ''.join(_paragraph(f'<b>{escape(name)}</b> {escape(text)}', _LEVELS[level])
                   for name, level, text in predictor.diagnostics(now)
                   ) or _paragraph('no diagnostics', _LEVELS[3])


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _paragraph(html: str, color: str = '') -> str:
    mark = (f'<span style="color:{color};padding-right:6px">●</span>' if color else '')
    return f'<div style="padding:3px 12px;font-size:13px;line-height:1.45">{mark}{html}</div>'
