"""Export as an article in LaTeX: G and the diagonal of M, with their definitions."""

from pathlib import Path
import re

import numpy as np

from .parameter_table import parameters
from .sources import bodies, head, names
from ..model import BaxterArm, JOINTS, N_JOINTS

_TEMPLATE = Path(__file__).with_name('article.tex')
_ESCAPES = str.maketrans({
    **{character: f'\\{character}' for character in '#$%&_{}'}, '^': r'\textasciicircum{}',
    '~': r'\textasciitilde{}', '<': r'\textless{}', '>': r'\textgreater{}', '|': r'\textbar{}',
    '"': "''", '`': ''})
# Names with another letter in LaTeX.
_LETTERS = {'izz': ('I', 'zz'), 'up': ('u', ''), 'hx': ('h', 'x'), 'hy': ('h', 'y'),
            **{element: ('J', element) for element in ('xx', 'yy', 'xy', 'xz', 'yz')}}
_QUARTER = r' + \pi/2'
_BLOCKS = 3  # of the template's table of parameters, side by side

_Formulas = dict[str, str]  # symbol in LaTeX -> expression in Python


def files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported file: its name -> its text."""
    definitions, gravity, diagonal = _formulas()
    used = names([*definitions.values(), *gravity.values(), *diagonal.values()])
    written, *about = head(arm, command)
    values = {'written': written, 'about': ' '.join([written, *about]).translate(_ESCAPES),
              'joints': ', '.join(JOINTS), 'links': _links(arm),
              'parameters': _parameter_table(arm, used), 'definitions': _lines(definitions),
              'gravity': _lines(gravity), 'diagonal': _lines(diagonal)}
    return {'baxter_dynamics.tex': re.sub(r'<(\w+)>', lambda place: values[place[1]],
                                          _TEMPLATE.read_text(encoding='utf-8'))}


def _formulas() -> tuple[_Formulas, _Formulas, _Formulas]:
    """
    Return the definitions, and G and the diagonal of M in terms of them.

    The generated function reuses names and computes more; here each definition has its own name.
    """
    statements, results = bodies()['terms']
    wanted = [*results[-N_JOINTS:], *results[:N_JOINTS ** 2:N_JOINTS + 1]]
    needed, kept = names(wanted), []
    for target, value in reversed(statements):
        if target in needed:
            needed = needed - {target} | names([value])
            kept.append((target, value))
    definitions: _Formulas = {}
    current: dict[str, str] = {}
    for number, (target, value) in enumerate(reversed(kept), 1):
        definitions[f't_{{{number}}}'] = _renamed(value, current)
        current[target] = f't{number}'
    wanted = [_renamed(value, current) for value in wanted]
    return (definitions,
            {f'G_{{{i}}}': value for i, value in enumerate(wanted[:N_JOINTS], 1)},
            {f'M_{{{i}{i}}}': value for i, value in enumerate(wanted[N_JOINTS:], 1)})


def _renamed(value: str, new: dict[str, str]) -> str:
    return re.sub(r'\w+', lambda word: new.get(word[0], word[0]), value)


def _lines(formulas: _Formulas) -> str:
    lines = []
    for target, value in formulas.items():
        value = re.sub(r'\((\w+) \+ \1\)', r'2 * \1', value)
        value = re.sub(r'[a-z]\w*', lambda word: symbol(word[0]), value).replace(' * ', r'\,')
        lines.append(f'\\where{{{target}}}{{{value}}}')
    return '\n'.join(lines)


def symbol(name: str) -> str:
    """Return a name such as t12, s3, xx7 or up_z in LaTeX: a letter and its index."""
    word, index = re.fullmatch('([a-z]+)_?([0-9]+|[xyz])', name).groups()  # type: ignore
    letter, element = _LETTERS.get(word, (word, ''))
    return f'{letter}_{{{element}{index}}}'


def _links(arm: BaxterArm) -> str:
    p = arm.parameters
    return '\n'.join(
        f'{i + 1} & {joint} & $q_{i + 1}{_QUARTER if p.theta_offset[i] else ""}$ & '
        f'${p.d[i]:g}$ & ${p.a[i]:g}$ & ${np.degrees(p.alpha[i]):.4g}$ \\\\'
        for i, joint in enumerate(JOINTS))


def _parameter_table(arm: BaxterArm, used: set[str]) -> str:
    """Return the parameters with value and unit, in columns that are read downwards."""
    cells = [f'${symbol(p.name)}$ & ${_number(p.value)}$ & {p.unit.replace("^2", "$^2$")}'
             for p in parameters(arm) if p.name in used]
    height = -(-len(cells) // _BLOCKS)
    cells += [' & & '] * (_BLOCKS * height - len(cells))
    return '\n'.join(' & '.join(cells[i::height]) + r' \\' for i in range(height))


def _number(value: float) -> str:
    digits, _, exponent = f'{value:.8g}'.partition('e')
    return digits + (rf' \cdot 10^{{{int(exponent)}}}' if exponent else '')
