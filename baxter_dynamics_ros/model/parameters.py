"""
Link parameters: the paper's tables, with two errors of the printed model corrected.

Without corrections the torque of s1 is wrong by 40 N m RMS. Each can be omitted to see its effect:

* :data:`THETA_2_OFFSET`: Table II omits the constant pi/2 of theta_2.
* :data:`INERTIA_AT_ORIGIN`: eq. (12) needs inertias about the origin of the link frame, but
  Table III lists them about the centre of mass.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from . import paper_tables
from .arrays import Array, ArrayLike, finite, read_only
from .exceptions import ArgumentError
from .joints import N_JOINTS, S1
from .setting import Group, setting

THETA_2_OFFSET = 'theta_2_offset'
INERTIA_AT_ORIGIN = 'inertia_at_origin'
CORRECTIONS = frozenset({THETA_2_OFFSET, INERTIA_AT_ORIGIN})
THETA_OFFSET = np.pi / 2 * (np.arange(N_JOINTS) == S1)  # theta - q, corrected [rad]


@dataclass(frozen=True, eq=False)
class ArmParameters:
    """
    Kinematic and inertial parameters of the seven links, in the paper's D-H frames.

    Arrays are read-only copies; row i is link i + 1 of the paper. ``theta_offset`` and
    ``pseudo_inertia`` are derived, with the ``corrections`` applied. ArgumentError is raised if an
    array has the wrong shape or is not finite, or a correction is unknown.
    """

    d: Array  # (7,) link offset [m]
    a: Array  # (7,) link length [m]
    alpha: Array  # (7,) link twist [rad]
    mass: Array  # (7,) [kg]
    center_of_mass: Array  # (7, 3) in the link frame [m]
    inertia: Array  # (7, 3, 3) about the centre of mass, axes of the link frame [kg m^2]
    corrections: Collection[str] = CORRECTIONS
    theta_offset: Array = field(init=False)  # (7,) theta_i = q_i + theta_offset_i [rad]
    pseudo_inertia: Array = field(init=False)  # (7, 4, 4) J_i, eq. (12) [kg m^2, kg m, kg]

    def __post_init__(self) -> None:
        """Validate the arguments and derive theta_offset and pseudo_inertia."""
        n = N_JOINTS
        for name, shape in (('d', (n,)), ('a', (n,)), ('alpha', (n,)), ('mass', (n,)),
                            ('center_of_mass', (n, 3)), ('inertia', (n, 3, 3))):
            self._set(name, finite(name, getattr(self, name), shape).copy())
        unknown = set(self.corrections) - CORRECTIONS
        if unknown:
            raise ArgumentError('corrections', f'unknown {sorted(unknown)}; '
                                f'expected some of {sorted(CORRECTIONS)}')
        self._set('theta_offset', THETA_OFFSET * (THETA_2_OFFSET in self.corrections))
        self._set('pseudo_inertia', pseudo_inertia(
            self.inertia, self.mass, self.center_of_mass, INERTIA_AT_ORIGIN in self.corrections))

    __reduce__ = Group.__reduce__

    def _set(self, name: str, array: Array) -> None:
        object.__setattr__(self, name, read_only(array))


@dataclass(frozen=True)
class Payload(Group, prefix='payload.'):
    """
    A rigid body fixed to the hand, such as the electric gripper; none by default.

    Off-diagonal inertias are elements of the tensor, as in Table III; all are zero for a point
    mass. ArgumentError is raised if no rigid body has these values: a negative mass or
    principal moment, principal moments that violate the triangle inequality, or inertia
    without mass.
    """

    mass: float = setting(0.0, 'Mass of the payload.', 'kg', 0.0, 10.0)
    center_of_mass: Sequence[float] = setting(
        (0.0,) * 3, 'Centre of mass of the payload in the hand frame.', 'm', -1.0, 1.0)
    inertia: Sequence[float] = setting(
        (0.0,) * 6, 'Inertia xx, yy, zz, xy, yz, xz of the payload about its centre of mass, axes '
        'of the hand frame.', 'kg m^2', -2.0, 2.0)

    def __post_init__(self) -> None:
        """Validate each value, and values together."""
        super().__post_init__()
        moments = np.linalg.eigvalsh(self.inertia_tensor)
        if moments[0] < -1e-12 or moments[0] + moments[1] < moments[2] * (1 - 1e-9) - 1e-12:
            raise ArgumentError(
                'payload.inertia', 'expected the inertia of a rigid body (principal moments not '
                f'negative, none above the sum of the others), got moments {moments} kg m^2')
        if self.mass == 0.0 and moments[2] > 0.0:
            raise ArgumentError('payload.inertia', 'expected zero where payload.mass is zero')

    @property
    def inertia_tensor(self) -> Array:
        """Inertia about the centre of mass, (3, 3) [kg m^2]."""
        return inertia_tensor(np.array(self.inertia))

    @property
    def pseudo_inertia(self) -> Array:
        """Pseudo-inertia about the hand frame's origin, (4, 4), eq. (12)."""
        return pseudo_inertia(self.inertia_tensor, self.mass, np.array(self.center_of_mass))


@dataclass(frozen=True)
class LinkSettings(Group, prefix='links.'):
    """Inertial parameters of the links, those of the paper by default."""

    mass: ArrayLike = setting(
        tuple(row[-1] for row in paper_tables.TABLE_II), 'Mass of each link (Table II).', 'kg',
        0.0, 20.0)
    center_of_mass: ArrayLike = setting(
        sum(paper_tables.TABLE_IV, ()), 'Centre of mass x, y, z of each link in turn, in the link '
        'frame (Table IV).', 'm', -1.0, 1.0)
    inertia: ArrayLike = setting(
        sum(paper_tables.TABLE_III, ()), 'Inertia xx, yy, zz, xy, yz, xz of each link in turn, '
        'about its centre of mass (Table III).', 'kg m^2', -2.0, 2.0)

    def arm_parameters(self) -> ArmParameters:
        """Return parameters with Table II's kinematics; raise if no rigid body has these."""
        d, a, alpha, _ = np.array(paper_tables.TABLE_II).T
        result = ArmParameters(
            d, a, alpha, np.array(self.mass), np.reshape(self.center_of_mass, (N_JOINTS, 3)),
            inertia_tensor(np.reshape(self.inertia, (N_JOINTS, 6))))
        for i, least in enumerate(np.linalg.eigvalsh(result.pseudo_inertia)[:, 0]):
            if least <= 0.0:
                raise ArgumentError(
                    'links', 'no rigid body has the mass, centre of mass and inertia of link '
                    f'{i + 1}: mass and principal moments must be positive, and no moment above '
                    'the sum of the other two')
        return result


def link_parameters(mass: ArrayLike, center_of_mass: ArrayLike,
                    inertia: ArrayLike) -> ArmParameters:
    """
    Return parameters with Table II's kinematics and custom inertial parameters.

    Masses (7,) [kg], centres of mass (21,) [m] and inertias (42,) [kg m^2] are in the order and
    the frames of Tables II to IV, link by link. ArgumentError is raised if no rigid body has them.
    """
    return LinkSettings(mass, center_of_mass, inertia).arm_parameters()


def paper_parameters(corrections: Collection[str] = CORRECTIONS) -> ArmParameters:
    """Return the parameters of Tables II to IV, with the given corrections (default: all)."""
    return replace(LinkSettings().arm_parameters(), corrections=corrections)


def inertia_tensor(elements: Array) -> Array:
    """Turn rows (..., 6) in Table III's order xx yy zz xy yz xz into tensors (..., 3, 3)."""
    return elements[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


def pseudo_inertia(inertia: Array, mass: ArrayLike, center: Array,
                   at_origin: bool = True) -> Array:
    """
    Return J of eq. (12), (..., 4, 4), of inertias (..., 3, 3) about the centre of mass.

    The inertia is first moved to the origin of the link frame (parallel axes), the correction
    that Table III needs: ``I_origin = I_com + m (r.r 1 - r r^T)``. The 3 x 3 block of J is
    tr(I_origin)/2 1 - I_origin, so its off-diagonals are -I_xy and so on. Masses are (...) [kg],
    centres of mass (..., 3) [m].

    If not ``at_origin``, J is as eq. (12) prints it: Table III as it stands, off-diagonals +I_xy
    and so on. M differs by up to 0.13 kg m^2, and J is not positive definite.
    """
    mass = np.asarray(mass)
    result = np.empty(inertia.shape[:-2] + (4, 4))
    if at_origin:
        outer = center[..., :, None] * center[..., None, :]
        inertia = inertia + mass[..., None, None] * (_trace(outer) - outer)
        result[..., :3, :3] = _trace(inertia) / 2 - inertia
    else:
        result[..., :3, :3] = _trace(inertia) / 2 + inertia - 2 * np.eye(3) * inertia
    result[..., :3, 3] = result[..., 3, :3] = mass[..., None] * center
    result[..., 3, 3] = mass
    return result


def from_pseudo_inertia(pseudo: Array) -> tuple[Array, Array, Array]:
    """Return mass (...), centre of mass (..., 3) and inertia about it (..., 3, 3) of J."""
    mass = pseudo[..., 3, 3]
    center = pseudo[..., :3, 3] / mass[..., None]
    about_center = pseudo[..., :3, :3] - mass[..., None, None] * (
        center[..., :, None] * center[..., None, :])
    return mass, center, _trace(about_center) - about_center


def inertia_elements(tensor: Array) -> Array:
    """Turn tensors (..., 3, 3) into rows (..., 6) in Table III's order xx yy zz xy yz xz."""
    return tensor[..., (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]


def _trace(matrix: Array) -> Array:
    """Return tr(X) 1, (..., 3, 3)."""
    return np.trace(matrix, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
