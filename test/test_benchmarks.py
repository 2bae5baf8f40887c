"""The benchmark runs without the engines that are not installed, and times only what agrees."""

import json
import os
from pathlib import Path
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm
import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
BENCHMARKS = REPOSITORY / 'benchmarks'


@pytest.fixture
def run(tmp_path):
    """Return a function that runs the benchmark quickly: what it prints, and its JSON."""
    def run_(*arguments, without=()):
        for name in without:  # found first, and no such engine
            (tmp_path / f'{name}.py').write_text(f"raise ImportError('no {name}')\n")
        path = os.pathsep.join(
            [str(tmp_path), str(REPOSITORY), os.environ.get('PYTHONPATH', '')])
        ended = subprocess.run(
            [sys.executable, str(BENCHMARKS / 'model.py'), '--quick', '--json', 'all.json',
             *arguments], cwd=tmp_path, env={**os.environ, 'PYTHONPATH': path},
            capture_output=True, text=True, timeout=100)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout, json.loads((tmp_path / 'all.json').read_text())

    return run_


@pytest.fixture
def benchmark(monkeypatch):
    """Return the benchmark's modules engines.engine, speed.agreement and speed.comparison."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    from engines import engine
    from speed import agreement, comparison
    return engine, agreement, comparison


def test_the_table_has_all_engines_and_how_they_agree(run):
    pytest.importorskip('pinocchio', reason='what all is compared with: pip install pin')
    text, result = run()
    assert 'difference' in text
    rows = {(row['call'], row['engine']): row for row in result['rows']}
    for row in rows.values():
        assert row['note'].startswith('not installed') or row['difference'] <= 1e-9, row
    for call in ('tau', 'split', 'matrices', 'forward', 'batch'):
        assert rows[call, 'ours, NumPy']['ratio'] > 0.0
    assert rows['tau', 'Pinocchio']['ratio'] == 1.0
    assert rows['growth', 'ours, NumPy']['memory'] is not None
    assert {target['verdict'] for target in result['targets']} <= {
        'reached', 'NOT REACHED', 'not measured'}


def test_it_runs_without_any_other_engine(run):
    others = ('pinocchio', 'mujoco', 'pybullet', 'pydrake', 'roboticstoolbox', 'casadi', 'numba')
    text, result = run('--markdown', without=others)
    for name in others:
        assert f'not installed: no {name}' in text
    (row,) = [row for row in result['rows']
              if (row['call'], row['engine']) == ('tau', 'ours, NumPy')]
    assert row['seconds'] > 0.0
    assert row['ratio'] is None


@pytest.mark.parametrize('wrong', [1e-8, np.nan])
def test_what_does_not_agree_is_not_timed(benchmark, wrong):
    engine, agreement, comparison = benchmark
    arm = BaxterArm()
    disturbance = np.array([0.0, 0.0, wrong, 0.0, 0.0, 0.0, 0.0])
    tried = engine.Engine(
        name='tried', batch=arm.inverse_dynamics,
        tau=lambda q, qd, qdd: arm.inverse_dynamics(q, qd, qdd) + disturbance)
    agreeing, refused = comparison.sort_out([tried], agreement.Reference(arm, 2))
    assert list(agreeing) == [('batch', 'tried')]
    (row,) = refused
    assert (row.call, row.seconds) == ('tau', None)
    assert row.note.startswith('NOT TIMED')
