"""Terms shared by all joints: tilt of the base, link parameters, payload."""

from dataclasses import replace

import numpy as np

from .term import Sample, SharedTerm
from ..estimation.settings import LinkSettings, PayloadSettings, PredictorSettings
from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.base_parameters import fixed_to_link
from ..model.joints import N_JOINTS
from ..model.parameters import from_pseudo_inertia, inertia_elements

# Standard deviations of the priors.
_TILT = 0.3  # horizontal gravity, corresponding to 1.75 degrees [m/s^2]
_LINK = 0.1  # relative: 10 % of the mass, 10 % of the radius of gyration for the centre of mass
_PAYLOAD_MASS = 3.0  # [kg]
_PAYLOAD_MOMENT = 0.5  # first moment [kg m]

REACH = 1.0  # bound on each coordinate of the payload's centre, unidentifiable at low mass [m]

_LIGHT = 1e-3  # mass below which a payload has no centre [kg]

# An orthonormal basis of the symmetric 4 x 4 matrices, (10, 4, 4).
_PAIRS = [(i, k) for i in range(4) for k in range(i, 4)]
_SYMMETRIC = np.zeros((len(_PAIRS), 4, 4))
for _n, (_i, _k) in enumerate(_PAIRS):
    _SYMMETRIC[_n, _i, _k] = _SYMMETRIC[_n, _k, _i] = 1.0 if _i == _k else np.sqrt(0.5)


class Tilt(SharedTerm):
    """Tilt of the robot's base, as the horizontal components of gravity."""

    name = 'tilt'
    quantities = [(None, axis, 'm/s^2') for axis in 'xy']

    def __init__(self) -> None:
        super().__init__(np.full(2, _TILT))

    def columns(self, sample: Sample, joint: int) -> Array:
        return sample.horizontal_gravity[:, joint]

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        """Rotate gravity, preserving its magnitude."""
        gravity = np.array(settings.gravity)
        x, y = gravity[:2] + deviation
        z = np.copysign(np.sqrt(gravity @ gravity - x * x - y * y), gravity[2])
        return replace(settings, gravity=(x, y, z))

    def read(self, settings: PredictorSettings) -> Array:
        return np.array(settings.gravity[:2])


class Links(SharedTerm):
    r"""
    Inertial parameters of the links, with a physically consistent prior.

    Pseudo-inertias are fitted as J = L (1 + S) L^T, where L L^T is the value in the settings, with
    a normal prior on the symmetric S. This is the second-order approximation of the coordinate-
    invariant distance of Lee, Wensing and Park (2020). J is physically consistent while 1 + S > 0.
    """

    name = 'inertial'
    quantities = [(link, *what) for link in range(N_JOINTS) for what in (
        ('mass', 'kg'), ('moment x', 'kg m'), ('moment y', 'kg m'), ('moment z', 'kg m'))]

    def __init__(self, arm: BaxterArm) -> None:
        super().__init__(np.full(N_JOINTS * len(_PAIRS), _LINK))
        # A joint bears the links from its own on.
        self.acts = np.triu(np.ones((N_JOINTS, N_JOINTS), dtype=bool)).repeat(len(_PAIRS), axis=1)
        self._root = np.linalg.cholesky(arm.parameters.pseudo_inertia)
        self._units = self._root[:, None] @ _SYMMETRIC @ self._root.swapaxes(-1, -2)[:, None]
        self._base = np.concatenate([fixed_to_link(arm.parameters, link, units)
                                     for link, units in enumerate(self._units)])  # (70, 45)

    def columns(self, sample: Sample, joint: int) -> Array:
        y = sample.regressor[:, joint]
        return y @ self._base[self.acts[joint], :y.shape[1]].T

    def least_eigenvalues(self, deviation: Array) -> Array:
        """Return the smallest eigenvalue of 1 + S of each link, (7,)."""
        s = np.einsum('lk,kab->lab', deviation.reshape(N_JOINTS, -1), _SYMMETRIC)
        return 1.0 + np.linalg.eigvalsh(s)[:, 0]

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        pseudo = self._root @ self._root.swapaxes(-1, -2) + np.einsum(
            'lk,lkab->lab', deviation.reshape(N_JOINTS, -1), self._units)
        mass, center, inertia = from_pseudo_inertia(pseudo)
        return replace(settings, links=LinkSettings(
            tuple(mass), tuple(center.ravel()), tuple(inertia_elements(inertia).ravel())))

    def read(self, settings: PredictorSettings) -> Array:
        mass = np.array(settings.links.mass)[:, None]
        center = np.reshape(settings.links.center_of_mass, (N_JOINTS, 3))
        return np.concatenate([mass, mass * center], axis=1).ravel()

    def jacobian(self, settings: PredictorSettings) -> Array:
        blocks = self._units[:, :, [3, 0, 1, 2], 3].swapaxes(1, 2)
        links, rows, columns = blocks.shape
        result = np.zeros((links, rows, links, columns))
        result[range(links), :, range(links)] = blocks
        return result.reshape(links * rows, links * columns)


class Tool(SharedTerm):
    """
    Payload of the hand: mass and first moment, with the inertia of a point mass.

    Attributes
    ----------
    fixed : tuple
        Parameters that follow from the others: the second moments m c c^T.

    """

    name = 'payload'
    quantities = [(None, 'mass', 'kg'), *((None, f'center {axis}', 'm') for axis in 'xyz')]
    moments = tuple(map(_PAIRS.index, ((0, 3), (1, 3), (2, 3))))
    mass = _PAIRS.index((3, 3))
    fixed = tuple(n for n, (_, k) in enumerate(_PAIRS) if k < 3)

    def __init__(self, arm: BaxterArm) -> None:
        super().__init__(np.ones(len(_PAIRS)))
        self.prior[list(self.moments)] = _PAYLOAD_MOMENT
        self.prior[self.mass] = _PAYLOAD_MASS
        self.lower[self.mass] = -arm.payload.mass
        self._before = arm.payload
        self._base = fixed_to_link(arm.parameters, N_JOINTS - 1,
                                   np.where(_SYMMETRIC, 1.0, 0.0))  # (10, 45)

    def columns(self, sample: Sample, joint: int) -> Array:
        y = sample.regressor[:, joint]
        return y @ self._base[:, :y.shape[1]].T

    def total(self, deviation: Array) -> tuple[float, Array]:
        """Return the payload's mass [kg] and centre of mass (3,) [m]."""
        mass = max(self._before.mass + deviation[self.mass], 0.0)
        moment = self._before.mass * np.array(self._before.center_of_mass) + deviation[
            list(self.moments)]
        return mass, np.clip(moment / mass, -REACH, REACH) if mass > _LIGHT else np.zeros(3)

    def second_moments(self, deviation: Array) -> Array:
        """Return the fixed parameters that follow from the others, (6,) [kg m^2]."""
        mass, center = self.total(deviation)
        before = np.array(self._before.center_of_mass)
        change = mass * np.outer(center, center) - self._before.mass * np.outer(before, before)
        return np.array([change[_PAIRS[n]] for n in self.fixed])

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        mass, center = self.total(deviation)
        inertia = settings.payload.inertia if mass else (0.0,) * 6
        return replace(settings, payload=PayloadSettings(mass, tuple(center), inertia))

    def read(self, settings: PredictorSettings) -> Array:
        return np.array([settings.payload.mass, *settings.payload.center_of_mass])

    def jacobian(self, settings: PredictorSettings) -> Array:
        mass, *center = self.read(settings)
        result = np.zeros((4, len(_PAIRS)))
        result[0, self.mass] = 1.0
        if mass >= _LIGHT:  # d center = (d moment - center d mass) / mass
            result[range(1, 4), self.moments] = 1.0 / mass
            result[1:, self.mass] = -np.array(center) / mass
        return result
