"""Terms shared by all joints: tilt of the base, link parameters, payload."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from .term import Fitted, Parameter, Sample, WORTH_OF_ALL
from ..model.arm import BaxterArm
from ..model.arrays import Array, Bools
from ..model.base_parameters import fixed_to_link
from ..model.joints import N_JOINTS
from ..model.parameters import from_pseudo_inertia, inertia_elements

# Standard deviations of the priors.
_TILT = 0.3  # horizontal gravity, corresponding to 1.75 degrees [m/s^2]
_LINK = 0.1  # relative: 10 % of the mass, 10 % of the radius of gyration for the centre of mass
_PAYLOAD_MASS = 3.0  # [kg]
_PAYLOAD_MOMENT = 0.5  # first moment [kg m]

REACH = 1.0  # bound on each coordinate of the payload's centre, unidentifiable at low mass [m]

# An orthonormal basis of the symmetric 4 x 4 matrices, (10, 4, 4).
_PAIRS = [(i, k) for i in range(4) for k in range(i, 4)]
_SYMMETRIC = np.zeros((len(_PAIRS), 4, 4))
for _n, (_i, _k) in enumerate(_PAIRS):
    _SYMMETRIC[_n, _i, _k] = _SYMMETRIC[_n, _k, _i] = 1.0 if _i == _k else np.sqrt(0.5)


class Tilt:
    """Tilt of the robot's base, as the horizontal components of gravity."""

    name = 'tilt'
    shared = True
    worth = WORTH_OF_ALL
    parameters: tuple[Parameter, ...] = (Parameter(_TILT), Parameter(_TILT))

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint: both."""
        return [0, 1]

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each component, (n, 2)."""
        return sample.horizontal_gravity[:, joint]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Rotate gravity, preserving its magnitude."""
        gravity = np.asarray(values['gravity'], dtype=float)
        x, y = gravity[:2] + deviation
        z = np.sqrt(gravity @ gravity - x * x - y * y)
        values['gravity'] = (float(x), float(y), float(np.copysign(z, gravity[2])))

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""
        for i, axis in enumerate('xy'):
            yield Fitted(self.name, None, axis, 'm/s^2', before['gravity'][i],
                         after['gravity'][i], float(np.sqrt(covariance[i, i])))


class Links:
    r"""
    Inertial parameters of the links, with a physically consistent prior.

    Pseudo-inertias are fitted as J = L (1 + S) L^T, where L L^T is the value in the settings, with
    a normal prior on the symmetric S. This is the second-order approximation of the coordinate-
    invariant distance of Lee, Wensing and Park (2020). J is physically consistent while 1 + S > 0.
    """

    name = 'inertial'
    shared = True
    worth = WORTH_OF_ALL

    def __init__(self, arm: BaxterArm) -> None:
        self._root = np.linalg.cholesky(arm.parameters.pseudo_inertia)
        self._units = self._root[:, None] @ _SYMMETRIC @ self._root.swapaxes(-1, -2)[:, None]
        self._base = np.stack([fixed_to_link(arm.parameters, link, units)
                               for link, units in enumerate(self._units)])  # (7, 10, 45)
        self.parameters = (Parameter(_LINK),) * (N_JOINTS * len(_PAIRS))

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint: links from the joint on."""
        return list(range(10 * joint, 10 * N_JOINTS))

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each parameter, (n, 10 (7 - joint))."""
        y = sample.regressor[:, joint]
        base = self._base[joint:, :, :y.shape[1]]
        return y @ base.reshape(-1, y.shape[1]).T

    def least_eigenvalues(self, deviation: Array) -> Array:
        """Return the smallest eigenvalue of 1 + S of each link, (7,)."""
        s = np.einsum('lk,kab->lab', deviation.reshape(N_JOINTS, -1), _SYMMETRIC)
        return 1.0 + np.linalg.eigvalsh(s)[:, 0]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Write the links into the settings."""
        pseudo = self._root @ self._root.swapaxes(-1, -2) + np.einsum(
            'lk,lkab->lab', deviation.reshape(N_JOINTS, -1), self._units)
        mass, center, inertia = from_pseudo_inertia(pseudo)
        values['links.mass'] = tuple(mass)
        values['links.center_of_mass'] = tuple(center.ravel())
        values['links.inertia'] = tuple(inertia_elements(inertia).ravel())

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""
        for link in range(N_JOINTS):
            own = slice(10 * link, 10 * link + 10)
            for name, unit, element in (('mass', 'kg', (3, 3)), ('moment x', 'kg m', (0, 3)),
                                        ('moment y', 'kg m', (1, 3)),
                                        ('moment z', 'kg m', (2, 3))):
                gradient = self._units[(link, slice(None)) + element]
                variance: Any = gradient @ covariance[own, own] @ gradient
                yield Fitted(self.name, link, name, unit, _moment(before, link, element[0]),
                             _moment(after, link, element[0]), float(np.sqrt(variance)))


class Tool:
    """
    Payload of the hand: mass and first moment, with the inertia of a point mass.

    Attributes
    ----------
    fixed : tuple
        Parameters that follow from the others: the second moments m c c^T.

    """

    name = 'payload'
    shared = True
    worth = WORTH_OF_ALL
    moments = tuple(map(_PAIRS.index, ((0, 3), (1, 3), (2, 3))))
    mass = _PAIRS.index((3, 3))
    fixed = tuple(n for n, (_, k) in enumerate(_PAIRS) if k < 3)

    def __init__(self, arm: BaxterArm) -> None:
        self._base = payload = arm.payload
        units = np.where(_SYMMETRIC, 1.0, 0.0)
        self._parameters = fixed_to_link(arm.parameters, N_JOINTS - 1, units)  # (10, 45)
        priors = {self.mass: Parameter(_PAYLOAD_MASS, -payload.mass),
                  **dict.fromkeys(self.moments, Parameter(_PAYLOAD_MOMENT))}
        self.parameters = tuple(priors.get(n, Parameter(1.0)) for n in range(len(_PAIRS)))

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint: all."""
        return list(range(len(_PAIRS)))

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each parameter, (n, 10)."""
        y = sample.regressor[:, joint]
        return y @ self._parameters[:, :y.shape[1]].T

    def total(self, deviation: Array) -> tuple[float, Array]:
        """Return the payload's mass [kg] and centre of mass (3,) [m]."""
        mass = max(self._base.mass + deviation[self.mass], 0.0)
        moment = self._base.mass * np.array(self._base.center_of_mass) + deviation[
            list(self.moments)]
        return mass, np.clip(moment / mass, -REACH, REACH) if mass > 1e-3 else np.zeros(3)

    def second_moments(self, deviation: Array) -> Array:
        """Return the fixed parameters that follow from the others, (6,) [kg m^2]."""
        mass, center = self.total(deviation)
        before = np.array(self._base.center_of_mass)
        change = mass * np.outer(center, center) - self._base.mass * np.outer(before, before)
        return np.array([change[_PAIRS[n]] for n in self.fixed])

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Write the payload into the settings."""
        mass, center = self.total(deviation)
        values['payload.mass'] = float(mass)
        values['payload.center_of_mass'] = tuple(center)
        if mass == 0.0:
            values['payload.inertia'] = (0.0,) * 6

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""
        mass = after['payload.mass']
        yield Fitted(self.name, None, 'mass', 'kg', before['payload.mass'], mass,
                     float(np.sqrt(covariance[self.mass, self.mass])))
        if mass < 1e-3:
            return
        for i, (axis, own) in enumerate(zip('xyz', self.moments)):
            center = after['payload.center_of_mass'][i]
            pair = covariance[np.ix_([own, self.mass], [own, self.mass])]
            gradient = np.array([1.0, -center]) / mass
            yield Fitted(self.name, None, f'center {axis}', 'm',
                         before['payload.center_of_mass'][i], center,
                         float(np.sqrt(gradient @ pair @ gradient)))


def _moment(values: dict[str, Any], link: int, axis: int) -> float:
    """Return the mass of a link (axis 3) [kg], or its first moment along an axis [kg m]."""
    mass = values['links.mass'][link]
    return mass if axis == 3 else mass * values['links.center_of_mass'][3 * link + axis]
