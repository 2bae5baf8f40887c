"""The printable formulas: computed as they are printed, and compiled."""

import re
import shutil
import subprocess

import numpy as np
import pytest

pytest.importorskip('casadi', reason='needed to derive: pip install casadi')
from baxter_dynamics_ros.export import latex  # noqa: E402, I100
from baxter_dynamics_ros.export.functions import constants  # noqa: E402
from baxter_dynamics_ros.export.legend import parameters  # noqa: E402
from baxter_dynamics_ros.model.exceptions import ArgumentError  # noqa: E402

# A symbol with its index -> the name of a parameter, as the conventions of the article tell.
NAMES = {'I_{zz1}': 'izz1', **{f'u_{{{axis}}}': f'up_{axis}' for axis in 'xyz'},
         **{f'h_{{{axis}{k}}}': f'h{axis}{k}' for axis in 'xy' for k in range(1, 8)},
         **{f'J_{{{xx}{k}}}': f'{xx}{k}' for xx in ('xx', 'yy', 'xy', 'xz', 'yz')
            for k in range(2, 8)},
         **{f'{length}_{{{k}}}': f'{length}{k}' for length in 'ad' for k in (1, 3, 5)}}


@pytest.fixture
def article(export):
    """Return a function that writes the article of an arm: its path."""
    return lambda arm, symbols=('M', 'C', 'G'): export('latex', arm, symbols)[
        'baxter_dynamics.tex']


def printed(text, values, q):
    """Return G and the diagonal of M, each (n, 7), as a reader would compute them."""
    known = {symbol: values[name] for symbol, name in NAMES.items() if name in values}
    for i in range(7):
        known[f's_{{{i + 1}}}'], known[f'c_{{{i + 1}}}'] = np.sin(q[:, i]), np.cos(q[:, i])
    for target, formula in re.findall(r'^\\where\{(\w_\{\w+\})\}\{(.*)\}$', text, re.MULTILINE):
        code = formula.replace(r'\,', '*').replace('[', '(').replace(']', ')')
        code = re.sub(r'[A-Za-z]_\{\w+\}', lambda match: f'known[{match[0]!r}]', code)
        known[target] = eval(code, {'known': known})
    n = len(q)
    return [np.stack([np.broadcast_to(known[symbol.format(i)], n) for i in range(1, 8)], -1)
            for symbol in ('G_{{{0}}}', 'M_{{{0}{0}}}')]


def test_the_formulas_are_the_specification(article, arm, states, specification):
    g, diagonal = printed(article(arm).read_text(), constants(arm), states['q'])
    truth = specification(arm)
    truth.check('gravity', g)
    np.testing.assert_allclose(diagonal, truth.mass_matrix.diagonal(axis1=1, axis2=2),
                               rtol=0.0, atol=1e-11)


def test_the_table_of_parameters(article, arm):
    text = article(arm).read_text()
    cells = re.findall(r'\$(\w_\{\w+\})\$ & \$([^$]+)\$ & ([^&\\]+?) (?:&|\\\\)', text)
    listed = {}
    for symbol, value, unit in cells:
        value = value.replace(r'\phantom{-}', '').replace(r' \cdot 10^', 'e').strip()
        listed[NAMES[symbol]] = float(re.sub('[{}]', '', value)), unit.replace('$^2$', '^2')
    assert set(listed) == {parameter.name for parameter in parameters(arm)}
    for parameter in parameters(arm):
        value, unit = listed[parameter.name]
        assert value == pytest.approx(parameter.value, rel=1e-7)
        assert unit == parameter.unit


def test_it_compiles_and_nothing_runs_over_the_margin(article, arm):
    if shutil.which('pdflatex') is None:
        pytest.skip('pdflatex is missing: apt install texlive-latex-base')
    path = article(arm)
    done = subprocess.run(['pdflatex', '-halt-on-error', '-interaction=nonstopmode', path.name],
                          cwd=path.parent, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stdout.decode(errors='replace')[-2000:]
    log = path.with_suffix('.log').read_text(errors='replace')
    assert 'Overfull' not in log
    assert 'Warning' not in log
    assert re.search(r'Output written on baxter_dynamics.pdf \([23] pages', log)
    assert path.with_suffix('.pdf').read_bytes().startswith(b'%PDF')


@pytest.mark.parametrize('symbols, present, absent', [
    (('G',), r'\where{G_{1}}', r'\where{M_'),
    (('M', 'tau'), r'\where{M_{11}}', r'\where{G_'),
])
def test_only_what_is_asked_for(article, arm, symbols, present, absent):
    text = article(arm, symbols).read_text()
    assert present in text
    assert absent not in text


def test_what_cannot_be_printed(functions, arm):
    with pytest.raises(ArgumentError, match='name G, M or MCG'):
        latex.files(functions(arm, ('tau', 'C')), arm)
