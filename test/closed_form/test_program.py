"""Programs and their text: each value once, and the same numbers as the expressions."""

import re

import numpy as np
import pytest

casadi = pytest.importorskip('casadi', reason='needed to derive the closed form: '
                             'pip install casadi')
from tools.closed_form.derivation import program_of, trace  # noqa: E402, I100
from tools.closed_form.quantities import QUANTITIES  # noqa: E402
from tools.closed_form.infix import assignments  # noqa: E402

x, y, z, w = SYMBOLS = [casadi.SX.sym(name) for name in 'xyzw']


def run(program, outputs=None, **options):
    """Return what the text of a program computes at x, y, z, w = 2, 3, 5, 7."""
    names = [f'out{i}' for i in range(len(program.outputs))]
    values = dict(zip('xyzw', (2.0, 3.0, 5.0, 7.0)))
    for name, text in assignments(program, names, **options):
        values[name] = eval(text, {}, values)  # noqa: P204
    return [values[name] for name in names]


@pytest.mark.parametrize('expression, operations', [
    (x * y - y * x, 0),
    (x * y + y * x, 2),
    ((x - y) * z + (y - x) * z, 0),
    ((x - y) * (z - w) - (y - x) * (w - z), 0),
    (x * (-y) + w, 2),
    (-x - y, 1),
    ((x + y) * (x + y), 2),
    (0 * x + 1 * y, 0),
    (x / y + z / y, 4),
])
def test_each_value_is_kept_once_up_to_its_sign(expression, operations):
    program = trace(SYMBOLS, [expression])
    assert program.operations() == operations
    value = casadi.Function('f', SYMBOLS, [expression])(2, 3, 5, 7)
    assert run(program) == pytest.approx([float(value)])


@pytest.mark.parametrize('expression', [
    x - (y - z), x - (y + z), x * (y * z), x / (y * z), (x - y) * (z - w), -(x + y) * z, 2 * x * y,
    x - (y - (z - w)), -(x * y), -((x + y) * (z - w)),
])
def test_brackets(expression):
    value = float(casadi.Function('f', SYMBOLS, [expression])(2, 3, 5, 7))
    for longest in (2, 16):
        assert run(trace(SYMBOLS, [expression]), longest=longest) == pytest.approx([value])


def test_a_difference_is_turned_to_spare_a_minus_sign():
    text = dict(assignments(trace(SYMBOLS, [y - x, -(z - w) * x]), ['a', 'b']))
    assert text['a'] == 'y - x'
    assert not text['b'].startswith('-')


def test_outputs_that_are_inputs_numbers_and_repeated():
    program = trace(SYMBOLS, [x, casadi.SX(3), -y, x * y, x * y, -x * y, 0])
    assert run(program) == [2.0, 3.0, -3.0, 6.0, 6.0, -6.0, 0.0]


def test_an_unknown_operation_is_refused():
    with pytest.raises(Exception, match='no rule for the CasADi operation'):
        trace(SYMBOLS, [casadi.sqrt(x)])


@pytest.mark.parametrize('options', [
    {}, {'reuse': True}, {'longest': 2}, {'reuse': True, 'longest': 40}], ids=str)
def test_text_computes_what_casadi_computes(options, rng):
    program = program_of(QUANTITIES['torque_terms'], True)
    inputs = sorted({node[1] for node in program.nodes if node[0] == 'input'})
    names = {name: re.sub(r'\W', '_', name) for name in inputs}
    values = {names[name]: number for name, number in zip(inputs, rng.normal(size=len(inputs)))}
    targets = [f'out{i}' for i in range(len(program.outputs))]
    expected = list(_values(program, {name: values[names[name]] for name in inputs}))
    for name, text in assignments(program, targets, names, **options):
        values[name] = eval(text, {}, values)  # noqa: P204
    np.testing.assert_allclose([values[name] for name in targets], expected, rtol=1e-10)


def test_reuse_needs_fewer_names():
    program = program_of(QUANTITIES['inverse_dynamics'], True)
    targets = [f'out{i}' for i in range(7)]
    once = {name for name, _ in assignments(program, targets)}
    reused = {name for name, _ in assignments(program, targets, reuse=True)}
    assert len(reused) < 0.6 * len(once)


def _values(program, inputs):
    """Yield each output, node by node."""
    values = []
    for operator, left, right in program.nodes:
        if operator == 'input':
            values.append(inputs[left])
        elif operator == 'number':
            values.append(left)
        else:
            a, b = values[left], values[right]
            values.append({'+': a + b, '-': a - b, '*': a * b,
                           '/': a / b if operator == '/' else None}[operator])
    for sign, n in program.outputs:
        yield sign * values[n]
