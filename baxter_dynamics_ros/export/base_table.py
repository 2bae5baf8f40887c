"""The base parameters as a table: name, value, unit, composition and meaning."""

from textwrap import fill

from .common import FRAMES
from ..model.arm import BaxterArm
from ..model.base_parameters import TILTED_NAMES
from ..model.joints import JOINTS, N_JOINTS

_HEAD = (
    'The {count} base parameters phi: the combinations of the 70 inertial parameters of seven '
    'links that torques determine, tau = Y(q, qd, qdd) phi.', FRAMES,
    'XXk, XYk, HXk, ...: sums of m x x, m x y, m x of link k alone about the origin of body frame '
    'k; link 7 with the payload. Mk: mass of links k to 7. a, d: Denavit-Hartenberg lengths.')
_MEANINGS = {
    'izz': 'moment of inertia about the axis of {joint}',
    'xx': 'spread of mass along x',
    'yy': 'spread of mass along y',
    'xy': 'product of inertia x y',
    'xz': 'product of inertia x z',
    'yz': 'product of inertia y z',
    'hx': 'mass times offset along x',
    'hy': 'mass times offset along y',
}


def base_table(arm: BaxterArm) -> str:
    """Return the base parameters of an arm, 43, or 45 where its base is tilted, as text."""
    values = arm.base_parameters.tolist()
    lines = [fill(text.replace('{count}', str(len(values))), 99) for text in _HEAD]
    before = ''
    for name, value in zip(TILTED_NAMES, values):
        element, link, joint = name[:-1], name[-1], JOINTS[int(name[-1]) - 1]
        if link != before:
            lines.append(f'\nlink {link}, turned by {joint}')
            before = link
        unit, meaning = 'kg m' if element[0] == 'h' else 'kg m^2', _MEANINGS[element]
        lines.append(f'{name:<5}{value:>14.7g} {unit:<7} = {composition(name):<25} '
                     + meaning.format(joint=joint))
    return '\n'.join(lines)


def composition(name: str) -> str:
    """Return what a base parameter is the sum of, in the notation of the table."""
    element, k = name[:-1], int(name[-1])
    own, beyond = f'{element.upper()}{k}', f'M{k + 1}'
    if element == 'izz':
        return ' + '.join(('XX1 + YY1', 'a1^2 M2', 'ZZ2'))
    if k == N_JOINTS:
        return own
    if element in ('yy', 'hy'):  # what lies on the axis of joint k + 1, which is along y of link k
        on_axis = [f'{own[0].replace("Y", "Z")}Z{k + 1}']
        if k % 2 == 0 and k + 1 < N_JOINTS:
            on_axis.append(f'd{k + 1}{"^2" if element == "yy" else ""} M{k + 2}')
        sign = ' - ' if element == 'hy' and k % 2 == 0 else ' + '
        return sign.join((own, *on_axis))
    if k % 2 == 0:  # a and d are zero
        return own
    more = {'xx': f'a{k}^2 {beyond}', 'xy': f'a{k} HZ{k + 1}', 'xz': f'a{k} d{k} {beyond}',
            'yz': f'd{k} HZ{k + 1}', 'hx': f'a{k} {beyond}'}
    return f'{own} + {more[element]}'
