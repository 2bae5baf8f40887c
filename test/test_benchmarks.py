"""The speed table has a row for each call of each engine, checked to agree."""

from pathlib import Path
import subprocess
import sys

import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / 'benchmarks' / 'model.py'


def test_the_table_has_all_engines():
    for name in ('pinocchio', 'mujoco', 'baxter_dynamics_ros.model._compiled'):
        pytest.importorskip(name, reason=f'compared with {name}')
    ended = subprocess.run([sys.executable, BENCHMARK, '--quick'], cwd=BENCHMARK.parents[1],
                           capture_output=True, text=True, timeout=100)
    assert ended.returncode == 0, ended.stderr + ended.stdout
    assert 'differs' not in ended.stdout
    assert 'Import and first call beyond NumPy' in ended.stdout
    cells = [line.split('|') for line in ended.stdout.splitlines()]
    times = [float(row[3]) for row in cells if len(row) > 4 and row[3].strip()[:1].isdigit()]
    assert len(times) == 5 + 4 + 4 + 2
    assert min(times) > 0.0
