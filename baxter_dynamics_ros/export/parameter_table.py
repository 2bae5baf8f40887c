"""An arm's parameters with name, value, unit and meaning; the base parameters as a table."""

import re
from textwrap import fill
from typing import NamedTuple

from ..model import BaxterArm, JOINTS
from ..model._closed_form import PARAMETERS
from ..model.base_parameters import TILTED_NAMES

FRAMES = (
    "Body frame k has the axis of joint k as its z axis and the origin of the paper's (Denavit-"
    'Hartenberg) frame {k-1}, and turns with link k. Inertial parameters are base parameters: a '
    'mass on the axis of a joint is assigned to the link before it. In this order they are the '
    "regressor's columns.")
# Pattern of a parameter's name, unit, meaning; the first that matches.
_MEANINGS = (
    ('izz1', 'kg m^2', 'moment of inertia of link 1 about its joint'),
    (r'h([xy])(\d)', 'kg m', r'first moment of mass \1 of link \2, body frame \2'),
    (r'([xy])([yxz])(\d)', 'kg m^2', r'second moment of mass \1 \2 of link \3, body frame \3'),
    (r'([ad])(\d)', 'm', r'Denavit-Hartenberg \1 of link \2'),
    (r'up_(.)', 'm/s^2', r"minus the gravity vector, \1 in the paper's frame {0}"),
    ('sin_alpha7', '1', 'sine of Denavit-Hartenberg alpha of link 7'),
    ('cos_alpha7', '1', 'cosine of Denavit-Hartenberg alpha of link 7'),
    (r'mount(\d)(4)', 'm', r"pose of the paper's frame {0} in the base frame, row \1, column \2"),
    (r'mount(\d)(\d)', '1', r"pose of the paper's frame {0} in the base frame, row \1, column \2"),
)
_TABLE_HEAD = (
    'The {count} base parameters phi: the combinations of the 70 inertial parameters of seven '
    'links that determine the torques, tau = Y(q, qd, qdd) phi.', FRAMES,
    'XXk, XYk, HXk, ...: sums of m x x, m x y, m x of link k alone about the origin of body frame '
    'k; link 7 with the payload. Mk: mass of links k to 7. a, d: Denavit-Hartenberg lengths.')
# Element of a base parameter -> its meaning in the table.
_TABLE_MEANINGS = {
    'izz': 'moment of inertia about the axis of {joint}', 'xx': 'spread of mass along x',
    'yy': 'spread of mass along y', 'xy': 'product of inertia x y', 'xz': 'product of inertia x z',
    'yz': 'product of inertia y z', 'hx': 'mass times offset along x',
    'hy': 'mass times offset along y'}
# Element of link k -> its sum, where j is k + 1 and l is k + 2. Of links with even k, a and d are
# zero.
_SUMS_ODD = {
    'izz': 'XX1 + YY1 + a1^2 M2 + ZZ2', 'xx': 'XX{k} + a{k}^2 M{j}', 'yy': 'YY{k} + ZZ{j}',
    'xy': 'XY{k} + a{k} HZ{j}', 'xz': 'XZ{k} + a{k} d{k} M{j}', 'yz': 'YZ{k} + d{k} HZ{j}',
    'hx': 'HX{k} + a{k} M{j}', 'hy': 'HY{k} + HZ{j}'}
_SUMS_EVEN = {'yy': 'YY{k} + ZZ{j} + d{j}^2 M{l}', 'hy': 'HY{k} - HZ{j} - d{j} M{l}'}


class NamedParameter(NamedTuple):
    """One parameter of the arm."""

    name: str  # as in _closed_form.PARAMETERS
    value: float
    unit: str
    text: str


def parameters(arm: BaxterArm) -> list[NamedParameter]:
    """Return the parameters of an arm in the order of ``_closed_form.PARAMETERS``."""
    return [NamedParameter(name, value, *meaning(name))
            for name, value in zip(PARAMETERS, arm.closed_form_parameters)]


def meaning(name: str) -> tuple[str, str]:
    """Return the unit and the meaning of a parameter."""
    return next((unit, found.expand(text)) for pattern, unit, text in _MEANINGS
                if (found := re.fullmatch(pattern, name)))


def base_table(arm: BaxterArm) -> str:
    """Return the base parameters of an arm, 43, or 45 where its base is tilted, as text."""
    values = arm.base_parameters.tolist()
    lines = [fill(text.replace('{count}', str(len(values))), 99) for text in _TABLE_HEAD]
    before = ''
    for name, value in zip(TILTED_NAMES, values):
        element, link, joint = name[:-1], name[-1], JOINTS[int(name[-1]) - 1]
        if link != before:
            lines.append(f'\nlink {link}, turned by {joint}')
            before = link
        lines.append(f'{name:<5}{value:>14.7g} {meaning(name)[0]:<7} = {composition(name):<25} '
                     + _TABLE_MEANINGS[element].format(joint=joint))
    return '\n'.join(lines)


def composition(name: str) -> str:
    """Return the sum that makes up a base parameter, in the notation of the table."""
    element, k = name[:-1], int(name[-1])
    sums = _SUMS_ODD if k % 2 else _SUMS_EVEN
    text = sums.get(element, f'{element.upper()}{{k}}').format(k=k, j=k + 1, l=k + 2)
    return re.sub(r' [+-] [^+-]*8', '', text)  # there is no link 8
