"""Terms of a fit, in the order in which they are tried."""

import numpy as np

from .body_terms import Links, Tilt, Tool
from .joint_terms import Crosstalk, DahlFriction, OFFSET, PerJoint, Spring, TORQUE
from .term import Term, WORTH_OF_ODD
from ..estimation.settings import PredictorSettings
from ..model.effort import EffortModel
from ..model.joints import N_JOINTS, S1

TERMS = ('bias', 'spring', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness', 'tilt',
         'crosstalk')
OPTIONAL = ('inertial', 'payload')  # fitted only on request, and then always

_INERTIA = 0.5  # standard deviation of the prior [kg m^2]

# Candidates for the angle over which Dahl friction reverses [rad].
_DAHL_LENGTHS = (0.01, 0.02, 0.03, 0.05)


def dahl_lengths(model: EffortModel) -> tuple[float, ...]:
    """Return the Dahl lengths to try [rad]: that of the model if it has Dahl friction."""
    return (model.dahl_length,) if model.has_dahl else _DAHL_LENGTHS


def all_terms(settings: PredictorSettings, shape: bool, constant: bool = False) -> list[Term]:
    """
    Return all terms of deviations from some settings, each to be tried on top of those before it.

    The spring has its shape fitted, or only a gain. Its constant is part of the bias of s1, unless
    a shape has its own.
    """
    model, arm = settings.model.effort_model, settings.model.arm
    terms: list[Term] = [
        PerJoint('bias', 'N m', OFFSET, lambda sample: np.ones(sample.motion.q.shape)),
        Tool(arm),  # first: an unknown load hides friction
    ]
    if shape or model.has_spring:
        terms.append(Spring(model, shape, constant))
    terms += [
        PerJoint('coulomb', 'N m', TORQUE,
                 lambda sample: np.tanh(sample.motion.qd / model.coulomb_velocity),
                 0.0, model.coulomb),
        PerJoint('viscous', 'N m s/rad', TORQUE, lambda sample: sample.motion.qd,
                 0.0, model.viscous),
        *(DahlFriction(model.dahl, length) for length in dahl_lengths(model)),
        PerJoint('added_inertia', 'kg m^2', np.full(N_JOINTS, _INERTIA),
                 lambda sample: sample.motion.qdd, worth=WORTH_OF_ODD),
    ]
    if arm.gravity_vector[2]:
        terms.append(Tilt())
    return [
        *terms, Links(arm), Crosstalk(),
        # Last, because stiffness over a small range can imitate other terms; s1 has the spring.
        PerJoint('stiffness', 'N m/rad', TORQUE, lambda sample: sample.motion.q, without=(S1,),
                 worth=WORTH_OF_ODD),
    ]
