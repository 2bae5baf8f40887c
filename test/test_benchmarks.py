"""The speed table has a row for each call of each engine, checked to agree."""

import os
from pathlib import Path
import subprocess
import sys

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture
def run(tmp_path):
    """Return a function that runs the benchmark quickly: what it prints."""
    def run_(*without):
        for name in without:  # found first, and no such engine
            (tmp_path / f'{name}.py').write_text(f"raise ImportError('no {name}')\n")
        path = os.pathsep.join([str(tmp_path), str(REPOSITORY), os.environ.get('PYTHONPATH', '')])
        ended = subprocess.run(
            [sys.executable, str(REPOSITORY / 'benchmarks' / 'model.py'), '--quick'], cwd=tmp_path,
            env={**os.environ, 'PYTHONPATH': path}, capture_output=True, text=True, timeout=100)
        assert ended.returncode == 0, ended.stderr + ended.stdout
        return ended.stdout

    return run_


def rows(text):
    return {(cells[1].strip(), cells[2].strip()): float(cells[3]) for cells in
            (line.split('|') for line in text.splitlines()) if len(cells) > 4
            and cells[3].strip()[:1].isdigit()}


def test_the_table_has_all_engines(run):
    for name in ('pinocchio', 'mujoco'):
        pytest.importorskip(name, reason=f'compared with {name}')
    pytest.importorskip('baxter_dynamics_ros.model._compiled', reason='the extension is not built')
    text = run()
    assert 'differs' not in text and 'Import and first call beyond NumPy' in text
    times = rows(text)
    assert len(times) == 5 + 4 + 4 + 2
    assert all(time > 0.0 for time in times.values())


def test_it_runs_without_other_engines(run):
    text = run('pinocchio', 'mujoco')
    assert 'Pinocchio is not installed: no pinocchio' in text
    assert ('tau, one state', 'BaxterArm, python') in rows(text)
