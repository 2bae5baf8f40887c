"""The exported Python file on floats, NumPy arrays and the symbols of CasADi and SymPy."""

from importlib.util import module_from_spec, spec_from_file_location
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.export.common import parameters
import numpy as np
import pytest


def load(export, arm):
    """Return the exported module of an arm."""
    (path,) = export('python', arm).values()
    spec = spec_from_file_location('exported', path)
    result = module_from_spec(spec)
    spec.loader.exec_module(result)
    return result


@pytest.fixture
def module(export, arm):
    return load(export, arm)


def vectors(module, name):
    return 'q', *module.FUNCTIONS[name][0]


def test_numpy_arrays(module, states, check, arm):
    assert dict(zip(module.PARAMETERS, module.VALUES)) == {
        p.name: p.value for p in parameters(arm)}
    for name in module.FUNCTIONS:
        arguments = [states[vector] for vector in vectors(module, name)]
        results = module.evaluate(getattr(module, name), *arguments)
        check(name, results if isinstance(results, tuple) else (results,))
        one = module.evaluate(getattr(module, name), *(x[0] for x in arguments))
        one = one if isinstance(one, tuple) else (one,)
        assert [x.shape for x in one] == [output[1] for output in module.FUNCTIONS[name][1]]
    assert module.evaluate(module.gravity, np.empty((0, 7))).shape == (0, 7)
    with pytest.raises(ValueError, match=r'shape \(\.\.\., 7\), got \(3,\)'):
        module.evaluate(module.gravity, np.zeros(3))


def test_casadi_symbols(module, states, check):
    casadi = pytest.importorskip('casadi', reason='needs CasADi: pip install casadi')
    for name, (_, outputs) in module.FUNCTIONS.items():
        symbols = [casadi.SX.sym(vector, 7) for vector in vectors(module, name)]
        inputs = [casadi.vertsplit(x) for x in (casadi.sin(symbols[0]), casadi.cos(symbols[0]),
                                                *symbols[1:])]
        values = casadi.vertcat(*getattr(module, name)(*inputs, module.VALUES))
        function = casadi.Function('f', symbols, [values])
        flat = function(*(states[vector].T for vector in vectors(module, name))).full().T
        sizes = np.cumsum([np.prod(output[1]) for output in outputs])[:-1]
        check(name, [part.reshape(-1, *output[1])
                     for part, output in zip(np.split(flat, sizes, axis=1), outputs)])


def test_sympy_symbols(export):
    sympy = pytest.importorskip('sympy', reason='needs SymPy: pip install sympy')
    module = load(export, BaxterArm())
    for name in ('gravity', 'forward_kinematics'):
        q = sympy.symbols('q1:8')
        values = getattr(module, name)(map(sympy.sin, q), map(sympy.cos, q), module.VALUES)
        result = sympy.lambdify(q, values, modules='math')(*np.full(7, 0.3).tolist())
        np.testing.assert_allclose(result, getattr(BaxterArm(), name)(np.full(7, 0.3)).ravel(),
                                   rtol=1e-11, atol=1e-11)


def test_gradients(module, states, arm):
    """Of JAX and PyTorch, if they are installed."""
    q, qd, qdd = (states[name][0] for name in ('q', 'qd', 'qdd'))
    expected = arm.inverse_dynamics_gradient(q, qd, qdd)[0]
    jax = pytest.importorskip('jax', reason='pip install jax torch')
    jax.config.update('jax_enable_x64', True)
    jnp = jax.numpy
    gradient = jax.jit(jax.jacfwd(lambda x: jnp.stack(module.inverse_dynamics(
        jnp.sin(x), jnp.cos(x), qd, qdd, module.VALUES))))(q)
    np.testing.assert_allclose(gradient, expected, rtol=0.0, atol=1e-11)
    torch = pytest.importorskip('torch', reason='pip install jax torch')
    gradient = torch.autograd.functional.jacobian(lambda x: torch.stack(module.inverse_dynamics(
        torch.sin(x), torch.cos(x), torch.tensor(qd), torch.tensor(qdd), module.VALUES)),
        torch.tensor(q))
    np.testing.assert_allclose(gradient.numpy(), expected, rtol=0.0, atol=1e-11)


def test_imports_nothing(export):
    (path,) = export('python', BaxterArm()).values()
    code = ('import sys; before = set(sys.modules); import baxter_dynamics as b; '
            'assert set(sys.modules) - before == {"baxter_dynamics"}; '
            'print(*b.gravity([0.0] * 7, [1.0] * 7, b.VALUES))')
    done = subprocess.run([sys.executable, '-S', '-c', code], cwd=path.parent, text=True,
                          capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(np.array(done.stdout.split(), float),
                               BaxterArm().gravity(np.zeros(7)), rtol=0.0, atol=1e-11)
