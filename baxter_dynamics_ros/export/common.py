"""Sources of all exports: the generated functions, an arm's parameters, explanations."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path
import re
from typing import NamedTuple

from ..model import _closed_form
from ..model.arm import BaxterArm
from ..model.base_parameters import TILTED_NAMES
from ..model.joints import JOINTS

PATH = Path(_closed_form.__file__)
# Begins the head of every exported file.
MARK = 'Written by baxter_dynamics export'
LABELS = {'q': 'joint positions [rad]', 'qd': 'joint velocities [rad/s]',
          'qdd': 'joint accelerations [rad/s^2]', 'tau': 'joint torques [N m]'}
FRAMES = (
    "Body frame k has the axis of joint k as its z axis and the origin of the paper's (Denavit-"
    'Hartenberg) frame {k-1}, and turns with link k. Inertial parameters are base parameters: a '
    'mass on the axis of a joint is counted to the link before it. In this order they are the '
    "regressor's columns.")


class NamedParameter(NamedTuple):
    """One parameter of the arm."""

    name: str  # as in _closed_form.PARAMETERS
    value: float
    unit: str
    text: str


def parameters(arm: BaxterArm) -> list[NamedParameter]:
    """Return the parameters of an arm in the order of ``_closed_form.PARAMETERS``."""
    return [NamedParameter(name, value, *meaning(name)) for name, value in
            zip(_closed_form.PARAMETERS, arm.closed_form_parameters)]


def head(arm: BaxterArm, command: str) -> list[str]:
    """Return the paragraphs that open a file, written by a command."""
    payload = arm.payload
    carried = (f'The parameters include a payload of {payload.mass:g} kg at '
               f'{list(payload.center_of_mass)} m in the hand frame.' if payload.mass
               else 'The hand is empty.')
    gravity = ', '.join(f'{x + 0.0:.6g}' for x in arm.gravity_vector)
    return [
        f'{MARK}: `{command}`.',
        'Closed-form rigid-body dynamics of a Baxter arm, tau = M(q) qdd + C(q, qd) qd + G(q), '
        'after "Lagrange-Euler Closed Dynamics Model of the Baxter Robot" with two errors of the '
        'printed model corrected.',
        f'Joint order: {", ".join(JOINTS)}. tau is positive in the direction of positive q. The '
        'effort that a real Baxter measures also includes the springs at s1, friction and bias.',
        f'{carried} The gravity vector is ({gravity}) m/s^2 in the base frame.']


def meaning(name: str) -> tuple[str, str]:
    """Return the unit and the meaning of a parameter."""
    if name == 'izz1':
        return 'kg m^2', 'moment of inertia of link 1 about its joint'
    if name.startswith('up_'):
        return 'm/s^2', f"minus the gravity vector, {name[-1]} in the paper's frame {{0}}"
    if name.startswith('mount'):
        row, column = name[-2], name[-1]
        return ('m' if column == '4' else '1',
                f"pose of the paper's frame {{0}} in the base frame, row {row}, column {column}")
    if name in TILTED_NAMES:
        element, link = name[:-1], name[-1]
        if element[0] == 'h':
            return 'kg m', f'first moment of mass {element[1]} of link {link}, body frame {link}'
        return 'kg m^2', (f'second moment of mass {element[0]} {element[1]} of link {link}, body '
                          f'frame {link}')
    if name.endswith('alpha7'):
        function = 'sine' if name[0] == 's' else 'cosine'
        return '1', f'{function} of Denavit-Hartenberg alpha of link 7'
    return 'm', f'Denavit-Hartenberg {name[0]} of link {name[1]}'


@cache
def bodies() -> dict[str, tuple[list[tuple[str, str]], list[str]]]:
    """
    Return statements and results of each generated function, after its inputs have names.

    A statement is a name, which may be reused, and its value; results are row by row, one after
    the other. Values are text.
    """
    result = {}
    for function in ast.parse(PATH.read_text(encoding='utf-8')).body:
        if isinstance(function, ast.FunctionDef):
            statements = [(statement.targets[0].id, ast.unparse(statement.value))
                          for statement in function.body if isinstance(statement, ast.Assign)
                          and isinstance(statement.targets[0], ast.Name)]
            returned = ast.unparse(function.body[-1]).removeprefix('return ')
            result[function.name] = statements, returned.strip('()').split(', ')
    return result


def names(expressions: Iterable[str]) -> set[str]:
    """Return the names that expressions read."""
    return set(re.findall(r'[a-z]\w*', ' '.join(expressions)))
