"""Fixtures of the export tests: exported files, states, and the model's results."""

import subprocess

from baxter_dynamics_ros.export import latex, matlab, sources
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
import numpy as np
import pytest

EXPORTS = {'c': sources.c_files, 'python': sources.python_files, 'matlab': matlab.files,
           'latex': latex.files}


@pytest.fixture
def export(tmp_path):
    """Return a function that writes an arm's files to tmp_path: their paths, by name."""
    def write(language, arm):
        paths = {}
        for name, text in EXPORTS[language](arm, 'baxter_dynamics export').items():
            paths[name] = tmp_path / name
            paths[name].parent.mkdir(exist_ok=True)
            paths[name].write_text(text, encoding='utf-8')
        return paths

    return write


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a program in tmp_path, which must succeed: its output."""
    def call(*arguments):
        done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, timeout=110)
        assert done.returncode == 0, done.stderr or done.stdout
        return done.stdout

    return call


@pytest.fixture
def states(random_states):
    """Return 50 states by name, q, qd, qdd and tau, each (50, 7)."""
    q, qd, qdd = random_states(50)
    return {'q': q, 'qd': qd, 'qdd': qdd, 'tau': 10.0 * qdd[::-1]}


@pytest.fixture
def check(arm, states):
    """Return a function that compares results with BaxterArm, which other engines confirm."""
    def compare(name, results):
        expected = getattr(arm, name)(*(states[vector] for vector in ('q', *FUNCTIONS[name][0])))
        expected = expected if isinstance(expected, tuple) else (expected,)
        for result, right in zip(results, expected, strict=True):
            if name == 'regressor':  # without columns of zeros
                result = result[..., :right.shape[-1]]
            np.testing.assert_allclose(result, right, rtol=1e-11, atol=1e-11)

    return compare
