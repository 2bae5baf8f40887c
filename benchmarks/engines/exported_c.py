"""What `baxter_dynamics export` writes in C, compiled for this machine."""

import ctypes
from pathlib import Path
import shutil
import subprocess
import tempfile

from baxter_dynamics_ros.export import c
from baxter_dynamics_ros.export.functions import derive
import numpy as np

from .engine import Engine

FLAGS = ('-O3', '-march=native')
_QUANTITIES = ('tau', 'MCG', 'qdd')  # by the names of export

# Calls on one state after the other, without Python between them; in a file of its own, so that
# the compiler cannot look through the call.
_LOOP = """
#include "baxter_dynamics.h"
typedef baxter_dynamics_parameters parameters;
void loop(void (*call)(const double *, const double *, const double *, const parameters *,
                       double *), size_t calls, size_t n, const double *states)
{
    double result[7];
    for (size_t i = 0, k = 0; i < calls; i++, k = k + 1 < n ? k + 1 : 0) {
        const double *x = states + 21 * k;
        call(x, x + 7, x + 14, &baxter_dynamics_default, result);
    }
}
void loop_terms(size_t calls, size_t n, const double *states)
{
    double m[49], c[49], g[7];
    for (size_t i = 0, k = 0; i < calls; i++, k = k + 1 < n ? k + 1 : 0) {
        const double *x = states + 14 * k;
        baxter_dynamics_terms(x, x + 7, &baxter_dynamics_default, m, c, g);
    }
}
"""


def engines(arm) -> list:
    """Return the exported functions, timed in a loop in C; and one as Python calls it."""
    library, compiler = _compiled(arm)
    note = f'{compiler} {" ".join(FLAGS)}'
    tau = _one(library, 'inverse_dynamics', 3, [(7,)])
    exported = Engine(
        'ours, exported C', tau=tau, matrices=_one(library, 'terms', 2, [(7, 7), (7, 7), (7,)]),
        forward=_one(library, 'forward_dynamics', 3, [(7,)]), batch=_batch(library),
        loops={'tau': _loop(library, 'inverse_dynamics'), 'matrices': _loop_terms(library),
               'forward': _loop(library, 'forward_dynamics')},
        notes={**dict.fromkeys(('tau', 'matrices', 'forward'), f'called in C; {note}'),
               'batch': note})
    return [exported, Engine('ours, exported C by ctypes', tau=tau,
                             notes={'tau': 'called in Python: what ctypes costs'})]


def _compiled(arm) -> tuple:
    """Return the library, and the compiler's name with its version."""
    path = shutil.which('gcc')
    if path is None:
        raise ImportError('no compiler gcc')
    with tempfile.TemporaryDirectory() as folder:
        files = {**c.files(derive(arm, _QUANTITIES), arm), 'loop.c': _LOOP}
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding='utf-8')
        subprocess.run([path, *FLAGS, '-shared', '-fPIC', '-o', 'library.so', 'loop.c',
                        'baxter_dynamics.c', '-lm'], cwd=folder, check=True, timeout=100)
        library = ctypes.CDLL(str(Path(folder, 'library.so')))
    version = subprocess.run([path, '-dumpfullversion'], check=True, capture_output=True,
                             text=True, timeout=10).stdout.strip()
    return library, f'gcc {version}'


def _one(library, name: str, inputs: int, shapes: list):
    """Return a function of one state, by ctypes; its arguments and results have fixed places."""
    function, state = library[f'baxter_dynamics_{name}'], np.empty((inputs, 7))
    results = [np.empty(shape) for shape in shapes]
    places = [*map(_pointer, state), _defaults(library), *map(_pointer, results)]

    def call(*arguments):
        for row, argument in zip(state, arguments):
            row[:] = argument
        function(*places)
        return results if len(results) > 1 else results[0]

    return call


def _batch(library):
    function, results = library.baxter_dynamics_inverse_dynamics_batch, {}

    def batch(q, qd, qdd):
        if q.shape not in results:
            results[q.shape] = np.empty(q.shape)
        tau = results[q.shape]
        function(ctypes.c_size_t(len(q)), *map(_pointer, (q, qd, qdd)), _defaults(library),
                 _pointer(tau))
        return tau

    return batch


def _loop(library, name: str):
    """Return a function of states that returns a function (n), which makes n calls in C."""
    function = library[f'baxter_dynamics_{name}']

    def over(*arguments):
        states = np.concatenate(arguments, axis=1)
        return lambda n: library.loop(function, ctypes.c_size_t(n), ctypes.c_size_t(len(states)),
                                      _pointer(states))

    return over


def _loop_terms(library):
    def over(*arguments):
        states = np.concatenate(arguments, axis=1)
        return lambda n: library.loop_terms(
            ctypes.c_size_t(n), ctypes.c_size_t(len(states)), _pointer(states))

    return over


def _defaults(library):
    """Return the place of the arm's numbers."""
    return ctypes.byref(ctypes.c_char.in_dll(library, 'baxter_dynamics_default'))


def _pointer(array: np.ndarray):
    return ctypes.c_void_p(array.ctypes.data)
