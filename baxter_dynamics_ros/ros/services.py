"""The two services' answers: gravity torques and inverse dynamics of one arm."""

import numpy as np

from .messages import from_field
from .messages import joint_state
from .messages import stamp_ns
from .messages import to_field
from ..core.exceptions import ArgumentError
from ..core.joints import N_JOINTS
from ..core.validation import finite
from ..signals.events import Event

MAX_AGE = 1.0  # [s]; an older state is not the arm's state any more


class Answers:
    """
    Fill in the responses of the services.

    Parameters
    ----------
    predictor : Predictor
        Supplies the latest state, and the joints' names.
    age : callable
        Time since the arm's last joint state [s].

    """

    def __init__(self, predictor, age):
        self._predictor = predictor
        self._age = age

    def gravity_torques(self, settings, request, response):
        """Answer ``GravityTorques``."""
        try:
            q, stamp, whose = self._position(request.state)
        except ArgumentError as error:
            response.success, response.message = False, str(error)
            return response
        gravity = settings.arm.gravity(q)
        holding = settings.effort_model.effort(gravity, q, np.zeros(N_JOINTS))
        response.success, response.message = True, f'gravity torques at {whose}'
        response.gravity = joint_state(self._names, stamp, position=q, effort=gravity)
        response.actuator_effort = to_field(holding)
        return response

    def inverse_dynamics(self, settings, request, response):
        """Answer ``InverseDynamics``."""
        try:
            q, qd, qdd, stamp, whose = self._motion(request.state, request.acceleration)
        except ArgumentError as error:
            response.success, response.message = False, str(error)
            return response
        mass, coriolis, gravity = settings.arm.terms(q, qd)
        inertial, velocity = mass @ qdd, coriolis @ qd
        tau = inertial + velocity + gravity
        response.success, response.message = True, f'inverse dynamics at {whose}'
        response.torque = joint_state(self._names, stamp, q, qd, tau)
        response.inertial = to_field(inertial)
        response.coriolis = to_field(velocity)
        response.gravity = to_field(gravity)
        response.actuator_effort = to_field(settings.effort_model.effort(tau, q, qd))
        response.mass_matrix = mass.ravel()
        response.coriolis_matrix = coriolis.ravel()
        return response

    @property
    def _names(self):
        return self._predictor.intake.names

    def _position(self, state):
        """Return q, its stamp [ns] and what it is, of a request's state."""
        if len(state.name):
            layout = self._layout(state)
            return self._pick('state.position', state.position, state, layout), stamp_ns(
                state.header), 'the given state'
        _refuse_nameless(state)
        latest = self._predictor.latest
        self._refuse_old(latest)
        return latest.q, latest.stamp_ns, f'the latest measured state, {self._age():.3f} s old'

    def _motion(self, state, acceleration):
        """Return q, qd, qdd, their stamp [ns] and what they are, of a request."""
        if len(state.name):
            layout = self._layout(state)
            return (self._pick('state.position', state.position, state, layout),
                    self._pick('state.velocity', state.velocity, state, layout, optional=True),
                    self._pick('acceleration', acceleration, state, layout, optional=True),
                    stamp_ns(state.header), 'the given state')
        _refuse_nameless(state)
        if len(acceleration):
            raise ArgumentError('acceleration', 'its order is that of state.name, which is '
                                'empty: give the state, too, or leave both empty')
        self._refuse_old(self._predictor.latest)
        now = self._predictor.prediction
        if now is None:
            raise ArgumentError('state', 'the acceleration filter is still settling: ask again '
                                f'in {self._predictor.estimator.settling_time:.2f} s')
        return (now.q, now.qd, now.qdd, now.stamp_ns,
                f'the estimate with the latest measured state, {self._age():.3f} s old')

    def _layout(self, state):
        layout = self._predictor.intake.layout(state.name)
        if layout is Event.DUPLICATE_JOINT:
            raise ArgumentError('state.name', 'names a joint of the arm twice')
        if isinstance(layout, Event):
            missing = [name for name in self._names if name not in state.name]
            raise ArgumentError('state.name', f'lacks {", ".join(missing)}')
        return layout

    def _pick(self, field, values, state, layout, optional=False):
        """Return the arm's values (7,) of a field that is in the order of state.name."""
        if optional and not len(values):
            return np.zeros(N_JOINTS)
        if len(values) != len(state.name):
            raise ArgumentError(field, f'expected {len(state.name)} values, as many as '
                                f'state.name, got {len(values)}')
        return finite(field, from_field(values)[layout], (N_JOINTS,))

    def _refuse_old(self, latest):
        age = self._age()
        if latest is None or age > MAX_AGE:
            since = 'yet' if latest is None else f'for {age:.1f} s'
            raise ArgumentError('state', 'empty, which asks for the latest measured state, but '
                                f'no joint state of {self._names[0]} ... {self._names[-1]} has '
                                f"arrived {since}: give a state, or check the robot's topic")


def _refuse_nameless(state):
    if len(state.position) or len(state.velocity) or len(state.effort):
        raise ArgumentError('state.name', 'empty, but the state has values: joints are matched '
                            'by name')
