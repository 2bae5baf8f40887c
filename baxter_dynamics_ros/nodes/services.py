"""Services of one arm: gravity torques and inverse dynamics."""

from array import array
from typing import Any, NamedTuple

import numpy as np
from sensor_msgs.msg import JointState

from .messages import from_field, joint_state, stamp_ns, to_field
from .step_statistics import MAX_AGE, StepStatistics
from ..estimation.events import Event
from ..estimation.predictor import Predictor
from ..estimation.stream import PLAUSIBLE_POSITION, PLAUSIBLE_VELOCITY
from ..model import ArgumentError, Array, finite, Indices, N_JOINTS

# Fields of a request and their largest plausible values [rad, rad/s, rad/s^2].
_PLAUSIBLE = {'state.position': PLAUSIBLE_POSITION, 'state.velocity': PLAUSIBLE_VELOCITY,
              'acceleration': 1e4}
_ZERO = np.zeros(N_JOINTS)


class _Motion(NamedTuple):
    """Motion for which a request is answered; arrays (7,) in joint order."""

    origin: str  # description for the answer
    stamp_ns: int
    q: Array  # [rad]
    qd: Array = _ZERO  # [rad/s]
    qdd: Array = _ZERO  # [rad/s^2]
    presliding: 'Array | None' = None  # Dahl's state [-]


class DynamicsServices:
    """Handlers of the services gravity_torques and inverse_dynamics."""

    def __init__(self, predictor: Predictor, statistics: StepStatistics) -> None:
        self._names = predictor.stream.selector.names
        self._predictor = predictor
        self._statistics = statistics

    def gravity_torques(self, request: Any, response: Any) -> Any:
        """Handle a request of ``GravityTorques``."""
        state = request.state
        try:
            motion = self._given(state) if len(state.name) else self._latest(state)
        except ArgumentError as error:
            response.message = str(error)
            return response
        model = self._predictor.model
        gravity = model.arm.gravity(motion.q)
        response.gravity = joint_state(self._names, motion.stamp_ns, motion.q, effort=gravity)
        response.actuator_effort = to_field(
            model.effort_model.effort(gravity, motion.q, _ZERO, _ZERO))
        return self._succeed(response, 'gravity torques', motion)

    def inverse_dynamics(self, request: Any, response: Any) -> Any:
        """Handle a request of ``InverseDynamics``."""
        state, acceleration = request.state, request.acceleration
        try:
            motion = (self._given(state, state.velocity, acceleration) if len(state.name)
                      else self._estimate(state, acceleration))
        except ArgumentError as error:
            response.message = str(error)
            return response
        _, stamp, q, qd, qdd, presliding = motion
        model = self._predictor.model
        mass, coriolis, gravity = model.arm.terms(q, qd)
        inertial, velocity = mass @ qdd, coriolis @ qd
        tau = inertial + velocity + gravity
        response.torque = joint_state(self._names, stamp, q, qd, tau)
        response.inertial = to_field(inertial)
        response.coriolis = to_field(velocity)
        response.gravity = to_field(gravity)
        response.actuator_effort = to_field(model.effort_model.effort(tau, q, qd, qdd, presliding))
        response.mass_matrix = mass.ravel()
        response.coriolis_matrix = coriolis.ravel()
        return self._succeed(response, 'inverse dynamics', motion)

    def _succeed(self, response: Any, result: str, motion: _Motion) -> Any:
        is_held = self._predictor.model.effort_model.spring_is_held(motion.q)
        response.success = True
        response.message = f'{result} at {motion.origin}' + (
            f'; {Event.SPRING_HELD.remedy}' if is_held else '')
        return response

    def _given(self, state: JointState, *optional: 'array[float]') -> _Motion:
        """Return the motion of a request: its position, and velocity and acceleration if used."""
        layout = self._predictor.stream.selector.layout(state.name)
        if layout is Event.DUPLICATE_JOINT:
            raise ArgumentError('state.name', 'names a joint of the arm twice')
        if isinstance(layout, Event):
            missing = [name for name in self._names if name not in state.name]
            raise ArgumentError('state.name', f'lacks {", ".join(missing)}')
        position, *others = _PLAUSIBLE
        return _Motion('the given state', stamp_ns(state.header),
                       _pick(position, state.position, state, layout),
                       *(_pick(field, values, state, layout) if len(values) else _ZERO
                         for field, values in zip(others, optional)))

    def _latest(self, state: JointState) -> _Motion:
        """Return the latest measured position, if it is not out of date."""
        if len(state.position) or len(state.velocity) or len(state.effort):
            raise ArgumentError('state.name', 'empty although the state has values: joints are '
                                'matched by name')
        latest, age = self._statistics.accepted.state, self._statistics.age
        if latest is None or age > MAX_AGE:
            since = 'yet' if latest is None else f'for {age:.1f} s'
            raise ArgumentError('state', 'empty, which selects the latest measured state, but no '
                                f'valid joint state of {self._names[0]} ... {self._names[-1]} '
                                f'has arrived {since}: give a state, or see the diagnostics')
        return _Motion(f'the latest measured state, {age:.3f} s old', latest.stamp_ns, latest.q)

    def _estimate(self, state: JointState, acceleration: 'array[float]') -> _Motion:
        """Return the latest estimate, if it is not out of date."""
        if len(acceleration):
            raise ArgumentError('acceleration', 'has the order of state.name, which is empty: '
                                'give the state as well, or leave both empty')
        latest = self._latest(state)
        now = self._statistics.predicted.estimate
        if now is None or latest.stamp_ns - now.stamp_ns > MAX_AGE * 1e9:
            raise ArgumentError('state', 'the acceleration filter has no estimate yet: it settles '
                                f'within {self._predictor.estimator.settling_time:.2f} s of a '
                                'start; if it does not, see the diagnostics')
        behind = (latest.stamp_ns - now.stamp_ns) * 1e-6
        return _Motion(f'the estimate for {behind:.0f} ms before {latest.origin}',
                       now.stamp_ns, now.q, now.qd, now.qdd, now.presliding)


def _pick(field: str, values: 'array[float]', state: JointState, layout: Indices) -> Array:
    """Return the arm's values (7,) of a field that is in the order of state.name."""
    if len(values) != len(state.name):
        raise ArgumentError(field, f'expected {len(state.name)} values, one per state.name, '
                            f'got {len(values)}')
    result = finite(field, from_field(values)[layout], (N_JOINTS,))
    largest = result[np.abs(result).argmax()]
    if abs(largest) > _PLAUSIBLE[field]:
        raise ArgumentError(
            field, f'expected at most {_PLAUSIBLE[field]:g} (rad, s), got {largest:g}')
    return result
