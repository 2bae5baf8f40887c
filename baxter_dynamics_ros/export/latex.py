"""Export as an article in LaTeX: G and the diagonal of M, with their definitions."""

from collections.abc import Iterable, Iterator
import re

import numpy as np

from .common import bodies, head, names, parameters
from ..model.arm import BaxterArm
from ..model.joints import JOINTS, N_JOINTS

_ESCAPES = str.maketrans({
    **{character: f'\\{character}' for character in '#$%&_{}'}, '^': r'\textasciicircum{}',
    '~': r'\textasciitilde{}', '<': r'\textless{}', '>': r'\textgreater{}', '|': r'\textbar{}',
    '"': "''", '`': ''})
# Names with another letter in LaTeX.
_LETTERS = {'izz': ('I', 'zz'), 'up': ('u', ''), 'hx': ('h', 'x'), 'hy': ('h', 'y'),
            **{element: ('J', element) for element in ('xx', 'yy', 'xy', 'xz', 'yz')}}
_QUARTER = r' + \pi/2'
_BLOCKS = 3  # of the table of parameters, side by side

_Formulas = dict[str, str]  # symbol in LaTeX -> expression in Python

_START = r"""\documentclass[11pt,a4paper]{article}
\usepackage[margin=22mm]{geometry}
\usepackage{amsmath,multicol}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
% A formula as a paragraph, which TeX may break after a sign.
\newcommand{\where}[2]{{\parskip=2pt\raggedright\hangindent=3em\hangafter=1
  \binoppenalty=100 \relpenalty=10000 $#1 = #2$\par}}
\begin{document}
\begin{center}\Large Closed-form dynamics of a Baxter arm\end{center}
{\footnotesize <about>\par}

\section{Conventions}
Joints are numbered in the order <joints>. $q$ is in rad, $G$ in N\,m and $M$ in kg\,m$^2$. The
Denavit--Hartenberg constants of link $i$ are:
\begin{center}
\begin{tabular}{ccrrrr}
\hline
$i$ & joint & $\theta_i$ [rad] & $d_i$ [m] & $a_i$ [m] & $\alpha_i$ [deg] \\
\hline
<links>
\hline
\end{tabular}
\end{center}

Formulas are in $s_i = \sin q_i$ and $c_i = \cos q_i$. Body frame $k$ has the axis of joint $k$ as
its $z$ axis and the origin of the Denavit--Hartenberg frame $\{k-1\}$, and turns with link $k$.
In it, $J_{xxk}$ to $J_{yzk}$ are the second and $h_{xk}$ and $h_{yk}$ the first moments of mass of
link $k$: $\int x^2\,dm$ to $\int yz\,dm$, $\int x\,dm$ and $\int y\,dm$. They are base parameters:
a mass on the axis of a joint is counted to the link before it. $I_{zz1}$ is the moment of inertia
of link 1 about its joint. In frame $\{0\}$ the gravity vector is $(-u_x, -u_y, -u_z)$.

\section{Parameters}
"""


def files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported file: its name -> its text."""
    definitions, gravity, diagonal = _formulas()
    used = names([*definitions.values(), *gravity.values(), *diagonal.values()])
    about = head(arm, command)
    start = (_START.replace('<about>', ' '.join(about).translate(_ESCAPES))
             .replace('<joints>', ', '.join(JOINTS)).replace('<links>', '\n'.join(_links(arm))))
    return {'baxter_dynamics.tex': '\n'.join([
        f'% {about[0]}', start, *_parameter_table(arm, used),
        '\\begin{multicols}{2}', '\\section{Definitions}', *_lines(definitions),
        '\\section{Gravity torques}', *_lines(gravity),
        '\\section{Diagonal of the mass matrix}', *_lines(diagonal),
        '\\end{multicols}', '\\end{document}\n'])}


def _formulas() -> tuple[_Formulas, _Formulas, _Formulas]:
    """
    Return the definitions, and G and the diagonal of M in terms of them.

    The generated function reuses names; here each definition has a name of its own.
    """
    statements, results = bodies()['terms']
    current: dict[str, str] = {}
    unique: _Formulas = {}
    for target, value in statements:
        name = f'_t{len(unique)}'
        unique[name] = _renamed(value, current)
        current[target] = name
    wanted = [_renamed(value, current) for value in
              (*results[-N_JOINTS:], *results[:N_JOINTS ** 2:N_JOINTS + 1])]
    needed = _words(wanted)
    for name in reversed(unique):
        if name in needed:
            needed |= _words([unique[name]])
    kept = [name for name in unique if name in needed]
    numbers = {name: f't{i}' for i, name in enumerate(kept, 1)}
    wanted = [_renamed(value, numbers) for value in wanted]
    return ({symbol(number): _renamed(unique[name], numbers) for name, number in numbers.items()},
            {f'G_{{{i}}}': value for i, value in enumerate(wanted[:N_JOINTS], 1)},
            {f'M_{{{i}{i}}}': value for i, value in enumerate(wanted[N_JOINTS:], 1)})


def _words(values: Iterable[str]) -> set[str]:
    return set(re.findall(r'\w+', ' '.join(values)))


def _renamed(value: str, new: dict[str, str]) -> str:
    return re.sub(r'\w+', lambda word: new.get(word[0], word[0]), value)


def _lines(formulas: _Formulas) -> Iterator[str]:
    for target, value in formulas.items():
        value = re.sub(r'\((\w+) \+ \1\)', r'2 * \1', value)
        value = re.sub(r'[a-z]\w*', lambda word: symbol(word[0]), value).replace(' * ', r'\,')
        yield f'\\where{{{target}}}{{{value}}}'


def symbol(name: str) -> str:
    """Return a name such as t12, s3, xx7 or up_z in LaTeX: a letter and its index."""
    word, index = re.fullmatch('([a-z]+)_?([0-9]+|[xyz])', name).groups()  # type: ignore
    letter, element = _LETTERS.get(word, (word, ''))
    return f'{letter}_{{{element}{index}}}'


def _links(arm: BaxterArm) -> list[str]:
    p = arm.parameters
    return [f'{i + 1} & {joint} & $q_{i + 1}{_QUARTER if p.theta_offset[i] else ""}$ & '
            f'${p.d[i]:g}$ & ${p.a[i]:g}$ & ${np.degrees(p.alpha[i]):.4g}$ \\\\'
            for i, joint in enumerate(JOINTS)]


def _parameter_table(arm: BaxterArm, used: set[str]) -> list[str]:
    """Return the parameters with value and unit, in columns that are read downwards."""
    cells = [f'${symbol(p.name)}$ & ${_number(p.value)}$ & {p.unit.replace("^2", "$^2$")}'
             for p in parameters(arm) if p.name in used]
    height = -(-len(cells) // _BLOCKS)
    cells += [' & & '] * (_BLOCKS * height - len(cells))
    return [r'\begin{center}\footnotesize\setlength{\tabcolsep}{3pt}',
            r'\begin{tabular}{%s}' % r'@{\qquad}'.join(['lll'] * _BLOCKS), r'\hline',
            ' & '.join(['symbol & value & unit'] * _BLOCKS) + r' \\', r'\hline',
            *(' & '.join(cells[i::height]) + r' \\' for i in range(height)), r'\hline',
            r'\end{tabular}', r'\end{center}']


def _number(value: float) -> str:
    digits, _, exponent = f'{value:.8g}'.partition('e')
    return digits + (rf' \cdot 10^{{{int(exponent)}}}' if exponent else '')
