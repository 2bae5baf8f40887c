"""The speed table has a row for each call and import of each engine, checked to agree."""

from pathlib import Path
import subprocess
import sys

import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / 'benchmarks' / 'model.py'


def test_the_table_has_all_engines():
    for name in ('pinocchio', 'mujoco', 'baxter_dynamics_ros.model._compiled'):
        pytest.importorskip(name, reason=f'compared with {name}')
    ended = subprocess.run([sys.executable, BENCHMARK, '--quick'], capture_output=True, text=True,
                           timeout=100)
    assert ended.returncode == 0, ended.stderr + ended.stdout
    rows = [line.split('|') for line in ended.stdout.splitlines() if line.startswith('|')][2:]
    assert len(rows) == 4 + 3 + 4 + 4 + 5 and min(float(row[3]) for row in rows) > 0.0
