"""
Settings of the predictor, in one group per concern.

Each setting is declared once, here or in the model, with default, description, unit and range.
The node's parameters, parameter files and the command line are views of this declaration: names
there are dotted paths, as in ``effort_model.bias``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from .retiming import AUTO, MODES
from ..model import (ArgumentError, Array, BASE_FRAME, BaxterArm, EffortModel, mount, paper_tables,
                     Payload, SIDES)
from ..model.joints import gravity_in_base
from ..model.parameters import LinkSettings
from ..model.setting import Floats, Group, setting

MATCHED = 'matched'  # effort band


@dataclass(frozen=True)
class AccelerationSettings(Group, prefix='acceleration.'):
    """Filter that estimates acceleration."""

    cutoff: float = setting(
        5.0, 'Cutoff frequency of the second-order Butterworth filter that differentiates '
        'velocity.', 'Hz', 0.5, 50.0)
    velocity_lag: float = setting(
        0.014, 'Time by which measured velocity lags position and effort.', 's', 0.0, 0.2)


@dataclass(frozen=True, eq=False)
class EffortModelSettings(EffortModel, prefix='effort_model.'):
    """An :class:`.EffortModel`, and whether to use it."""

    enabled: bool = setting(
        True, 'Model the spring, friction and bias of the real robot. If false, predicted effort '
        'is tau, as in a simulator.')


@dataclass(frozen=True)
class ExternalEffortSettings(Group, prefix='external_effort.'):
    """Estimate of the external torque."""

    gain: float = setting(
        10.0, 'Gain of the momentum observer, the inverse of its time constant.', '1/s',
        0.5, 100.0)


@dataclass(frozen=True)
class ContactSettings(Group, prefix='contact.'):
    """Contact detector; the defaults of floor and limit hold for an uncalibrated robot."""

    floor: Floats = setting(
        (2.5, 1.0, 1.0, 0.6, 0.25, 0.4, 0.3), 'Minimum contact threshold per joint.', 'N m',
        0.001, 100.0)
    limit: Floats = setting(
        (4.0, 5.0, 4.0, 2.5, 1.2, 1.5, 0.8), 'Largest expected model error per joint, or 3.5 '
        'expected deviations if smaller. Contact with a larger external torque is reported as '
        'long as it lasts.', 'N m', 0.001, 100.0)
    sigmas: float = setting(
        3.6, 'Contact threshold in standard deviations of the free-motion residual.', '',
        1.0, 100.0)
    samples: int = setting(
        2, 'Consecutive samples above the threshold before contact is reported.', '', 1, 1000)
    hysteresis: float = setting(
        0.7, 'Fraction of the threshold below which contact ends.', '', 0.0, 1.0)
    memory: float = setting(
        30.0, 'Time constant for learning the standard deviation of the free-motion residual.',
        's', 1.0, 3600.0)


@dataclass(frozen=True)
class BaseSettings(Group, prefix='base.'):
    """Tilt of the robot's base."""

    roll: float = setting(
        0.0, 'Roll of the base about its x axis; positive raises the left side.', 'rad',
        -3.2, 3.2)
    pitch: float = setting(
        0.0, 'Pitch of the base about the level y axis, after roll; positive lowers the front.',
        'rad', -3.2, 3.2)


class ArmModel(NamedTuple):
    """Rigid-body model and effort model of an arm."""

    arm: BaxterArm  # in the robot's base frame
    effort_model: EffortModel  # from tau to measured effort
    # (q, qd, qdd), (..., 7) each -> tau (..., 7) [N m].
    inverse_dynamics: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class PredictorSettings(Group):
    """All settings of one arm's predictor; raises ArgumentError if a value is invalid."""

    arm: str = setting('right', 'Arm to predict (right or left).', choices=SIDES, read_only=True)
    joint_prefix: str = setting(
        '', "Prefix of the joint names in the messages: with 'robot_1/', the first joint of the "
        'right arm is robot_1/right_s0.', read_only=True)
    frame_id: str = setting(
        BASE_FRAME, 'Frame of the published messages: the base of the robot.', read_only=True)
    wrench_frame: str = setting(
        'hand', 'Axes and frame of the published wrench: hand (right_hand or left_hand) or base '
        '(frame_id). The torque is about the origin of the hand frame in both.',
        choices=('hand', 'base'), read_only=True)
    method: str = setting(
        'lagrange_euler', 'Inverse dynamics: lagrange_euler is the closed form, newton_euler the '
        'recursive method of Pinocchio.', choices=('lagrange_euler', 'newton_euler'))
    acceleration: AccelerationSettings = AccelerationSettings()
    stamps: str = setting(
        AUTO, 'Source of time. header: header stamps. arrival: re-timed header stamps, for '
        'stamps that are times of arrival. receipt: re-timed times of receipt at the node. auto: '
        'header until stamps prove to be times of arrival (arrival) or to stand still (receipt).',
        choices=MODES)
    align: bool = setting(
        True, 'Delay position, velocity and effort to the instant of the filtered acceleration. '
        'If false, the newest values are combined with the delayed acceleration.')
    effort_band: str = setting(
        MATCHED, 'Measured effort in the residual. matched: passed through the filter that '
        'differentiates velocity, so that measured and predicted effort have the same band. raw: '
        'as measured.', choices=(MATCHED, 'raw'))
    effort_model: EffortModelSettings = EffortModelSettings()
    external_effort: ExternalEffortSettings = ExternalEffortSettings()
    contact: ContactSettings = ContactSettings()
    gravity: Floats = setting(
        paper_tables.GRAVITY, 'Gravity vector in the frame of a level base.', 'm/s^2',
        -30.0, 30.0)
    base: BaseSettings = BaseSettings()
    payload: Payload = Payload()
    links: LinkSettings = LinkSettings()

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any]) -> 'PredictorSettings':
        """
        Return the settings with these values by dotted name, and defaults for all others.

        ArgumentError is raised if a name is unknown, a value invalid, or values contradict.
        """
        return cls().replace(values)

    def replace(self, values: Mapping[str, Any]) -> 'PredictorSettings':
        """Return the settings with other values by dotted name; raises as from_parameters."""
        parts: dict[str, dict[str, Any]] = {'': {}}
        for name, value in values.items():
            if name not in DEFAULTS:
                raise ArgumentError(str(name),
                                    f'unknown setting; expected one of {", ".join(DEFAULTS)}')
            group, _, leaf = name.rpartition('.')
            parts.setdefault(group, {})[leaf] = value
        own = parts.pop('')
        result = replace(self, **own, **{
            group: replace(getattr(self, group), **leaves) for group, leaves in parts.items()})
        result.model  # raises if values contradict each other
        return result

    @cached_property
    def model(self) -> ArmModel:
        """Model of the arm; ArgumentError if values contradict, or Pinocchio is missing."""
        arm = BaxterArm(
            payload=self.payload, mount=mount(self.arm),
            gravity=gravity_in_base(self.gravity, **vars(self.base)),
            parameters=self.links.arm_parameters())
        effort_model = self.effort_model if self.effort_model.enabled else EffortModel.rigid()
        return ArmModel(arm, effort_model, self._inverse_dynamics(arm))

    def _inverse_dynamics(self, arm: BaxterArm) -> Callable[[Array, Array, Array], Array]:
        if self.method == 'lagrange_euler':
            return arm.inverse_dynamics
        try:
            from ..newton_euler import NewtonEuler
        except ImportError as error:
            raise ArgumentError('method', f'newton_euler needs Pinocchio: pip install pin, or '
                                f'ros-jazzy-pinocchio from apt ({error})') from None
        return NewtonEuler(arm).inverse_dynamics


SETTINGS = tuple(setting for setting, _ in PredictorSettings().items())
DEFAULTS = {setting.name: setting.default for setting in SETTINGS}
