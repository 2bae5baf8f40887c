"""LaTeX: G and the diagonal of M to print, with their definitions and the arm's numbers."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from .body import NAMES
from .functions import COMMAND, Function
from .legend import arm_paragraphs, parameters, RIGID
from .notation import formula, symbol
from ..closed_form.derivation import program_of
from ..closed_form.formulation import Formulation
from ..closed_form.frames import Scalar
from ..closed_form.quantities import Quantity
from ..closed_form.source import assignments
from ..model.arm import BaxterArm
from ..model.exceptions import ArgumentError
from ..model.joints import JOINTS

_DIGITS = 8  # of the parameters' values
_ESCAPES = {**{character: f'\\{character}' for character in '#$%&_{}'},
            '^': r'\textasciicircum{}', '~': r'\textasciitilde{}', '<': r'\textless{}',
            '>': r'\textgreater{}', '|': r'\textbar{}', '"': r'\textquotedbl{}'}
_BLOCKS = 3  # of the table of parameters, side by side


_SYMBOLS = ('M', 'G', 'MCG')  # by the names of export: what asks for something that is printed


class _Printed(NamedTuple):
    """Something to print."""

    title: str
    symbol: str  # of element i, from 1
    compute: Callable[[Formulation], list[Scalar]]  # its elements
    wanted_by: set[str]  # names of quantities


_PRINTED = (
    _Printed('Gravity torques', 'G_{{{0}}}', Formulation.gravity,
             {'gravity', 'terms', 'torque_terms'}),
    _Printed('Diagonal of the mass matrix', 'M_{{{0}{0}}}',
             lambda formulation: [row[i] for i, row in enumerate(formulation.mass_matrix())],
             {'mass_matrix', 'terms', 'torque_terms'}),
)

# The way to another payload takes the other files a table's worth of text.
_OTHER = 'Another payload or other links change the parameters alone: export again.'
_START = r"""\documentclass[11pt,a4paper]{article}
\usepackage[margin=22mm]{geometry}
\usepackage{amsmath}
\usepackage{multicol}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
% A formula, set as a paragraph, so that TeX breaks it after a sign.
\newcommand{\where}[2]{{\parskip=2pt\raggedright\hangindent=3em\hangafter=1
  \binoppenalty=100 \relpenalty=10000 $#1 = #2$\par}}
\begin{document}

\begin{center}
\Large Closed-form dynamics of a Baxter arm
\end{center}

The Lagrange--Euler dynamics of one arm are
\[ \tau = M(q)\,\ddot q + C(q,\dot q)\,\dot q + G(q), \]
here with the paper's two corrections. This is the printable part, written by
\texttt{<command>}: definitions, each in terms of those before, and what follows.

{\footnotesize <arm> Here up\_z stands for $u_z$, and so on.\par}

\section{Conventions}

Joints are numbered in the order <joints>. $q$ is in rad, $G$ in N\,m and $M$ in kg\,m$^2$; $\tau$
is positive in the direction of positive $q$. The Denavit--Hartenberg constants of link $i$ are:

\begin{center}
\begin{tabular}{ccrrrr}
\hline
$i$ & joint & $\theta_i$ [rad] & $d_i$ [m] & $a_i$ [m] & $\alpha_i$ [deg] \\
\hline
<links>
\hline
\end{tabular}
\end{center}

Formulas are in $s_i = \sin q_i$ and $c_i = \cos q_i$, of $q_i$ and not of $\theta_i$. Body frame
$k$ has the axis of joint $k$ as its $z$ axis and the origin of the Denavit--Hartenberg frame
$\{k-1\}$, and turns with link $k$; at $q = 0$ its $x$ axis is that of frame $\{k-1\}$, turned by
$\theta_k - q_k$. In it, $J_{xxk}$ to $J_{yzk}$ are the second and $h_{xk}$ and $h_{yk}$ the first
moments of mass of link $k$: $\int x^2\,dm$ to $\int yz\,dm$, and $\int x\,dm$ and $\int y\,dm$.
They are base parameters, all that torques can tell of the links: what lies on the own axis of a
joint is counted to the link before it. $I_{zz1}$ is the moment of inertia of link 1 about its
joint. <up>

\section{Parameters}

"""
_NOTHING = 'LaTeX prints G and the diagonal of M, and nothing else; name G, M or MCG'
_UPRIGHT = 'In frame $\\{0\\}$ the gravity vector is $(0, 0, -u_z)$.'
_TILTED = 'In frame $\\{0\\}$ the gravity vector is $(-u_x, -u_y, -u_z)$.'


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write an article with the formulas of G and of the diagonal of M.

    Parameters
    ----------
    functions : list of Function
        G is printed if one of them gives it, and so is the diagonal of M; nothing else is.
    arm : BaxterArm
        Whose numbers are listed.
    name : str, optional
        The file's name.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name.tex``.

    Raises
    ------
    ArgumentError
        If none of the functions gives G or M.

    """
    sections = printed(function.quantity.name for function in functions)
    if not sections:
        raise ArgumentError('quantities', _NOTHING)
    return {f'{name}.tex': '\n'.join([
        _introduction(arm, command), _parameter_table(arm), *_formulas(sections, arm),
        '\n\\end{document}\n'])}


def printable(symbols: Sequence[str]) -> list[str]:
    """
    Return those of the symbols of an export of which something can be printed.

    Raises
    ------
    ArgumentError
        If there is none.

    """
    result = [symbol for symbol in symbols if symbol in _SYMBOLS]
    if not result:
        raise ArgumentError('quantities', _NOTHING)
    return result


def printed(quantities: Iterable[str]) -> list[_Printed]:
    """Return what is printed for quantities, by name: G, the diagonal of M, or both."""
    names = set(quantities)
    return [each for each in _PRINTED if each.wanted_by & names]


def _introduction(arm: BaxterArm, command: str) -> str:
    p = arm.parameters
    links = []
    for i, joint in enumerate(JOINTS):
        theta = f'q_{i + 1}' + (r' + \pi/2' if p.theta_offset[i] else '')
        alpha = f'{np.degrees(p.alpha[i]):.4g}'
        links.append(f'{i + 1} & {joint} & ${theta}$ & ${p.d[i]:g}$ & ${p.a[i]:g}$ & '
                     f'${alpha}$ \\\\')
    result = _START
    about = ' '.join((RIGID, *arm_paragraphs(arm, _OTHER)))
    for field, text in (('arm', _escaped(about)),
                        ('command', _escaped(command.replace('`', ''))),
                        ('joints', ', '.join(JOINTS)),
                        ('links', '\n'.join(links)),
                        ('up', _UPRIGHT if arm.dynamics.upright else _TILTED)):
        result = result.replace(f'<{field}>', text)
    return result


def _escaped(text: str) -> str:
    return ''.join(_ESCAPES.get(character, character) for character in text)


def _parameter_table(arm: BaxterArm) -> str:
    """Return all parameters with value and unit, in columns that are read downwards."""
    cells = [f'${symbol(p.name)}$ & ${_number(p.value)}$ & {p.unit.replace("^2", "$^2$")}'
             for p in parameters(arm)]
    height = -(-len(cells) // _BLOCKS)
    cells += [' & & '] * (_BLOCKS * height - len(cells))
    rows = [' & '.join(cells[i::height]) + r' \\' for i in range(height)]
    titles = ' & '.join(['symbol & value & unit'] * _BLOCKS) + r' \\'
    columns = r'@{\qquad}'.join(['lll'] * _BLOCKS)
    return '\n'.join([r'\begin{center}\footnotesize\setlength{\tabcolsep}{3pt}',
                      r'\renewcommand{\arraystretch}{1.15}', rf'\begin{{tabular}}{{{columns}}}',
                      r'\hline', titles, r'\hline', *rows, r'\hline', r'\end{tabular}',
                      r'\end{center}'])


def _number(value: float) -> str:
    digits, _, exponent = f'{value:.{_DIGITS}g}'.partition('e')
    sign = '' if value < 0 else r'\phantom{-}'
    return sign + digits + (rf' \cdot 10^{{{int(exponent)}}}' if exponent else '')


def _formulas(printed: list[_Printed], arm: BaxterArm) -> list[str]:
    """Return the sections of the definitions, and of each of what is printed."""
    # Derived together, they share definitions.
    quantity = Quantity('printed', (), (), lambda formulation: [
        each.compute(formulation) for each in printed])
    targets = [each.symbol.format(i + 1) for each in printed for i in range(len(JOINTS))]
    program = program_of(quantity, not arm.dynamics.upright)
    lines = {target: rf'\where{{{target if target in targets else symbol(target)}}}'
                     f'{{{formula(text)}}}'
             for target, text in assignments(program, targets, NAMES)}
    result = ['\n\\begin{multicols}{2}\n\\section{Definitions}\n']
    result += [line for target, line in lines.items() if target not in targets]
    for each in printed:
        result.append(f'\n\\section{{{each.title}}}\n')
        result += [lines[each.symbol.format(i + 1)] for i in range(len(JOINTS))]
    return [*result, '\\end{multicols}']
