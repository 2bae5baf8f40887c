"""Terms of a fit: tilt, links and payload, and all terms in the order in which they are tried."""

from typing import Any

import numpy as np

from .joint_terms import (Crosstalk, OFFSET, PerJoint, Sample, Spring, Term, WORTH_OF_ALL,
                          WORTH_OF_ODD)
from ..estimation.settings import PredictorSettings
from ..model import Array, BaxterArm, EffortModel, N_JOINTS, S1
from ..model.base_parameters import fixed_to_link
from ..model.parameters import from_pseudo_inertia, inertia_elements

TERMS = ('bias', 'spring', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness', 'tilt',
         'crosstalk')
OPTIONAL = ('inertial', 'payload')  # fitted only on request, and then always
REACH = 1.0  # bound on each coordinate of the payload's centre, unidentifiable at low mass [m]

# Candidates for the angle over which Dahl friction reverses, if the settings have none [rad].
DAHL_LENGTHS = (0.01, 0.02, 0.03, 0.05)

# Standard deviations of the priors.
_INERTIA = np.full(N_JOINTS, 0.5)  # [kg m^2]
_TILT = 0.3  # horizontal gravity, corresponding to 1.75 degrees [m/s^2]
_LINK = 0.1  # relative: 10 % of the mass, 10 % of the radius of gyration for the centre of mass
_PAYLOAD_MASS = 3.0  # [kg]
_PAYLOAD_MOMENT = 0.5  # first moment [kg m]

_LIGHT = 1e-3  # mass below which a payload has no centre [kg]

# An orthonormal basis of the symmetric 4 x 4 matrices, (10, 4, 4), by the upper elements.
_ROWS, _COLUMNS = np.triu_indices(4)
_SYMMETRIC = np.zeros((10, 4, 4))
_SYMMETRIC[range(10), _ROWS, _COLUMNS] = np.where(_ROWS == _COLUMNS, 1.0, np.sqrt(0.5))
_SYMMETRIC = np.maximum(_SYMMETRIC, _SYMMETRIC.swapaxes(1, 2))


class _BodyTerm(Term):
    """Term that acts on several joints by base parameters."""

    shared = True
    worth = WORTH_OF_ALL
    base: Array  # (p, 45) base parameters for a unit of each parameter

    def columns(self, sample: Sample, joint: int) -> Array:
        y = sample.regressor[:, joint]
        return y @ self.base[self.acts[joint], :y.shape[1]].T


class Tilt(Term):
    """Tilt of the robot's base, as the horizontal components of gravity."""

    name = 'tilt'
    shared = True
    worth = WORTH_OF_ALL
    quantities = [(None, axis, 'm/s^2') for axis in 'xy']

    def __init__(self) -> None:
        super().__init__(np.full(2, _TILT))

    def columns(self, sample: Sample, joint: int) -> Array:
        return sample.horizontal_gravity[:, joint]

    def values(self, settings: PredictorSettings, deviation: Array) -> dict[str, Any]:
        """Rotate gravity, preserving its magnitude."""
        gravity = np.array(settings.gravity)
        x, y = gravity[:2] + deviation
        z = np.copysign(np.sqrt(gravity @ gravity - x * x - y * y), gravity[2])
        return {'gravity': (x, y, z)}

    def read(self, settings: PredictorSettings) -> Array:
        return np.array(settings.gravity[:2])


class Links(_BodyTerm):
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
        # A joint bears the links from its own on.
        acts = np.triu(np.ones((N_JOINTS, N_JOINTS), dtype=bool)).repeat(10, axis=1)
        super().__init__(np.full(10 * N_JOINTS, _LINK), acts)
        root = np.linalg.cholesky(arm.parameters.pseudo_inertia)
        self._before = arm.parameters.pseudo_inertia
        self._units = root[:, None] @ _SYMMETRIC @ root.swapaxes(-1, -2)[:, None]
        self.base = np.concatenate([fixed_to_link(arm.parameters, link, units)
                                    for link, units in enumerate(self._units)])

    def least_eigenvalues(self, deviation: Array) -> Array:
        """Return the smallest eigenvalue of 1 + S of each link, (7,)."""
        s = np.einsum('lk,kab->lab', deviation.reshape(N_JOINTS, -1), _SYMMETRIC)
        return 1.0 + np.linalg.eigvalsh(s)[:, 0]

    def values(self, settings: PredictorSettings, deviation: Array) -> dict[str, Any]:
        mass, center, inertia = from_pseudo_inertia(self._before + np.einsum(
            'lk,lkab->lab', deviation.reshape(N_JOINTS, -1), self._units))
        return {'links.mass': mass, 'links.center_of_mass': center.ravel(),
                'links.inertia': inertia_elements(inertia).ravel()}

    def read(self, settings: PredictorSettings) -> Array:
        mass = np.array(settings.links.mass)[:, None]
        center = np.reshape(settings.links.center_of_mass, (N_JOINTS, 3))
        return np.concatenate([mass, mass * center], axis=1).ravel()

    def jacobian(self, settings: PredictorSettings) -> Array:
        blocks = self._units[:, :, [3, 0, 1, 2], 3].swapaxes(1, 2)
        diagonal = np.einsum('lik,lm->limk', blocks, np.eye(N_JOINTS))
        return diagonal.reshape(len(self.quantities), len(self.prior))


class Tool(_BodyTerm):
    """Payload of the hand: mass and first moment, with the inertia of a point mass."""

    name = 'payload'
    quantities = [(None, 'mass', 'kg'), *((None, f'center {axis}', 'm') for axis in 'xyz')]
    *moments, mass = np.flatnonzero(_COLUMNS == 3).tolist()

    def __init__(self, arm: BaxterArm) -> None:
        super().__init__(np.ones(10))
        self.tied = _COLUMNS < 3  # second moments m c c^T
        self.prior[self.moments] = _PAYLOAD_MOMENT
        self.prior[self.mass] = _PAYLOAD_MASS
        self.lower[self.mass] = -arm.payload.mass
        self._before = arm.payload
        self.base = fixed_to_link(arm.parameters, N_JOINTS - 1, np.where(_SYMMETRIC, 1.0, 0.0))

    def total(self, deviation: Array) -> tuple[float, Array]:
        """Return the payload's mass [kg] and centre of mass (3,) [m]."""
        mass = max(self._before.mass + deviation[self.mass], 0.0)
        moment = (self._before.mass * np.array(self._before.center_of_mass)
                  + deviation[self.moments])
        return mass, np.clip(moment / mass, -REACH, REACH) if mass > _LIGHT else np.zeros(3)

    def second_moments(self, deviation: Array) -> Array:
        """Return the tied parameters (6,) [kg m^2]."""
        mass, center = self.total(deviation)
        before = np.array(self._before.center_of_mass)
        change = mass * np.outer(center, center) - self._before.mass * np.outer(before, before)
        return change[np.triu_indices(3)]

    def values(self, settings: PredictorSettings, deviation: Array) -> dict[str, Any]:
        mass, center = self.total(deviation)
        return {'payload.mass': mass, 'payload.center_of_mass': center,
                'payload.inertia': settings.payload.inertia if mass else (0.0,) * 6}

    def read(self, settings: PredictorSettings) -> Array:
        return np.array([settings.payload.mass, *settings.payload.center_of_mass])

    def jacobian(self, settings: PredictorSettings) -> Array:
        mass, *center = self.read(settings)
        result = np.zeros((4, 10))
        result[0, self.mass] = 1.0
        if mass >= _LIGHT:  # d center = (d moment - center d mass) / mass
            result[range(1, 4), self.moments] = 1.0 / mass
            result[1:, self.mass] = -np.array(center) / mass
        return result


def _dahl(model: EffortModel, length: float) -> PerJoint:
    return PerJoint('dahl', lambda sample: sample.presliding[length], lower=-model.dahl,
                    dahl_length=length)


def all_terms(settings: PredictorSettings, shape: bool, constant: bool = False) -> list[Term]:
    """
    Return all terms of deviations from some settings, each to be tried on top of those before it.

    The spring has its shape fitted, or only a gain.
    """
    model, arm = settings.model.effort_model, settings.model.arm
    dahl_lengths = (model.dahl_length,) if model.dahl.any() else DAHL_LENGTHS
    return [
        PerJoint('bias', lambda sample: np.ones(sample.motion.q.shape), OFFSET),
        Tool(arm),  # first: an unknown load hides friction
        *([Spring(model, shape, constant)] if shape or model.has_spring else []),
        PerJoint('coulomb', lambda sample: np.tanh(sample.motion.qd / model.coulomb_velocity),
                 lower=-model.coulomb),
        PerJoint('viscous', lambda sample: sample.motion.qd, lower=-model.viscous),
        *(_dahl(model, length) for length in dahl_lengths),
        PerJoint('added_inertia', lambda sample: sample.motion.qdd, _INERTIA, worth=WORTH_OF_ODD),
        *([Tilt()] if arm.gravity_vector[2] else []), Links(arm), Crosstalk(),
        # Last, because stiffness over a small range can imitate other terms; s1 has the spring.
        PerJoint('stiffness', lambda sample: sample.motion.q, worth=WORTH_OF_ODD, without=(S1,))]
