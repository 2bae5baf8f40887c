"""The demo beside a fake Baxter and a predictor."""

import os

import pytest

pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
pytest.importorskip('matplotlib', reason='needs pip install ".[demo]"')
pytest.importorskip('rich', reason='needs pip install ".[demo]"')


def test_shows_the_comparison_the_services_and_a_picture(domain, command, tmp_path, monkeypatch):
    pytest.importorskip('baxter_dynamics_interfaces.srv', reason='needs the service types')
    picture = tmp_path / 'demo.png'
    monkeypatch.setenv('COLUMNS', '100')
    code, out, err = command('demo', '--duration', '3', '--output', picture, '--arm', 'left')
    assert code == 0, err
    assert picture.read_bytes()[:8] == b'\x89PNG\r\n\x1a\n'
    assert picture.stat().st_size > 50_000
    assert f'figure: {picture}' in out
    rows = {words[0]: words[1:] for words in map(str.split, out.splitlines()) if words}
    measured, predicted, residual, difference = map(float, rows['s1'])
    assert residual < 1.0 < difference < measured
    assert abs(measured - predicted) < 1.0
    assert all(len(rows[field]) == 7 for field in ('torque', 'inertial', 'actuator_effort'))


def test_says_why_when_no_prediction_arrives(domain, command, tmp_path, monkeypatch):
    hidden = tmp_path / 'mujoco'
    hidden.mkdir()
    (hidden / '__init__.py').write_text('raise ImportError("no MuJoCo here")\n')
    monkeypatch.setenv('PYTHONPATH', str(tmp_path), os.pathsep)
    code, _, err = command('demo', '--duration', '2', '--output', tmp_path / 'demo.png')
    assert code == 1
    assert 'fake_baxter ended with exit code 1' in err and 'pip install mujoco' in err
    assert 'Traceback' not in err
