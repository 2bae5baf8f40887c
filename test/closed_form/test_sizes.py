"""Operation counts of the closed form and of the paper's forms."""

from pathlib import Path

import pytest

pytest.importorskip('casadi', reason='needed to derive the closed form: pip install casadi')
from tools.closed_form import sizes  # noqa: E402, I100
from tools.closed_form.derivation import program_of  # noqa: E402
from tools.closed_form.quantities import QUANTITIES  # noqa: E402

# Additions and multiplications (and 7 divisions of qdd), where gravity is along the first axis,
# and where it may have any direction.
CEILINGS = {
    'terms': (1355, 1377),
    'mass_matrix': (347, 347),
    'coriolis_matrix': (1242, 1242),
    'gravity': (82, 107),
    'torque_terms': (956, 978),
    'coriolis_torque': (563, 563),
    'momentum_terms': (473, 498),
    'inverse_dynamics': (598, 610),
    'forward_dynamics': (1152, 1171),
    'christoffel_symbols': (1000, 1000),
    'regressor': (1107, 1115),
    'inverse_dynamics_gradient': (3146, 3204),
    'forward_kinematics': (192, 192),
    'jacobian': (240, 240),
}


@pytest.mark.parametrize('name', QUANTITIES)
def test_operations(name):
    for tilted, ceiling in enumerate(CEILINGS[name]):
        assert program_of(QUANTITIES[name], bool(tilted)).operations() <= ceiling


def test_documented_table_is_up_to_date():
    document = Path(__file__).parents[2] / 'docs' / 'closed_form.md'
    table = sizes.table()
    assert table + '\n' in document.read_text(encoding='utf-8')
    totals = [int(row.split('|')[4].replace(',', '')) for row in table.splitlines()[2:]]
    # The paper: "over half a million". G_1 is zero and counts as no term.
    assert totals[0] == 808_991
    assert totals[:4] == sorted(totals[:4], reverse=True) and totals[1] > 10 * totals[3]
