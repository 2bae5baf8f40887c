"""The demo, run as a user runs it."""

import os
import subprocess
import sys

import pytest

pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
pytest.importorskip('matplotlib', reason='needs pip install ".[demo]"')
pytest.importorskip('rich', reason='needs pip install ".[demo]"')


def demo(*arguments, **environment):
    """Run the demo's command."""
    return subprocess.run(
        [sys.executable, '-m', 'baxter_dynamics_ros.cli.main', 'demo', *arguments],
        capture_output=True, text=True, timeout=100, env={**os.environ, **environment})


def test_shows_the_comparison_the_services_and_a_picture(domain, tmp_path):
    pytest.importorskip('baxter_dynamics_interfaces.srv', reason='needs the service types')
    picture = tmp_path / 'demo.png'
    result = demo('--duration', '3', '--output', str(picture), '--arm', 'left', COLUMNS='100')
    assert result.returncode == 0, result.stderr
    assert picture.read_bytes()[:8] == b'\x89PNG\r\n\x1a\n'
    assert picture.stat().st_size > 50_000
    assert f'figure: {picture}' in result.stdout
    rows = {words[0]: words[1:] for words in map(str.split, result.stdout.splitlines()) if words}
    measured, predicted, residual, difference = map(float, rows['s1'])
    assert residual < 1.0 < difference < measured
    assert abs(measured - predicted) < 1.0
    assert all(len(rows[field]) == 7 for field in ('torque', 'inertial', 'actuator_effort'))


def test_says_why_when_no_prediction_arrives(domain, tmp_path):
    hidden = tmp_path / 'mujoco'
    hidden.mkdir()
    (hidden / '__init__.py').write_text('raise ImportError("no MuJoCo here")\n')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    result = demo('--duration', '2', '--output', str(tmp_path / 'demo.png'), PYTHONPATH=path)
    assert result.returncode == 1
    assert 'fake_baxter ended with exit code 1' in result.stderr
    assert 'pip install mujoco' in result.stderr
    assert 'Traceback' not in result.stderr


def test_refuses_a_figure_that_it_cannot_save_before_it_starts(refused):
    assert refused('demo', '--output', '/nowhere/demo.png') == '--output: /nowhere is not a folder'
