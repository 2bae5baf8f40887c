"""The page of the panel: 3D view, sentences, buttons and charts, shared by all viewers."""

import argparse
from contextlib import redirect_stdout
from html import escape
import io
import math
from queue import Empty, SimpleQueue

import numpy as np
import viser

from .listener import Listener
from .monitor import Monitor, Predictor
from .panel_calls import Calls
from .panel_charts import Charts
from .panel_scene import Scene
from .terminal import say
from ..model.effort import BAND
from ..model.joints import joint_names, JOINTS

_PERIOD = 0.067  # of the 3D view [s]
_SLOWER = 5  # of the page's other parts, in such periods
_LEVELS = ('#2f9e5b', '#d9910a', '#d1402b', '#8a949e')  # OK, WARN, ERROR, STALE


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
        server.gui.configure_theme(control_layout='floating', control_width='large',
                                   show_logo=False, show_share_button=False,
                                   brand_color=(31, 119, 201))
        self._summary = server.gui.add_html('')
        self._pressed: SimpleQueue[str] = SimpleQueue()  # from the threads of the server
        self._buttons = server.gui.add_button_group('', ('Reset',), visible=False)
        self._buttons.on_click(lambda _: self._pressed.put(self._buttons.value.lower()))
        self._bar = server.gui.add_progress_bar(0.0, visible=False)
        self._answer = server.gui.add_html('')
        self._charts = Charts(server.gui)
        with self._charts.tabs.add_tab('Diagnostics'):
            self._diagnostics = server.gui.add_html('')
        self._scene = Scene(server)
        self._calls = Calls(self._report)

    def update(self, monitor: Monitor, now: float, is_slow: bool) -> None:
        """Show the state at monotonic time now [s]; sentences and charts only if ``is_slow``."""
        shown = monitor.shown(now)
        with self._server.atomic():
            if shown:
                self._update_scene(shown[0], now)
                self._charts.add(shown[0].instant(now), now)
                self._call(shown[0])
            if is_slow and self._server.get_clients():
                self._summary.content = summary(monitor.problem(now), shown, now)
                if shown:
                    self._charts.show(now)
                    self._diagnostics.content = diagnostics(shown[0], now)

    def _update_scene(self, predictor: Predictor, now: float) -> None:
        newest, wrench = predictor.joint_states.newest(now), predictor.wrench.newest(now)
        positions = dict(zip(newest[1].name, newest[1].position)) if newest else {}
        self._scene.move(positions)
        self._scene.touch({f'{predictor.side}_{joint}' for joint in predictor.contact_joints(now)})
        names = joint_names(predictor.side) if predictor.side else ('',)
        if positions.keys() >= set(names):
            q = np.array([positions[name] for name in names])
            force, frame = wrench[1] if wrench else (None, '')
            self._scene.push(predictor.side, q, force, frame.endswith('_hand'))

    def _call(self, predictor: Predictor) -> None:
        offered = tuple(verb.capitalize() for verb in self._calls.offer(predictor.name))
        self._buttons.visible = bool(offered)
        if offered and offered != self._buttons.options:
            self._buttons.options = offered
        try:
            self._calls.start(self._pressed.get_nowait())
        except Empty:
            pass
        self._calls.poll()

    def _report(self, text: str, progress: float | None) -> None:
        self._bar.visible = progress is not None
        self._bar.value = 100.0 * (progress or 0.0)  # type: ignore[misc]
        self._answer.content = _paragraph(escape(_sentence(text)).replace('\n', '<br>'))


def summary(problem: str | None, shown: list[Predictor], now: float) -> str:
    """Return sentences on what is missing, contact, force, residual and rates, as HTML."""
    if problem or not shown:
        return _paragraph(escape(problem or ''), _LEVELS[1])
    predictor = shown[0]
    delay = predictor.delay(now)
    sentences = [
        f'<b>{predictor.side.capitalize()} arm</b>', _contact(predictor, now),
        _residual(predictor, now), escape(_sentence(predictor.explanation(now))),
        f'{predictor.joint_states.rate(now):.0f} joint states and '
        f'{predictor.residual.rate(now):.0f} residuals a second'
        + ('' if delay is None else f', {1e3 * delay:.0f} ms behind the robot')]
    return ''.join(map(_paragraph, filter(None, sentences)))


def diagnostics(predictor: Predictor, now: float) -> str:
    """Return the diagnostics as HTML, one sentence per status."""
    return ''.join(_paragraph(
        f'<b>{escape(status.name)}</b> {escape(status.message)}',
        _LEVELS[min(status.level, len(_LEVELS) - 1)]) for status in predictor.diagnostics(now)
    ) or _paragraph('no diagnostics', _LEVELS[3])


def _contact(predictor: Predictor, now: float) -> str:
    in_contact, wrench = predictor.in_contact(now), predictor.wrench.newest(now)
    if in_contact is None:
        return 'Contact is not known yet'
    if not in_contact:
        return 'No contact'
    joints = ', '.join(predictor.contact_joints(now))
    force = f', {np.linalg.norm(wrench[1][0]):.0f} N at the hand' if wrench else ''
    return (f'<b style="color:{_LEVELS[2]}">Contact</b> for '
            f'{predictor.contact_duration(now):.1f} s' + (f' at {joints}' if joints else '')
            + force)


def _residual(predictor: Predictor, now: float) -> str:
    instant = predictor.instant(now)
    if np.isnan(instant.deviation).all():
        return ''
    beyond = [joint for joint, residual, deviation in zip(
        JOINTS, instant.residual, instant.deviation) if abs(residual) > BAND * deviation]
    return ('Residual beyond its expected range at ' + ', '.join(beyond) if beyond else
            'All residuals are within their expected range')


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _paragraph(html: str, color: str = '') -> str:
    mark = (f'<span style="color:{color};padding-right:6px">●</span>' if color else '')
    return f'<div style="padding:3px 12px;font-size:13px;line-height:1.45">{mark}{html}</div>'
