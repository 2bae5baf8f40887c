"""The committed files and the documented operation counts are what the generator gives."""

from pathlib import Path

from baxter_dynamics_ros.model import _closed_form
import numpy as np
import pytest

pytest.importorskip('casadi', reason='needed to generate: pip install casadi')
from tools.closed_form.__main__ import generated  # noqa: E402, I100
from tools.closed_form.derivation import program_of  # noqa: E402
from tools.closed_form.quantities import Arm, PARAMETERS, QUANTITIES  # noqa: E402
from tools.closed_form.sizes import table  # noqa: E402


@pytest.mark.parametrize('quantity', QUANTITIES.values(), ids=QUANTITIES)
def test_each_function_computes_the_formulation(quantity, rng):
    parameters = rng.normal(size=len(PARAMETERS))
    parameters[PARAMETERS.index('izz1')] += 1e3  # for qdd: M is regular
    angles, *rest = rng.normal(size=(1 + len(quantity.inputs), 7))
    result = getattr(_closed_form, quantity.name)(np.sin(angles), np.cos(angles), *rest,
                                                  parameters)
    arm = Arm(np.sin(angles), np.cos(angles), dict(zip(PARAMETERS, parameters)))
    expected = quantity.compute(arm, *rest)
    expected = expected if isinstance(expected, tuple) else (expected,)
    expected = np.concatenate([np.ravel(part) for part in expected])
    np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-9)


def test_generated_files_are_up_to_date():
    for path, text in generated().items():
        assert path.read_text(encoding='utf-8') == text, (
            f'{path.name} is out of date: run python -m tools.closed_form')


def test_documented_table_is_up_to_date():
    text = (Path(__file__).parents[2] / 'docs' / 'closed_form.md').read_text(encoding='utf-8')
    assert table() + '\n' in text
    tau, terms = (program_of(QUANTITIES[name], tilted=True).operations()
                  for name in ('inverse_dynamics', 'terms'))
    assert f'has {tau} and M, C, G {terms:,}. ' in text
