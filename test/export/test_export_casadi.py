"""The file for CasADi, run in CasADi, against the specification."""

import importlib.util

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export.functions import constants, SYMBOLS
import numpy as np
import pytest

casadi = pytest.importorskip('casadi', reason='needs CasADi: pip install casadi')


@pytest.fixture
def load(export):
    """Return a function that exports an arm, and imports the file."""
    def load(arm, *symbols):
        (path,) = export('casadi_file', arm, *symbols).values()
        spec = importlib.util.spec_from_file_location('exported', path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


def call(function, states, *more):
    """Return the outputs of a casadi.Function at all states, as arrays (n, ...)."""
    names = [name for name in function.name_in() if name in states]
    outputs = function.call([casadi.DM(states[name].T) for name in names] + list(more))
    results = []
    for output, rows in zip(outputs, map(function.size1_out, range(function.n_out()))):
        columns = output.shape[1] // len(states['q'])
        array = output.full().reshape(rows, -1, columns).swapaxes(0, 1)
        results.append(array[..., 0] if columns == 1 else array)
    return results


def test_all_quantities_are_the_specification(load, arm, states, specification):
    module, truth = load(arm), specification(arm)
    assert list(module.FUNCTIONS) == list(SYMBOLS.values())
    for name in module.FUNCTIONS:
        results = call(module.function(name), states)
        if name == 'christoffel_symbols':
            results = [results[0].reshape(-1, 7, 7, 7)]
        truth.check(name, *results)


def test_another_payload_is_other_parameters(load, states, specification):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    module, truth = load(BaxterArm(), ('tau', 'gradient')), specification(loaded)
    numbers = [constants(loaded)[name] for name in module.PARAMETERS]
    for name in module.FUNCTIONS:
        results = call(module.function(name, None), states, numbers)
        truth.check(name, *results)
        results = call(module.function(name, dict(zip(module.PARAMETERS, numbers))), states)
        truth.check(name, *results)


def test_a_function_names_what_it_takes_and_gives(load):
    module = load(BaxterArm(), ('MCG', 'qdd'))
    terms = module.function('terms')
    assert (terms.name(), terms.name_in(), terms.name_out()) == (
        'terms', ['q', 'qd'], ['M', 'C', 'G'])
    forward = module.function('forward_dynamics', None)
    assert forward.name_in() == ['q', 'qd', 'tau', 'parameters']
    assert forward.name_out() == ['qdd']


def test_casadi_differentiates_the_expression(load, arm, states, specification):
    module = load(arm, ('tau',))
    symbols = [casadi.SX.sym(name, 7) for name in ('q', 'qd', 'qdd')]
    tau = module.inverse_dynamics(*symbols)
    gradient = casadi.Function('gradient', symbols, [
        casadi.densify(casadi.jacobian(tau, symbol)) for symbol in symbols[:2]],
        ['q', 'qd', 'qdd'], ['dq', 'dqd'])
    specification(arm).check('inverse_dynamics_gradient', *call(gradient, states))


@pytest.mark.parametrize('kind', [casadi.SX, casadi.MX, casadi.DM], ids=['SX', 'MX', 'DM'])
def test_expressions_of_every_kind(load, kind, states):
    g = load(BaxterArm(), ('G',)).gravity(kind(casadi.DM(states['q'][0])))
    assert isinstance(g, kind)
    value = casadi.evalf(g).full()[:, 0]
    np.testing.assert_allclose(value, BaxterArm().gravity(states['q'][0]), rtol=0.0, atol=1e-11)


def test_a_matrix_of_states_is_no_vector(load):
    with pytest.raises(ValueError, match=r'expected a vector \(7\), got \(7, 2\)'):
        load(BaxterArm(), ('G',)).gravity(casadi.DM.zeros(7, 2))


def test_the_file_stands_alone_and_explains_itself(export):
    (path,) = export('casadi_file', BaxterArm()).values()
    text = path.read_text(encoding='utf-8')
    imports = [line for line in text.splitlines() if line.split(' ')[0] in ('import', 'from')]
    assert imports == ['import casadi']
    assert path.name == 'baxter_dynamics_casadi.py'
    assert 'Joint order: s0, s1, e0, e1, w0, w1, w2.' in text
    assert 'q: (7) joint positions [rad]' in text
    assert '# kg m, first moment of mass x of link 7, body frame 7' in text
