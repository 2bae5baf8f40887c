"""
Base parameters: the 43 combinations of link parameters that determine the torques.

In *body frame* k (z along the axis of joint k, origin of the paper's frame {k-1}, fixed to link k)
the pseudo-inertia J of link k has second moments xx ... zz [kg m^2], first moments hx, hy, hz
[kg m] and a mass. Rotation about the joint axis does not move mass on that axis, so zz, hz and the
mass can be added to link k - 1. Seven parameters remain for each of the links 2 to 7. The axis of
link 1 is fixed, so only its moment of inertia xx + yy remains, and hx and hy if gravity is not
along that axis.
"""

import numpy as np

from .arrays import Array
from .exceptions import ArgumentError
from .joints import N_JOINTS
from .parameters import ArmParameters

_LINKS = range(2, N_JOINTS + 1)
# Element of a link -> its place in J.
_ELEMENTS = {'xx': (0, 0), 'yy': (1, 1), 'xy': (0, 1), 'xz': (0, 2), 'yz': (1, 2), 'hx': (0, 3),
             'hy': (1, 3)}
# Order of the base parameters. izz1 is the moment of inertia of link 1, xx + yy of J.
NAMES = ('izz1', *(f'{element}{link}' for link in _LINKS for element in _ELEMENTS))
# Two more that matter only if gravity is not along the axis of joint 1.
TILTED_NAMES = (*NAMES, 'hx1', 'hy1')
# Lengths of Table II on which the dynamics depend.
LENGTH_NAMES = ('a1', 'a3', 'd3', 'a5', 'd5')

_ON_AXIS = np.zeros((4, 4), bool)
_ON_AXIS[2:, 2:] = True
_ALPHA = np.pi / 2 * np.array([-1, 1, -1, 1, -1, 1])  # links 1 to 6 [rad]


def base_parameters(parameters: ArmParameters, pseudo_inertia: Array) -> Array:
    """
    Return the base parameters (..., 45) in the order of :data:`TILTED_NAMES`.

    They are linear in ``pseudo_inertia`` (..., 7, 4, 4), J of eq. (12) for each link. Of
    ``parameters`` only d, a and alpha are read, which define the frames.
    """
    to_body = list(map(_link_frame, parameters.a, parameters.d, parameters.alpha))
    links = [to_body[k] @ pseudo_inertia[..., k, :, :] @ to_body[k].T for k in range(N_JOINTS)]
    for k in range(N_JOINTS - 1, 0, -1):
        on_axis = np.where(_ON_AXIS, links[k], 0.0)
        links[k - 1] = links[k - 1] + to_body[k - 1] @ on_axis @ to_body[k - 1].T
    result = [links[0][..., 0, 0] + links[0][..., 1, 1]]
    result += [link[(..., *place)] for link in links[1:] for place in _ELEMENTS.values()]
    return np.stack([*result, links[0][..., 0, 3], links[0][..., 1, 3]], -1)


def fixed_to_link(parameters: ArmParameters, link: int, pseudo_inertia: Array) -> Array:
    """Return the base parameters (..., 45) of bodies (..., 4, 4) fixed to a link (0 to 6)."""
    alone = np.zeros(pseudo_inertia.shape[:-2] + (N_JOINTS, 4, 4))
    alone[..., link, :, :] = pseudo_inertia
    return base_parameters(parameters, alone)


def lengths(parameters: ArmParameters) -> tuple[float, ...]:
    """Return the lengths of :data:`LENGTH_NAMES` [m]; raise if the structure is not Baxter's."""
    a, d, alpha = parameters.a, parameters.d, parameters.alpha
    if np.abs(alpha[:6] - _ALPHA).max() > 1e-12 or np.any(a[1:6:2]) or np.any(d[1:6:2]):
        raise ArgumentError(
            'parameters', "expected Baxter's kinematic structure, for which the closed form was "
            'derived (Table II: alpha of links 1 to 6 -90, 90, ... degrees; a and d of links 2, 4 '
            'and 6 zero); model.lagrange_euler computes any other arm')
    return tuple(float(x) for x in (a[0], a[2], d[2], a[4], d[4]))


def _link_frame(a: float, d: float, alpha: float) -> Array:
    """Return the pose of the paper's frame {k} in body frame k, exact for +-90 degrees."""
    s, c = np.sin(alpha), np.cos(alpha)
    if abs(c) < 1e-12:
        s, c = np.sign(s), 0.0
    return np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, d], [0, 0, 0, 1]])
