"""The exported Python for numba, in processes without this package, against the specification."""

import os
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export import numba_file
from baxter_dynamics_ros.export.legend import parameters
from baxter_dynamics_ros.model.exceptions import ArgumentError
import numpy as np
import pytest

pytest.importorskip('numba', reason='needs numba: pip install numba')

HEAD = """
import sys
import numpy as np
sys.path.insert(0, '.')
import baxter_dynamics_numba as module
assert not [name for name in sys.modules if name.startswith('baxter_dynamics_ros')]
p = module.array()
"""
ALL = """
states, results = np.load('states.npz'), {}
p = module.array({**module.PARAMETERS, **%r})
for name, arguments in %r.items():
    vectors = [states[argument] for argument in arguments]
    many = getattr(module, name + '_batch')(*vectors, p)
    ones = [getattr(module, name)(*state, p) for state in zip(*vectors)]
    if not isinstance(many, tuple):
        many, ones = (many,), [(one,) for one in ones]
    for i, (output, rows) in enumerate(zip(many, zip(*ones))):
        results[f'{name} {i} many'], results[f'{name} {i} one'] = output, np.stack(rows)
np.savez('results.npz', **results)
"""


@pytest.fixture
def run(tmp_path):
    """Return a function that runs Python in the folder of the file, without this package."""
    def run(code, **environment):
        done = subprocess.run(
            [sys.executable, '-I', '-c', HEAD + code], cwd=tmp_path, capture_output=True,
            text=True, timeout=100, env={**os.environ, **environment})
        assert (done.returncode, done.stderr) == (0, '')
        return done.stdout

    return run


@pytest.fixture
def compare(export, functions, states, specification, run, tmp_path):
    """Return a function that checks some quantities of an arm, of one state and of many."""
    def compare(arm, *symbols, changed=None, **environment):
        export('numba_file', arm, *symbols)
        np.savez(tmp_path / 'states.npz', **states)
        named = functions(arm, *symbols)
        calls = {function.quantity.name: function.arguments for function in named}
        changes = {p.name: p.value for p in parameters(changed)} if changed else {}
        run(ALL % (changes, calls), **environment)
        truth = specification(changed or arm)
        with np.load(tmp_path / 'results.npz') as results:
            for function in named:
                name, count = function.quantity.name, len(function.quantity.outputs)
                for kind in ('many', 'one'):
                    truth.check(name, *(results[f'{name} {i} {kind}'] for i in range(count)))

    return compare


def test_all_quantities_are_the_specification_before_they_are_compiled(compare, arm):
    compare(arm, NUMBA_DISABLE_JIT='1')


def test_compiled_they_are_the_specification(compare):
    compare(BaxterArm(), ('MCG',))


def test_compiled_for_a_tilted_base_and_a_payload(compare):
    compare(BaxterArm(Payload(1.2, (0.03, -0.02, 0.11)), gravity=(1.3, -2.1, -9.4)),
            ('tau',))


def test_another_payload_is_other_parameters(compare):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    compare(BaxterArm(), ('tau', 'MCG'), changed=loaded, NUMBA_DISABLE_JIT='1')


def test_what_would_be_read_out_of_place_is_refused(export, run):
    export('numba_file', BaxterArm(), ('Cqd',))
    said = run("""
wrong = ['one', np.zeros(6), np.zeros(7), p], ['one', np.zeros(7), np.zeros(8), p], \\
    ['one', np.zeros(7), np.zeros(7), p[1:]], \\
    ['many', np.zeros((3, 7)), np.zeros((2, 7)), p], ['many', *np.zeros((2, 3, 6)), p]
for kind, *arguments in wrong:
    try:
        (module.coriolis_torque if kind == 'one' else module.coriolis_torque_batch)(*arguments)
        print('taken')
    except ValueError as error:
        print(error)
""")
    assert said.splitlines() == ['expected arrays (7), and p by array()'] * 3 + [
        'expected arrays (n, 7), and p by array()'] * 2


def test_compiled_functions_may_call_them(export, run):
    export('numba_file', BaxterArm(), ('G',))
    said = run("""
from numba import njit
@njit
def largest(q, p):
    result = 0.0
    for g in module.gravity_batch(q, p):
        result = max(result, np.abs(g).max())
    return result
for n in (0, 1, 63, 64, 65, 200):
    q = np.linspace(-1, 1, 7 * n).reshape(n, 7)
    expected = max((abs(module.gravity(x, p)).max() for x in q), default=0)
    print(n, abs(largest(q, p) - expected) < 1e-12)
""")
    assert said.split() == '0 True 1 True 63 True 64 True 65 True 200 True'.split()


def test_the_next_process_need_not_compile(export, run):
    export('numba_file', BaxterArm(), ('G',))
    code = 'module.gravity(np.zeros(7), p); print(*module.gravity.stats.cache_hits.values())'
    assert run(code).split() == []
    assert run(code).split() == ['1']


def test_the_file_explains_itself(export, arm):
    (path,) = export('numba_file', arm, ('tau',)).values()
    text = path.read_text()
    assert path.name == 'baxter_dynamics_numba.py'
    assert 'Joint order: s0, s1, e0, e1, w0, w1, w2.' in text
    assert 'qd: (7) joint velocities [rad/s]' in text
    assert '# kg m, first moment of mass x of link 7, body frame 7' in text
    assert max(map(len, text.splitlines())) <= 99


@pytest.mark.parametrize('name', ['7up', 'my-arm', ''])
def test_a_name_that_no_module_can_have(functions, name):
    with pytest.raises(ArgumentError, match='cannot be the name of a Python module'):
        numba_file.files(functions(BaxterArm(), ('tau',)), BaxterArm(), name)
