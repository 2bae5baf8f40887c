"""The generated module is what the generator writes, and runs without it."""

import subprocess
import sys

from baxter_dynamics_ros.core import _closed_form
import pytest


def test_regenerated_text_is_the_same():
    pytest.importorskip('casadi', reason='needed to generate: pip install casadi')
    from baxter_dynamics_ros.closed_form.module import module_text
    with open(_closed_form.__file__, encoding='utf-8') as file:
        assert file.read() == module_text(), (
            'core/_closed_form.py is out of date: run python -m baxter_dynamics_ros.closed_form')


def test_command_writes_the_whole_module(tmp_path):
    pytest.importorskip('casadi', reason='needed to generate: pip install casadi')
    from baxter_dynamics_ros.closed_form.module import module_text
    from baxter_dynamics_ros.closed_form.module import write_module
    path = tmp_path / 'module.py'
    path.write_text('old')
    write_module(path)
    assert path.read_text() == module_text()
    assert list(tmp_path.iterdir()) == [path]


def test_command_prints_sizes():
    pytest.importorskip('casadi', reason='needed to count: pip install casadi')
    answer = subprocess.run([sys.executable, '-m', 'baxter_dynamics_ros.closed_form', 'sizes'],
                            capture_output=True, text=True, timeout=120, check=True)
    assert answer.stdout.startswith('| form |')


def test_head_says_how_it_is_generated():
    assert 'python -m baxter_dynamics_ros.closed_form' in _closed_form.__doc__
