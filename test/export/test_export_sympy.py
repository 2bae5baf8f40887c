"""The file for SymPy, run in SymPy, against the specification."""

import importlib.util

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export.functions import constants, SYMBOLS
import numpy as np
import pytest

sympy = pytest.importorskip('sympy', reason='needs SymPy: pip install sympy')


@pytest.fixture
def load(export):
    """Return a function that exports an arm, and imports the file."""
    def load(arm, *symbols):
        (path,) = export('sympy_file', arm, *symbols).values()
        spec = importlib.util.spec_from_file_location('exported', path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


@pytest.fixture
def compute(states):
    """Return a function that computes at all states, by lambdify: arrays (200, ...)."""
    def run(module, function, parameters=None, values=()):
        arguments = [name for name in states if name in function.quantity.inputs or name == 'q']
        definitions, result = getattr(module, function.quantity.name)(
            **({'parameters': parameters} if parameters else {}))
        results = result if isinstance(result, tuple) else (result,)
        symbols = [getattr(module, name) for name in arguments]
        if parameters:
            symbols.append(list(parameters.values()))
        f = module.numeric(symbols, definitions, [list(sympy.flatten(x)) for x in results])
        inputs = [states[name].T for name in arguments] + ([values] if parameters else [])
        return [np.stack([np.broadcast_to(x, 200) for x in row], -1).reshape(200, *output.shape)
                for row, output in zip(f(*inputs), function.quantity.outputs)]

    return run


def test_all_quantities_are_the_specification(load, functions, compute, arm, specification):
    module, truth = load(arm), specification(arm)
    assert len(functions(arm)) == len(SYMBOLS)
    for function in functions(arm):
        truth.check(function.quantity.name, *compute(module, function))


def test_another_payload_is_other_parameters(load, functions, compute, specification):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    module, truth = load(BaxterArm(), ('M', 'tau')), specification(loaded)
    numbers = [constants(loaded)[name] for name in module.PARAMETERS]
    for function in functions(loaded, ('M', 'tau')):
        results = compute(module, function, module.SYMBOLS, numbers)
        truth.check(function.quantity.name, *results)


def test_results_are_matrices_in_a_few_definitions(load):
    module = load(BaxterArm(), ('MCG', 'christoffel'))
    definitions, (m, c, g) = module.terms()
    assert (m.shape, c.shape, g.shape) == ((7, 7), (7, 7), (7, 1))
    known = {*module.q, *module.qd}
    for symbol, expression in definitions:
        assert expression.free_symbols <= known
        known.add(symbol)
    assert (m.free_symbols | c.free_symbols | g.free_symbols) <= known
    assert len(definitions) < 500
    assert module.christoffel_symbols()[1].shape == (7, 7, 7)


def test_one_state_by_lambdify(load, states):
    module = load(BaxterArm(), ('G',))
    g = module.numeric([module.q], *module.gravity())(states['q'][0])
    np.testing.assert_allclose(g[:, 0], BaxterArm().gravity(states['q'][0]), rtol=0.0, atol=1e-11)


def test_gravity_written_out_is_the_gradient_of_a_potential(load, arm, states):
    # So dG/dq is symmetric.
    module = load(arm, ('G',))
    gradient = module.expanded(*module.gravity()).jacobian(module.q)
    assert gradient.free_symbols <= set(module.q)
    value = sympy.lambdify([module.q], gradient, cse=True)(states['q'][0])
    np.testing.assert_allclose(value, value.T, rtol=0.0, atol=1e-11)
    assert np.abs(value).max() > 1.0


def test_several_results_are_expanded_together(load):
    module = load(BaxterArm(), ('MCG',))
    m, c, g = module.expanded(*module.terms())
    assert m.free_symbols | g.free_symbols <= set(module.q)
    assert c.free_symbols <= {*module.q, *module.qd}


@pytest.mark.parametrize('length', [6, 8])
def test_vectors_of_another_length_are_refused(load, length):
    with pytest.raises(ValueError, match=f'q: expected 7 symbols or numbers, got {length}'):
        load(BaxterArm(), ('G',)).gravity([0.1] * length)


def test_symbols_of_ones_own(load):
    module = load(BaxterArm(), ('G',))
    t = sympy.Symbol('t')
    motion = [sympy.Function(f'theta{i}')(t) for i in range(7)]
    definitions, g = module.gravity(motion, module.SYMBOLS, prefix='G_')
    names = {str(symbol) for symbol, _ in definitions}
    assert {'G_s1', 'G_t1'} <= names
    assert all(name.startswith('G_') for name in names)
    assert module.expanded(definitions, g)[1].has(motion[1], module.SYMBOLS['up_z'])


def test_numbers_put_in_definitions_and_result(load, states):
    module = load(BaxterArm(), ('M',))
    definitions, m = module.mass_matrix()
    values = dict(zip(module.q, states['q'][0].tolist()))
    numbers = [(symbol, expression.subs(values)) for symbol, expression in definitions]
    m = np.array(module.expanded(numbers, m.subs(values)), float)
    np.testing.assert_allclose(m, BaxterArm().mass_matrix(states['q'][0]), rtol=0.0, atol=1e-11)


def test_the_file_stands_alone_and_explains_itself(export):
    (path,) = export('sympy_file', BaxterArm()).values()
    text = path.read_text(encoding='utf-8')
    imports = [line for line in text.splitlines() if line.split(' ')[0] in ('import', 'from')]
    assert imports == ['import sympy']
    assert path.name == 'baxter_dynamics_sympy.py'
    assert 'Joint order: s0, s1, e0, e1, w0, w1, w2.' in text
    assert 'qd: (7) joint velocities [rad/s]' in text
    assert '# kg m, first moment of mass x of link 7, body frame 7' in text
