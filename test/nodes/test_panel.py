"""The panel: its scales, the arrow of a force, and the page in a real browser."""

from contextlib import suppress
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from unittest.mock import MagicMock

from baxter_dynamics_ros.model import BaxterArm, joint_names, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
import numpy as np
import pytest
import rclpy
from std_msgs.msg import Header
from std_srvs.srv import Trigger

Q = np.array([0.3, -0.6, 0.1, 1.4, 0.2, 0.8, 0.4])  # [rad]
FORCE = np.array([0.0, 4.0, -18.0])  # axes of the base [N]
# A triangle for each mesh, because reading them takes seconds.
SIMPLE = """
import sys
import numpy as np
from baxter_dynamics_ros.cli import main, panel_views
panel_views._load = lambda file: [(0.1 * np.eye(3), np.array([[0, 1, 2]]), (90, 90, 90))]
sys.exit(main.main(sys.argv[1:]))
"""
# Software rendering takes most of a core, so few frames are prepared, and nothing is drawn.
WITHOUT_DRAWING = """
requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 200);
for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced'])
    WebGL2RenderingContext.prototype[name] = () => {};
"""


@pytest.fixture(scope='module', autouse=True)
def panel_views():
    """Return the module, which takes seconds to import: not while tests are collected."""
    for module, extra in (('yourdfpy', 'panel'), ('viser', 'panel'), ('mujoco', 'demo')):
        pytest.importorskip(module, reason=f'needs pip install ".[{extra}]"')
    from baxter_dynamics_ros.cli import panel_views
    return panel_views


def test_scales_hold_all_values_and_change_rarely(rng, panel_views):
    values = np.cumsum(rng.normal(0.0, 0.1, 3000))  # a random walk, 10 values a second
    limits, changes = (0.0, 0.0), 0
    for end in range(2, len(values)):
        window = values[max(0, end - 300):end]
        before, limits = limits, panel_views.steady_range(limits, window.min(), window.max())
        assert limits[0] <= window.min() and window.max() <= limits[1]
        assert np.ptp(limits) < 5.0 * max(np.ptp(window), 0.2)
        changes += limits != before
    assert changes < 60


def test_charts_forget_other_predictors_and_what_is_older_than_30_s(panel_views):
    charts = panel_views.Charts(MagicMock())
    for now, name in (5.0, '/right/p'), (105.0, '/right/p'), (106.0, '/left/p'):
        charts.add(now, name, np.zeros((4, 7)))
        assert [row[:2] for row in charts.rows] == [(now, name)]


def test_draws_the_force_at_the_hand_and_colours_joints_in_contact(monkeypatch, panel_views):
    load, shapes = panel_views._load, {}

    def load_wrist(file):  # the others take seconds
        shapes[file.name] = load(file) if file.name == 'W2.DAE' else [
            (np.eye(3), np.array([[0, 1, 2]]), (90, 90, 90))]
        return shapes[file.name]
    monkeypatch.setattr(panel_views, '_load', load_wrist)
    server = panel_views.viser.ViserServer('localhost', 8500, verbose=False)
    scene = panel_views.Scene(server)
    assert {'E1.DAE', 'PEDESTAL.DAE', 'H0.DAE'} < shapes.keys()
    (vertices, faces, _), *_ = shapes['W2.DAE']
    assert 100 < len(faces) < 10_000 and 0.05 < np.ptp(vertices, axis=0).max() < 0.3  # [m]
    scene.move(dict(zip(joint_names('right'), Q)))
    hand = BaxterArm(mount=mount('right')).forward_kinematics(Q)
    for frame, force in (('base', FORCE), ('right_hand', hand[:3, :3].T @ FORCE)):
        scene.push('right', Q, WrenchStamped(header=Header(frame_id=frame), wrench=Wrench(
            force=Vector3(**dict(zip('xyz', force))))))
        start, end = scene._arrow.points[0]
        np.testing.assert_allclose(start, hand[:3, 3], atol=1e-6)
        np.testing.assert_allclose((end - start) / np.linalg.norm(end - start),
                                   FORCE / np.linalg.norm(FORCE), atol=1e-6)
        assert scene._arrow.visible and scene._label.text == '18 N'
    scene.push('right', Q, None)
    assert not scene._arrow.visible
    (mesh, plain), = scene._meshes['right_s1']
    scene.touch({'right_s1'})
    assert tuple(mesh.color) != plain
    scene.touch(set())
    assert tuple(mesh.color) == plain
    server.stop()


def test_draws_capsules_along_the_links_without_meshes(monkeypatch, panel_views):
    monkeypatch.setattr(panel_views, '_IN_WHEEL', 'missing')
    server = panel_views.viser.ViserServer('localhost', 8500, verbose=False)
    scene = panel_views.Scene(server)
    scene.move(dict(zip(joint_names('left'), Q)))
    arm, pose = BaxterArm(mount=mount('left')), np.eye(4)
    for i, name in enumerate(joint_names('left'), 1):
        frame, _ = scene._joints[name]
        pose = pose @ panel_views.viser.transforms.SE3(
            np.array([*frame.wxyz, *frame.position])).as_matrix()
        (mesh, _), = scene._meshes[name]
        points = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        end = (arm.mount @ transform(arm.parameters, 0, i, Q))[:3, 3]
        for center in pose[:3, 3], end:  # of the half spheres
            distances = np.linalg.norm(points - center, axis=1)
            assert np.isclose(distances, 0.05, atol=1e-6).sum() > 100 and distances.min() > 0.049
    np.testing.assert_allclose(end, arm.forward_kinematics(Q)[:3, 3], atol=1e-12)
    server.stop()


def test_refuses_an_address_of_no_machine(domain, command):
    code, out, err = command('panel', '--host', '300.1.1.1')
    assert (code, out, err.count('\n')) == (1, '', 1)
    assert "cannot listen on address '300.1.1.1', port 8080: " in err


def test_ctrl_c_while_libraries_load_ends_the_panel(domain, command, monkeypatch):
    class Loading:

        @property
        def serve(self):
            with suppress(BaseException):  # as trimesh does while it loads
                signal.raise_signal(signal.SIGINT)
            return lambda listener, args: listener.wait(lambda: False, 5.0)
    monkeypatch.setitem(sys.modules, 'baxter_dynamics_ros.cli.panel_page', Loading())
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs ignore it
    try:
        assert command('panel') == (130, '', '')
    finally:
        signal.signal(signal.SIGINT, before)


def test_buttons_return_when_the_predictor_ends_during_a_call(domain):
    from baxter_dynamics_ros.cli.listener import Listener
    from baxter_dynamics_ros.cli.panel_page import Buttons
    with Listener('panel') as listener:
        predictor = rclpy.create_node('predictor')  # does not answer
        predictor.create_service(Trigger, 'predictor/zero', lambda request, answer: answer)
        buttons = Buttons(MagicMock(), listener.node)

        def updated(condition):
            return listener.wait(lambda: buttons.update('/predictor') or condition(), 30.0)
        for end in (lambda: buttons.update('/other')), predictor.destroy_node:
            assert updated(lambda: buttons._group.options == ('Zero',) and buttons._group.visible)
            buttons._pressed.append('Zero')
            assert updated(lambda: 'Zero …' in buttons._answer.content)
            end()
            assert updated(lambda: 'No answer' in buttons._answer.content)
        assert buttons._call is None and not buttons._group.visible


@pytest.mark.timeout(300)  # two pages and three nodes on a busy machine
def test_page_shows_a_push_and_its_buttons_act(domain, start):
    playwright = pytest.importorskip('playwright.sync_api', reason='needs Playwright')
    browser = shutil.which('chromium') or shutil.which('google-chrome')
    if browser is None:
        pytest.skip('needs Chromium')
    start('fake_baxter', '-p', 'trajectory:=hold', '-p', f'force:={FORCE.tolist()}')
    start('torque_predictor')
    panel = subprocess.Popen([sys.executable, '-c', SIMPLE, 'panel', '--port', '8600'],
                             stdout=subprocess.PIPE, text=True, env=dict(os.environ))
    try:
        url = panel.stdout.readline().removeprefix('panel: ').strip()
        assert url.startswith('http://localhost:')
        with playwright.sync_playwright() as driver:
            window = driver.chromium.launch(executable_path=browser)
            page, other = pages = [window.new_page(viewport={'width': 640, 'height': 400},
                                                   device_scale_factor=0.1) for _ in range(2)]
            for each in pages:
                each.set_default_timeout(120_000)
                each.add_init_script(WITHOUT_DRAWING)
                each.goto(url)
            for each in pages:
                each.get_by_text('N at the hand').wait_for()
            other.close()

            def press(button, answer):
                # A click would wait for two frames without motion.
                page.get_by_text(button, exact=True).dispatch_event('click')
                page.get_by_text(answer).first.wait_for()

            press('Calibrate', 'Seen: s0 0 %')
            press('Cancel', 'Nothing was changed')
            press('Reset', 'Filter and contact detector are reset')
            limit = time.monotonic() + 120.0
            while not page.get_by_text('Added to effort_model.bias').count():
                assert time.monotonic() < limit, 'the residual was never zeroed'
                press('Zero', re.compile('Zero …|Added|Nothing was changed'))
                page.wait_for_timeout(4000.0)  # a busy machine interrupts the residual
            chart = page.locator('.u-wrap canvas').first
            before, limit = chart.evaluate('each => each.toDataURL()'), time.monotonic() + 40.0
            while chart.evaluate('each => each.toDataURL()') == before:
                assert time.monotonic() < limit, 'the charts stand still'
            window.close()
        panel.send_signal(signal.SIGINT)
        assert panel.wait(60.0) == 130
    finally:
        panel.kill()
        panel.communicate()
