"""
Every setting of the predictor, stated once: name, default, unit, range, meaning.

The node declares its parameters from this table, and parameter files are checked against it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .arm_model import ArmModel
from .contact import FLOOR, HYSTERESIS, LIMIT, MEMORY, SAMPLES, SIGMAS
from .external import ExternalEffort
from .motion_estimator import MotionEstimator
from .observer import GAIN
from .predictor import Predictor
from .retiming import MODES
from .stream import Stream
from ..model import paper_tables
from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.effort import (COULOMB_VELOCITY, DAHL_LENGTH, EffortModel, SPRING_COEFFICIENTS,
                            SPRING_RANGE)
from ..model.exceptions import ArgumentError
from ..model.hand import HandKinematics
from ..model.joints import mount, N_JOINTS, SIDES
from ..model.parameters import link_parameters, Payload
from ..model.tilt import gravity_in_base
from ..model.validation import finite, number

# Groups of settings, or single ones, of the acceleration filter and of the arm's model.
_ESTIMATOR = ('align', 'acceleration')
_MODEL = ('method', 'effort_model', 'gravity', 'base', 'payload', 'links')

METHODS = ('lagrange_euler', 'newton_euler')
_ZEROS = (0.0,) * N_JOINTS


@dataclass(frozen=True)
class Setting:
    """One setting; a tuple as default means a list of as many numbers."""

    name: str
    default: str | bool | int | float | tuple[float, ...]
    description: str
    unit: str = ''
    lower: float = -float('inf')
    upper: float = float('inf')
    choices: tuple[str, ...] = ()
    read_only: bool = False  # fixed when the node starts

    def check(self, value: Any) -> Any:
        """
        Return the value in the type of the default.

        Raises
        ------
        ArgumentError
            If it has the wrong type or length, or is out of range or not finite.

        """
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise ArgumentError(self.name, f'expected true or false, got {value!r}')
            return value
        if isinstance(self.default, str):
            if not isinstance(value, str) or value not in self.choices:
                raise ArgumentError(
                    self.name, f'expected one of {", ".join(self.choices)}, got {value!r}')
            return value
        if isinstance(self.default, int):
            if not isinstance(value, int) or isinstance(value, bool):
                raise ArgumentError(self.name, f'expected a whole number, got {value!r}')
            return int(number(self.name, value, self.lower, self.upper))
        if isinstance(self.default, float):
            return number(self.name, value, self.lower, self.upper)
        values = tuple(finite(self.name, value, (len(self.default),)).tolist())
        for i, element in enumerate(values):
            number(f'{self.name}[{i}]', element, self.lower, self.upper)
        return values


SETTINGS = (
    Setting('arm', 'right', 'Which arm: its joints are picked by name.', choices=SIDES,
            read_only=True),
    Setting('method', 'lagrange_euler',
            'Inverse dynamics: the closed form, or the recursive method computed by Pinocchio.',
            choices=METHODS),
    Setting('acceleration.cutoff', 5.0,
            'Cut-off of the second-order Butterworth derivative of the velocity.', 'Hz',
            0.5, 50.0),
    Setting('acceleration.velocity_lag', 0.014,
            'How far the measured velocity lags position and effort.', 's', 0.0, 0.2),
    Setting('stamps', MODES[0],
            "What the joint states' stamps are: header: the robot's; arrival: times of arrival, "
            'which are re-timed; auto: the first, until they prove to be the second.',
            choices=MODES),
    Setting('align', True,
            'Predict for the instant the acceleration belongs to, and compare with the effort '
            'of that instant. False: newest values, lagging acceleration.'),
    Setting('effort_model.enabled', True,
            'Spring, friction and bias of the real robot. False for a simulator: effort = tau.'),
    Setting('effort_model.spring_coefficients', SPRING_COEFFICIENTS,
            'Spring at s1, as coefficients of 1, sin q, cos q, sin 2q, cos 2q.', 'N m',
            -200.0, 200.0),
    Setting('effort_model.spring_range', SPRING_RANGE,
            'The s1 angles for which they hold; beyond, the value at the border is held.', 'rad',
            -3.2, 3.2),
    Setting('effort_model.coulomb', _ZEROS, 'Coulomb friction per joint.', 'N m', 0.0, 50.0),
    Setting('effort_model.coulomb_velocity', COULOMB_VELOCITY,
            "Width of the Coulomb friction's change of sign.", 'rad/s', 1e-3, 1.0),
    Setting('effort_model.viscous', _ZEROS, 'Viscous friction per joint.', 'N m s/rad', 0.0, 50.0),
    Setting('effort_model.dahl', _ZEROS, "Dahl's pre-sliding friction per joint.", 'N m',
            0.0, 50.0),
    Setting('effort_model.dahl_length', DAHL_LENGTH,
            "The angle over which Dahl's friction turns round.", 'rad', 1e-4, 1.0),
    Setting('effort_model.bias', _ZEROS, 'Offset of the measured effort per joint.', 'N m',
            -50.0, 50.0),
    Setting('effort_model.stiffness', _ZEROS, 'Of the cables that a joint bends, per joint.',
            'N m/rad', -50.0, 50.0),
    Setting('effort_model.added_inertia', _ZEROS,
            "Inertia beyond the links' that the measured effort shows, per joint.", 'kg m^2',
            -5.0, 5.0),
    Setting('external_effort.gain', GAIN,
            'Bandwidth of the momentum observer: it follows an external torque in 1 / gain.',
            '1/s', 0.5, 100.0),
    Setting('contact.floor', FLOOR,
            'External torque off that of free motion that is contact at the least, per joint.',
            'N m', 0.001, 100.0),
    Setting('contact.limit', LIMIT,
            'What the model may be wrong by, per joint: what is beyond stays contact.', 'N m',
            0.001, 100.0),
    Setting('contact.sigmas', SIGMAS,
            'So many sigma of free motion are contact, where that is more than the floor.', '',
            1.0, 100.0),
    Setting('contact.samples', SAMPLES, 'So many samples in a row are contact.', '', 1, 1000),
    Setting('contact.hysteresis', HYSTERESIS,
            'Contact ends where all joints are back within this part of their thresholds.', '',
            0.0, 1.0),
    Setting('contact.memory', MEMORY, 'The time over which sigma is learnt.', 's', 1.0, 3600.0),
    Setting('gravity', paper_tables.GRAVITY,
            "Gravity vector in the robot's base frame, were the base level.", 'm/s^2',
            -30.0, 30.0),
    Setting('base.roll', 0.0, "Tilt of the robot's base about its x axis: left up.", 'rad',
            -3.2, 3.2),
    Setting('base.pitch', 0.0, '... and then about the level y axis: front down.', 'rad',
            -3.2, 3.2),
    Setting('payload.mass', 0.0, 'Mass of what the hand carries.', 'kg', 0.0, 10.0),
    Setting('payload.center_of_mass', (0.0, 0.0, 0.0), 'Its centre of mass in the hand frame.',
            'm', -1.0, 1.0),
    Setting('payload.inertia', (0.0,) * 6,
            'Its inertia about its centre of mass, hand-frame axes: xx, yy, zz, xy, yz, xz.',
            'kg m^2', -2.0, 2.0),
    Setting('links.mass', tuple(row[-1] for row in paper_tables.TABLE_II),
            'Mass of each link (Table II).', 'kg', 0.0, 20.0),
    Setting('links.center_of_mass', sum(paper_tables.TABLE_IV, ()),
            "Centre of mass x, y, z of each link in turn, in the link's frame (Table IV).", 'm',
            -1.0, 1.0),
    Setting('links.inertia', sum(paper_tables.TABLE_III, ()),
            'Inertia xx, yy, zz, xy, yz, xz of each link in turn, about its centre of mass '
            '(Table III).', 'kg m^2', -2.0, 2.0),
)

DEFAULTS = {setting.name: setting.default for setting in SETTINGS}


class PredictorSettings:
    """
    A complete, valid set of settings, and what is built from it.

    Parameters
    ----------
    values : dict, optional
        Setting name to value; what is missing has its default.

    Attributes
    ----------
    values : dict
        All settings.
    arm : BaxterArm
        The model, in the robot's base frame.
    effort_model : EffortModel
        From tau to measured effort.
    model : ArmModel
        Both, as a stream uses them.

    Raises
    ------
    ArgumentError
        If a name is unknown, a value is refused, or values do not fit together.

    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        values = dict(values or {})
        for name in values:
            if name not in DEFAULTS:
                raise ArgumentError(str(name), f'unknown setting; known are {", ".join(DEFAULTS)}')
        self.values = {setting.name: setting.check(values.get(setting.name, setting.default))
                       for setting in SETTINGS}
        gravity = gravity_in_base(self.values['gravity'], **self._group('base'))
        self.arm = BaxterArm(payload=Payload(**self._group('payload')),
                             gravity=gravity, mount=mount(self.values['arm']),
                             parameters=link_parameters(**self._group('links')))
        effort = self._group('effort_model')
        enabled = effort.pop('enabled')
        model = EffortModel(**effort)  # checked even where it is off
        self.effort_model = model if enabled else EffortModel.rigid()
        self.model = ArmModel(
            self._choose_method(), self.arm.dynamics.momentum_terms,
            HandKinematics(self.arm.parameters, self.arm.mount).jacobian, self.effort_model)

    def warm_up(self) -> 'PredictorSettings':
        """
        Compute once what messages and services will ask for, and return these settings.

        numba, where it computes, loads or compiles then, and not when a message waits.
        """
        q, qd, qdd = np.zeros((3, N_JOINTS))
        self.model.inverse_dynamics(q, qd, qdd)
        self.model.momentum_terms(q, qd)
        self.arm.gravity(q)
        self.arm.terms(q, qd)
        return self

    def predictor(self, external: bool = False) -> Predictor:
        """Return a new stream handler with these settings, which tells external effort or not."""
        return Predictor(Stream(self.values['arm'], self.values['stamps']), self.model,
                         self._estimator(), self._external() if external else None)

    def configure(self, predictor: Predictor, before: 'PredictorSettings') -> None:
        """Bring a stream handler here from the settings ``before``; the arm must be the same."""
        def changed(*groups: str) -> bool:
            return any(self._group(group) != before._group(group) for group in groups)
        if changed(*_MODEL):
            predictor.configure(self.model)
        if changed(*_ESTIMATOR):
            predictor.estimator.configure(
                align=self.values['align'], **self._group('acceleration'))
        if changed('stamps'):
            predictor.stream.reset(self.values['stamps'])
        if predictor.external is not None and changed('external_effort', 'contact'):
            predictor.external.tune(**self._group('external_effort'), **self._group('contact'))

    def _estimator(self) -> MotionEstimator:
        return MotionEstimator(align=self.values['align'], **self._group('acceleration'))

    def _external(self) -> ExternalEffort:
        return ExternalEffort(self.model, **self._group('external_effort'),
                              **self._group('contact'))

    def _group(self, prefix: str) -> dict[str, Any]:
        """Return the settings of a group by what follows its name, or the one of that name."""
        if prefix in self.values:
            return {prefix: self.values[prefix]}
        start = prefix + '.'
        return {name[len(start):]: value for name, value in self.values.items()
                if name.startswith(start)}

    def _choose_method(self) -> Callable[..., Array]:
        if self.values['method'] == 'lagrange_euler':
            return self.arm.dynamics.inverse_dynamics  # what comes from a stream is validated
        try:
            from ..newton_euler import NewtonEuler
        except ImportError as error:
            raise ArgumentError('method', f'newton_euler needs Pinocchio: pip install pin, or '
                                f'ros-jazzy-pinocchio from apt ({error})') from None
        return NewtonEuler(self.arm).inverse_dynamics
