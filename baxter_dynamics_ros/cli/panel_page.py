"""The page of the panel: 3D view, sentences, buttons and charts, shared by all viewers."""

import argparse
import asyncio
from collections import deque
import errno
from html import escape
import math
from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
import rich
from std_srvs.srv import Trigger
import viser

from .listener import Listener
from .monitor import Monitor, MonitoredPredictor
from .panel_views import Charts, force_of, Scene
from .terminal import say
from ..model import BaxterDynamicsError, JOINTS
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
    rich.get_console().quiet = True  # viser prints a banner
    server = viser.ViserServer(
        args.host, _free_port(args.host, args.port), 'baxter_dynamics', verbose=False)
    host = f'[{args.host}]' if ':' in args.host else args.host
    say(f'panel: http://{host}:{server.get_port()}')
    try:
        page = Page(server, listener.node)
        for k, now in enumerate(monitor.ticks(_PERIOD, math.inf)):
            page.update(monitor, now, is_slow=k % _SLOWER == 0)
    finally:
        server.stop()


def _free_port(host: str, first: int) -> int:
    """Return the first free port of an address, without which the server would wait forever."""
    async def listen(port: int) -> None:
        (await asyncio.start_server(lambda *streams: None, [host], port)).close()

    for port in range(first, 2 ** 16):
        try:
            asyncio.run(listen(port))
            return port
        except (OSError, UnicodeError) as error:
            reason = error
            if getattr(error, 'errno', None) not in (errno.EADDRINUSE, errno.EACCES):
                break
    raise BaxterDynamicsError(f'cannot listen on address {host!r}, port {port}: {reason}')


class Page:
    """Content of the page."""

    def __init__(self, server: viser.ViserServer, node: Node) -> None:
        self._server = server
        gui = server.gui
        gui.configure_theme(control_layout='floating', control_width='large', show_logo=False,
                            show_share_button=False, brand_color=(31, 119, 201))
        self._summary = gui.add_html('')
        self._buttons = Buttons(gui, node)
        self._charts = Charts(gui)
        with self._charts.tabs.add_tab('Diagnostics'):
            self._diagnostics = gui.add_html('')
        self._scene = Scene(server)

    def update(self, monitor: Monitor, now: float, is_slow: bool) -> None:
        """Show the state at monotonic time now [s]; sentences and charts only if ``is_slow``."""
        shown = monitor.shown(now)
        with self._server.atomic():
            if shown:
                self._update_scene(shown[0], now)
                self._charts.add(now, shown[0].name, shown[0].efforts(now))
                self._buttons.update(shown[0].name)
            if is_slow and self._server.get_clients():
                problem = monitor.problem(now)
                self._summary.content = (_paragraph(problem, _LEVELS[1]) if problem else
                                         _summary(*shown, now=now))
                if shown:
                    self._charts.update(now)
                    self._diagnostics.content = _diagnostics(shown[0], now)

    def _update_scene(self, predictor: MonitoredPredictor, now: float) -> None:
        self._scene.touch({f'{predictor.side}_{joint}' for joint in predictor.contact_joints(now)})
        state = predictor.newest(topics.JOINT_STATES, now)
        positions = dict(zip(state.name, state.position)) if state else {}
        self._scene.move(positions)
        q = [positions.get(f'{predictor.side}_{joint}', math.nan) for joint in JOINTS]
        if np.isfinite(q).all():
            self._scene.push(predictor.side, np.array(q),
                             predictor.newest(topics.EXTERNAL_WRENCH, now))


class Buttons:
    """Buttons for a predictor's services and its calibration, one call at a time."""

    def __init__(self, gui: viser.GuiApi, node: Node) -> None:
        self._node, self._executor = node, SingleThreadedExecutor()
        self._executor.add_node(node)
        self._pressed: deque[str] = deque()  # from the threads of the server
        self._group = gui.add_button_group('', ('Reset',), visible=False)
        self._group.on_click(lambda _: self._pressed.append(self._group.value))
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._answer = gui.add_html('')
        self._predictor = ''
        self._clients: dict[str, Any] = {}  # of the predictor, by button
        self._call: Any = None  # task of the call in progress
        self._goal: Any = None  # of the calibration

    def update(self, predictor: str) -> None:
        """Show the services on offer, start the one that was pressed, process the answers."""
        is_other = predictor != self._predictor
        if is_other:
            self._predictor, self._clients = predictor, self._clients_of(predictor)
        ready = tuple(verb for verb, client in self._clients.items() if (
            client.server_is_ready if verb == 'Calibrate' else client.service_is_ready)())
        if self._call is not None and (is_other or not ready):
            self._call.cancel()
            self._call = self._goal = None
            self._report('no answer: the predictor ended or is no longer shown')
        offered = ready if self._goal is None else ('Cancel',)
        self._group.visible = bool(offered)
        if offered and offered != self._group.options:
            self._group.options = offered
        if self._pressed and (verb := self._pressed.popleft()) in offered:
            self._start(verb)
        for _ in range(20 if self._call is not None else 0):
            self._executor.spin_once(timeout_sec=0.0)

    def _clients_of(self, predictor: str) -> dict[str, Any]:
        create = self._node.create_client
        clients: dict[str, Any] = {'Zero': create(Trigger, f'{predictor}/{topics.ZERO}')}
        if Calibrate is not None:
            clients['Calibrate'] = ActionClient(
                self._node, Calibrate, f'{predictor}/{topics.CALIBRATE}')
        return {**clients, 'Reset': create(Trigger, f'{predictor}/{topics.RESET}')}

    def _start(self, verb: str) -> None:
        if verb == 'Cancel':
            self._goal.cancel_goal_async()
        elif self._call is None:
            self._call = self._executor.create_task(self._run, verb)

    async def _run(self, verb: str) -> None:
        if verb == 'Calibrate':
            text = await self._calibrate()
        else:
            self._report(f'{verb} …')
            text = (await self._clients[verb].call_async(Trigger.Request())).message
        self._call = self._goal = None
        self._report(text or 'done')

    async def _calibrate(self) -> str:
        self._report('', 0.0)
        goal = await self._clients['Calibrate'].send_goal_async(
            Calibrate.Goal(duration=_CALIBRATION), self._on_feedback)
        if not goal.accepted:
            return 'the predictor refuses to calibrate now'
        self._goal = goal
        return str((await goal.get_result_async()).result.message)

    def _on_feedback(self, message: Any) -> None:
        feedback = message.feedback
        seen = ', '.join(f'{joint.rpartition("_")[2]} {round(100.0 * part)} %'
                         for joint, part in zip(feedback.joint_names, feedback.seen))
        self._report(f'{feedback.advice}\nSeen: {seen}', min(feedback.elapsed / _CALIBRATION, 1.0))

    def _report(self, text: str, progress: float | None = None) -> None:
        """Show an answer, and progress from 0 to 1."""
        self._bar.visible = progress is not None
        self._bar.value = 100.0 * (progress or 0.0)  # type: ignore[misc]
        self._answer.content = _paragraph(text)


def _summary(predictor: MonitoredPredictor, *others: MonitoredPredictor, now: float) -> str:
    """Return sentences on contact, force, residual and rates, as HTML; others are named only."""
    contact, in_contact = predictor.contact(now), predictor.in_contact(now)
    wrench = predictor.newest(topics.EXTERNAL_WRENCH, now)
    if in_contact and wrench is not None:
        contact += f', {np.linalg.norm(force_of(wrench)):.0f} N at the hand'
    sentences = predictor.residual(now), predictor.explanation(now), predictor.rates(now)
    return (_paragraph(''.join(f' (--node {each.name} shows the other)' for each in others),
                       title=f'{predictor.side.capitalize()} arm')
            + _paragraph(contact, _LEVELS[2] if in_contact else '')
            + ''.join(map(_paragraph, filter(None, sentences))))


def _diagnostics(predictor: MonitoredPredictor, now: float) -> str:
    return ''.join(_paragraph(text, _LEVELS[level], f'{name} ')
                   for name, level, text in predictor.diagnostics(now)
                   ) or _paragraph('no diagnostics', _LEVELS[3])


def _paragraph(text: str, color: str = '', title: str = '') -> str:
    """Return a sentence as HTML, behind a mark in a color and a title."""
    mark = f'<span style="color:{color};padding-right:6px">●</span>' if color else ''
    text = escape(text[:1].upper() + text[1:]).replace('\n', '<br>')
    return ('<div style="padding:3px 12px;font-size:13px;line-height:1.45">'
            f'{mark}<b>{escape(title)}</b>{text}</div>')
