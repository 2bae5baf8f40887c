"""The exported Python, imported in a process without this package, against the specification."""

import ast
import importlib.util
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export import python
from baxter_dynamics_ros.export.functions import SYMBOLS
from baxter_dynamics_ros.export.legend import parameters
from baxter_dynamics_ros.model.exceptions import ArgumentError
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-11}
ALONE = """
import sys
import numpy as np
before = set(sys.modules)
sys.path.insert(0, '.')
import baxter_dynamics
states, results = np.load('states.npz'), {}
for name, arguments in %r.items():
    result = getattr(baxter_dynamics, name)(*(states[argument] for argument in arguments))
    for i, output in enumerate(result if isinstance(result, tuple) else (result,)):
        results[f'{name} {i}'] = output
np.savez('results.npz', **results)
print(*sorted({name.split('.')[0] for name in set(sys.modules) - before}
              - set(sys.stdlib_module_names)))
"""


@pytest.fixture
def load(export):
    """Return a function that exports an arm, and imports the file."""
    def load(arm, *symbols):
        (path,) = export('python', arm, *symbols).values()
        spec = importlib.util.spec_from_file_location('exported', path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


def listed(result):
    """Return a function's outputs as a list."""
    return list(result) if isinstance(result, tuple) else [result]


def test_all_quantities_are_the_specification_in_a_process_of_its_own(
        export, functions, arm, states, specification, tmp_path):
    export('python', arm)
    np.savez(tmp_path / 'states.npz', **states)
    calls = {function.quantity.name: function.arguments for function in functions(arm)}
    assert list(calls) == list(SYMBOLS.values())
    # -I: neither environment nor current folder lead to this package.
    done = subprocess.run([sys.executable, '-I', '-c', ALONE % calls], cwd=tmp_path,
                          capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.split() == ['baxter_dynamics']
    truth = specification(arm)
    with np.load(tmp_path / 'results.npz') as results:
        for function in functions(arm):
            name = function.quantity.name
            truth.check(name, *(results[f'{name} {i}']
                                for i in range(len(function.quantity.outputs))))
        np.testing.assert_allclose(results['regressor 0'] @ arm.base_parameters,
                                   truth.inverse_dynamics, **EXACT)


def test_one_state_is_a_row_of_many(load, functions, arm, states):
    module = load(arm)
    for function in functions(arm):
        vectors = [states[argument][:20] for argument in function.arguments]
        call = getattr(module, function.quantity.name)
        many = listed(call(*vectors))
        for i, state in enumerate(zip(*vectors)):
            for one, all_, output in zip(listed(call(*state)), many, function.quantity.outputs):
                assert one.shape == output.shape
                np.testing.assert_allclose(one, all_[i], rtol=1e-10, atol=1e-12)


def test_it_is_the_gradient(load, arm, states):
    module, step = load(arm, ('tau', 'gradient')), 1e-6
    q, qd, qdd = (states[name][:30] for name in ('q', 'qd', 'qdd'))
    dq, dqd = module.inverse_dynamics_gradient(q, qd, qdd)
    for k, direction in enumerate(step * np.eye(7)):
        for gradient, moved in ((dq, (1, 0)), (dqd, (0, 1))):
            ahead, behind = (module.inverse_dynamics(
                q + sign * moved[0] * direction, qd + sign * moved[1] * direction, qdd)
                for sign in (1, -1))
            np.testing.assert_allclose(gradient[..., k], (ahead - behind) / (2 * step), rtol=0.0,
                                       atol=1e-6)
    for ours, theirs in zip((dq, dqd), arm.inverse_dynamics_gradient(q, qd, qdd)):
        np.testing.assert_allclose(ours, theirs, **EXACT)


def test_leading_axes_are_kept_and_broadcast(load, states):
    module = load(BaxterArm(), ('MCG', 'tau'))
    q, qd, qdd = (states[name][:24].reshape(2, 3, 4, 7) for name in ('q', 'qd', 'qdd'))
    assert [x.shape for x in module.terms(q, qd)] == [
        (2, 3, 4, 7, 7), (2, 3, 4, 7, 7), (2, 3, 4, 7)]
    result = module.inverse_dynamics(q[:, :1], qd[0], qdd[0, 0, 0])
    assert result.shape == (2, 3, 4, 7)
    np.testing.assert_allclose(
        result[1, 2, 3], module.inverse_dynamics(q[1, 0, 3], qd[0, 2, 3], qdd[0, 0, 0]), **EXACT)
    assert module.inverse_dynamics(*np.empty((3, 0, 7))).shape == (0, 7)


def test_batches_beyond_a_block(load, random_states):
    module = load(BaxterArm(), ('tau',))
    states = random_states(module.BLOCK + 2)
    result = module.inverse_dynamics(*states)
    for i in (0, module.BLOCK - 1, module.BLOCK, module.BLOCK + 1):
        np.testing.assert_allclose(result[i], module.inverse_dynamics(*(x[i] for x in states)),
                                   **EXACT)


def test_another_payload_is_other_parameters(load, states, specification):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    module, truth = load(BaxterArm(), ('tau',)), specification(loaded)
    known = {p.name: p.value for p in reversed(parameters(loaded))}  # in whatever order
    truth.check('inverse_dynamics', module.inverse_dynamics(
        states['q'], states['qd'], states['qdd'], known))


@pytest.mark.parametrize('change, problem', [
    ({'up_x': 1.0}, 'parameters: unknown up_x; expected'),
    ({'XX7': 1.0, 'xx7': None}, 'parameters: unknown XX7; missing xx7; expected')])
@pytest.mark.parametrize('target', ['python', 'casadi_file', 'sympy_file', 'numba_file'])
def test_parameters_of_another_export_are_refused(export, target, change, problem):
    pytest.importorskip(target.partition('_')[0].replace('python', 'numpy'))
    (path,) = export(target, BaxterArm(), ('G',)).values()
    spec = importlib.util.spec_from_file_location('exported', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    values = {name: value for name, value in {**module.PARAMETERS, **change}.items()
              if value is not None}
    with pytest.raises(ValueError, match=problem):
        if target == 'numba_file':
            module.array(values)
        elif target == 'casadi_file':
            module.function('gravity', values)
        else:
            module.gravity([0.1] * 7, parameters=values)


@pytest.mark.parametrize('shape', [(), (6,), (7, 1), (3, 8)])
def test_arrays_of_another_shape_are_refused(load, shape):
    module = load(BaxterArm(), ('tau',))
    with pytest.raises(ValueError, match=r'expected an array \(..., 7\), got '):
        module.inverse_dynamics(np.zeros(7), np.zeros(shape), np.zeros(7))


def test_lists_and_integers_will_do(load):
    module = load(BaxterArm(), ('G',))
    np.testing.assert_array_equal(module.gravity([0, 1, 0, 1, 0, 1, 0]),
                                  module.gravity(np.array([0.0, 1, 0, 1, 0, 1, 0])))


def test_the_file_explains_itself(export, functions, arm):
    (path,) = export('python', arm).values()
    assert path.name == 'baxter_dynamics.py'
    tree = ast.parse(path.read_text(encoding='utf-8'))
    assert 'Joint order: s0, s1, e0, e1, w0, w1, w2.' in ast.get_docstring(tree)
    documented = {node.name: ' '.join(ast.get_docstring(node).split()) for node in tree.body
                  if isinstance(node, ast.FunctionDef) and ast.get_docstring(node)}
    for function in functions(arm):
        text = documented[function.quantity.name]
        assert f'{function.program.operations()} operations' in text
        assert 'q: (7) joint positions [rad]' in text
        for output in function.quantity.outputs:
            assert f'[{output.unit}], {output.text}' in text
    source = path.read_text()
    assert max(map(len, source.splitlines())) <= 99
    for parameter in parameters(arm):
        assert f'# {parameter.unit}, {parameter.text}\n' in source


@pytest.mark.parametrize('name', ['7up', 'my-arm', '', 'class', 'größe'])
def test_a_name_that_no_module_can_have(functions, name):
    with pytest.raises(ArgumentError, match='cannot be the name of a Python module'):
        python.files(functions(BaxterArm(), ('tau',)), BaxterArm(), name)
