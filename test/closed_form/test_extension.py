"""The extension compiles without warnings and passes the sanitizers."""

import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig

from baxter_dynamics_ros.model import _closed_form
import pytest

SOURCE = _closed_form.__file__.replace('_closed_form.py', '_compiled.cpp')
STRICT = ('-std=c++17', '-O0', '-g0', '-Wall', '-Wextra', '-Werror', '-shared', '-fPIC',
          # At -O0 the other instruction sets would compile the same code again.
          '-fvisibility=hidden', '-DBAXTER_DYNAMICS_BASELINE_ONLY', '-fno-sanitize-recover=all',
          # Not all of undefined, which takes half as long again to compile.
          '-fsanitize=address,shift,signed-integer-overflow,bounds')
EXTREMES = """
import importlib.util, sys
import numpy as np
spec = importlib.util.spec_from_file_location('baxter_dynamics_ros.model._compiled', sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
import baxter_dynamics_ros.model
sys.modules[spec.name] = baxter_dynamics_ros.model._compiled = module
from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import closed_form as c
values = BaxterArm(engine='python').closed_form_parameters
rng = np.random.default_rng(0)
count = 0
for target in module.TARGETS:
    for name, (inputs, outputs) in c._closed_form.FUNCTIONS.items():
        k = 1 + len(inputs)
        f = module.function(name, ('q', *inputs), [output[1] for output in outputs], values,
                            c.finite_batches, target)
        for n in (0, 1, 15, 513):
            x = rng.uniform(-3, 3, (k, n, 7))
            f(*x)
            f(*[x[0]] * k)  # the same array for all
            f(*[np.asfortranarray(a) for a in x])
            f(*[a.astype('>f4') for a in x])
            f(*[np.frombuffer(b'x' + a.tobytes(), offset=1).reshape(a.shape) for a in x if n] or x)
            fixed = x.copy()
            fixed.flags.writeable = False
            f(*fixed)
            for value in (1e300, -1e300, 5e-324, 1e8, -0.0):
                f(*np.full((k, n, 7), value))
            for bad in range(k if n else 0):
                broken = x.copy()
                broken[bad, -1, -1] = np.nan
                try:
                    f(*broken)
                except ValueError:
                    count += 1
        wrong = 'a', None, [[0.0] * 6], np.zeros((2, 8)), object(), 1j * np.ones(7)
        for arguments in ([], *([value] * k for value in wrong)):
            try:
                f(*arguments)
            except (TypeError, ValueError):
                count += 1
print(len(module.TARGETS), count)
"""


@pytest.mark.timeout(300)
def test_extreme_inputs_under_sanitizers(tmp_path):
    pybind11 = pytest.importorskip('pybind11', reason='needs pybind11: pip install pybind11')
    if shutil.which('g++') is None:
        pytest.skip('g++ is missing: apt install g++')

    def library(name):
        return subprocess.run(['g++', f'-print-file-name={name}'], text=True, check=True,
                              capture_output=True, timeout=10).stdout.strip()
    if '/' not in library('libasan.so') or '/' not in library('libubsan.so'):
        pytest.skip('the sanitizers are missing: they come with gcc on most systems')
    built = tmp_path / f'_compiled{sysconfig.get_config_var("EXT_SUFFIX")}'
    done = subprocess.run(
        ['g++', *STRICT, f'-I{sysconfig.get_path("include")}', f'-I{pybind11.get_include()}',
         SOURCE, '-o', str(built)], text=True, capture_output=True, timeout=280)
    assert (done.returncode, done.stderr) == (0, '')
    done = subprocess.run(
        [sys.executable, '-c', EXTREMES, str(built)], text=True, capture_output=True, timeout=100,
        env={**os.environ, 'LD_PRELOAD': f'{library("libasan.so")} {library("libstdc++.so")}',
             'ASAN_OPTIONS': 'detect_leaks=0', 'BAXTER_DYNAMICS_ENGINE': 'python'})
    assert done.returncode == 0, done.stderr[-3000:]
    targets, refused = map(int, done.stdout.split())
    functions = _closed_form.FUNCTIONS.values()
    each = sum(3 * (1 + len(inputs)) + 6 + 1 for inputs, _ in functions)
    assert refused == targets * each


def test_build_without_a_compiler_prints_one_line(tmp_path):
    repository = Path(SOURCE).parents[2]
    done = subprocess.run(
        [sys.executable, 'setup.py', '-q', 'build_ext', '-b', str(tmp_path), '-t', str(tmp_path)],
        cwd=repository, text=True, capture_output=True, timeout=60,
        env={**os.environ, 'CC': 'false', 'CXX': 'false'})
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stderr.splitlines() if line.startswith('baxter_dynamics_ros')]
    assert line.startswith('baxter_dynamics_ros: the compiled engine was not built (')
    assert line.endswith('); using the Python engine')
    assert not list(tmp_path.rglob('*.so'))
