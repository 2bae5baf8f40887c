"""
Table of the predictor's settings: name, default, unit, range, description.

The node declares its parameters from this table; parameter files are checked against it.
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
from ..model.effort import (COULOMB_VELOCITY, CROSSTALK, DAHL_LENGTH, EffortModel,
                            SPRING_COEFFICIENTS, SPRING_RANGE)
from ..model.exceptions import ArgumentError
from ..model.joints import BASE_FRAME, mount, N_JOINTS, SIDES
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
    """One setting; a tuple as the default stands for a list of that length."""

    name: str
    default: str | bool | int | float | tuple[float, ...]
    description: str
    unit: str = ''
    lower: float = -float('inf')
    upper: float = float('inf')
    choices: tuple[str, ...] = ()
    read_only: bool = False  # cannot be changed while the node runs

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
            return self._check_text(value)
        if isinstance(self.default, int):
            if not isinstance(value, int) or isinstance(value, bool):
                raise ArgumentError(self.name, f'expected a whole number, got {value!r}')
            return int(number(self.name, value, self.lower, self.upper, self.unit))
        if isinstance(self.default, float):
            return number(self.name, value, self.lower, self.upper, self.unit)
        values = tuple(finite(self.name, value, (len(self.default),)).tolist())
        for i, element in enumerate(values):
            number(f'{self.name}[{i}]', element, self.lower, self.upper, self.unit)
        return values

    def _check_text(self, value: Any) -> str:
        if self.choices and value not in self.choices:
            raise ArgumentError(
                self.name, f'expected one of {", ".join(self.choices)}, got {value!r}')
        if not isinstance(value, str) or not value.isprintable():
            raise ArgumentError(self.name, f'expected printable text, got {value!r}')
        return value


SETTINGS = (
    Setting('arm', 'right', 'Arm to predict (right or left).', choices=SIDES, read_only=True),
    Setting('joint_prefix', '',
            "Prefix of the joint names in the messages: with 'robot_1/', the first joint of the "
            'right arm is robot_1/right_s0.', read_only=True),
    Setting('frame_id', BASE_FRAME, 'Frame of the published messages: the base of the robot.',
            read_only=True),
    Setting('method', 'lagrange_euler',
            'Inverse dynamics: lagrange_euler is the closed form, newton_euler the recursive '
            'method of Pinocchio.', choices=METHODS),
    Setting('acceleration.cutoff', 5.0,
            'Cutoff frequency of the second-order Butterworth filter that differentiates '
            'velocity.', 'Hz', 0.5, 50.0),
    Setting('acceleration.velocity_lag', 0.014,
            'Time by which measured velocity lags position and effort.', 's', 0.0, 0.2),
    Setting('stamps', MODES[0],
            'Source of time. header: header stamps. arrival: re-timed header stamps, for stamps '
            'that are times of arrival. receipt: re-timed times of receipt at the node. auto: '
            'header until stamps prove to be times of arrival (arrival) or to stand still '
            '(receipt).',
            choices=MODES),
    Setting('align', True,
            'Delay position, velocity and effort to the instant of the filtered acceleration. If '
            'false, the newest values are combined with the delayed acceleration.'),
    Setting('effort_model.enabled', True,
            'Model the spring, friction and bias of the real robot. If false, predicted effort '
            'is tau, as in a simulator.'),
    Setting('effort_model.spring_coefficients', SPRING_COEFFICIENTS,
            'Spring torque at s1: coefficients of 1, sin q, cos q, sin 2q, cos 2q.', 'N m',
            -200.0, 200.0),
    Setting('effort_model.spring_range', SPRING_RANGE,
            'Range of s1 in which the spring model is valid. Outside, the spring torque at the '
            'limit is used.', 'rad', -3.2, 3.2),
    Setting('effort_model.coulomb', _ZEROS, 'Coulomb friction per joint.', 'N m', 0.0, 50.0),
    Setting('effort_model.coulomb_velocity', COULOMB_VELOCITY,
            'Velocity over which Coulomb friction changes sign.', 'rad/s', 1e-3, 1.0),
    Setting('effort_model.viscous', _ZEROS, 'Viscous friction per joint.', 'N m s/rad', 0.0, 50.0),
    Setting('effort_model.dahl', _ZEROS, 'Pre-sliding (Dahl) friction per joint.', 'N m',
            0.0, 50.0),
    Setting('effort_model.dahl_length', DAHL_LENGTH,
            'Displacement over which Dahl friction reverses.', 'rad', 1e-4, 1.0),
    Setting('effort_model.bias', _ZEROS, 'Offset of measured effort per joint.', 'N m',
            -50.0, 50.0),
    Setting('effort_model.stiffness', _ZEROS, 'Cable stiffness per joint.', 'N m/rad',
            -50.0, 50.0),
    Setting('effort_model.added_inertia', _ZEROS,
            'Inertia per joint in addition to that of the links.', 'kg m^2', -5.0, 5.0),
    Setting('effort_model.crosstalk', tuple(CROSSTALK.ravel().tolist()),
            'Share of the effort of each joint in the measured effort of another: 7 x 7, row by '
            'row, row i for the measured effort of joint i; the diagonal is zero.', '', -0.5, 0.5),
    Setting('effort_model.deviation', _ZEROS,
            'Expected standard deviation of the residual per joint at rest.', 'N m', 0.0, 100.0),
    Setting('effort_model.deviation_velocity', _ZEROS,
            'Expected standard deviation of the residual per joint and velocity.', 'N m s/rad',
            0.0, 100.0),
    Setting('effort_model.deviation_acceleration', _ZEROS,
            'Expected standard deviation of the residual per joint and acceleration.',
            'N m s^2/rad', 0.0, 100.0),
    Setting('external_effort.gain', GAIN,
            'Gain of the momentum observer, the inverse of its time constant.', '1/s', 0.5, 100.0),
    Setting('contact.floor', FLOOR, 'Minimum contact threshold per joint.', 'N m', 0.001, 100.0),
    Setting('contact.limit', LIMIT,
            'Largest model error per joint. Contact with a larger external torque is reported '
            'however long it lasts.', 'N m', 0.001, 100.0),
    Setting('contact.sigmas', SIGMAS,
            'Contact threshold in standard deviations of the free-motion residual.', '',
            1.0, 100.0),
    Setting('contact.samples', SAMPLES,
            'Consecutive samples above the threshold before contact is reported.', '', 1, 1000),
    Setting('contact.hysteresis', HYSTERESIS,
            'Fraction of the threshold below which contact ends.', '', 0.0, 1.0),
    Setting('contact.memory', MEMORY,
            'Time constant for learning the standard deviation of the free-motion residual.', 's',
            1.0, 3600.0),
    Setting('gravity', paper_tables.GRAVITY, 'Gravity vector in the frame of a level base.',
            'm/s^2', -30.0, 30.0),
    Setting('base.roll', 0.0,
            'Roll of the base about its x axis; positive raises the left side.', 'rad', -3.2, 3.2),
    Setting('base.pitch', 0.0,
            'Pitch of the base about the level y axis, after roll; positive lowers the front.',
            'rad', -3.2, 3.2),
    Setting('payload.mass', 0.0, 'Mass of the payload.', 'kg', 0.0, 10.0),
    Setting('payload.center_of_mass', (0.0, 0.0, 0.0),
            'Centre of mass of the payload in the hand frame.', 'm', -1.0, 1.0),
    Setting('payload.inertia', (0.0,) * 6,
            'Inertia xx, yy, zz, xy, yz, xz of the payload about its centre of mass, axes of the '
            'hand frame.', 'kg m^2', -2.0, 2.0),
    Setting('links.mass', tuple(row[-1] for row in paper_tables.TABLE_II),
            'Mass of each link (Table II).', 'kg', 0.0, 20.0),
    Setting('links.center_of_mass', sum(paper_tables.TABLE_IV, ()),
            'Centre of mass x, y, z of each link in turn, in the link frame (Table IV).',
            'm', -1.0, 1.0),
    Setting('links.inertia', sum(paper_tables.TABLE_III, ()),
            'Inertia xx, yy, zz, xy, yz, xz of each link in turn, about its centre of mass '
            '(Table III).', 'kg m^2', -2.0, 2.0),
)

DEFAULTS = {setting.name: setting.default for setting in SETTINGS}


class PredictorSettings:
    """
    Complete, validated set of settings, and the objects built from it.

    Parameters
    ----------
    values : dict, optional
        Setting name to value; defaults apply to settings that are not given.

    Attributes
    ----------
    values : dict
        Value of every setting.
    arm : BaxterArm
        Rigid-body model in the robot's base frame.
    effort_model : EffortModel
        Effort model.
    model : ArmModel
        Both models, in the form used by the stream handler.

    Raises
    ------
    ArgumentError
        If a name is unknown, a value is invalid, or values are inconsistent.

    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        values = dict(values or {})
        for name in values:
            if name not in DEFAULTS:
                raise ArgumentError(str(name),
                                    f'unknown setting; expected one of {", ".join(DEFAULTS)}')
        self.values = {setting.name: setting.check(values.get(setting.name, setting.default))
                       for setting in SETTINGS}
        gravity = gravity_in_base(self.values['gravity'], **self._group('base'))
        self.arm = BaxterArm(payload=Payload(**self._group('payload')),
                             gravity=gravity, mount=mount(self.values['arm']),
                             parameters=link_parameters(**self._group('links')))
        effort = self._group('effort_model')
        enabled = effort.pop('enabled')
        effort['crosstalk'] = np.reshape(effort['crosstalk'], (N_JOINTS, N_JOINTS))
        model = EffortModel(**effort)  # validated even if disabled
        self.effort_model = model if enabled else EffortModel.rigid()
        self.model = ArmModel(
            self._choose_method(), self.arm.momentum_terms,
            self.arm.jacobian, self.effort_model)

    def warm_up(self) -> 'PredictorSettings':
        """
        Call every function used by messages and services once, and return these settings.

        The first message is then not delayed by lazy imports and page faults.
        """
        q, qd, qdd = np.zeros((3, N_JOINTS))
        self.model.inverse_dynamics(q, qd, qdd)
        self.model.momentum_terms(q, qd)
        self.arm.gravity(q)
        self.arm.terms(q, qd)
        return self

    def predictor(self, external: bool = False) -> Predictor:
        """Return a new stream handler, with or without an estimate of the external torque."""
        stream = Stream(self.values['arm'], self.values['stamps'], self.values['joint_prefix'])
        return Predictor(stream, self.model, self._estimator(),
                         self._external() if external else None)

    def configure(self, predictor: Predictor, before: 'PredictorSettings') -> None:
        """Apply these settings to a stream handler of the same arm having settings ``before``."""
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
        """Return a group of settings without its prefix, or the single setting of that name."""
        if prefix in self.values:
            return {prefix: self.values[prefix]}
        start = prefix + '.'
        return {name[len(start):]: value for name, value in self.values.items()
                if name.startswith(start)}

    def _choose_method(self) -> Callable[..., Array]:
        if self.values['method'] == 'lagrange_euler':
            return self.arm.inverse_dynamics
        try:
            from ..newton_euler import NewtonEuler
        except ImportError as error:
            raise ArgumentError('method', f'newton_euler needs Pinocchio: pip install pin, or '
                                f'ros-jazzy-pinocchio from apt ({error})') from None
        return NewtonEuler(self.arm).inverse_dynamics
