"""BaxterArm with NumPy alone: as it is used, and the engine inside it."""

from baxter_dynamics_ros import BaxterArm

from .engine import CALLS
from .engine import Engine

PYTHON = 'python'


def engines(arm) -> list:
    """Return the calls of BaxterArm, which check their arguments, and those inside it."""
    return pair('ours, NumPy', BaxterArm(
        parameters=arm.parameters, gravity=arm.gravity_vector, engine=PYTHON))


def pair(name: str, arm) -> list:
    """Return an arm and its engine, as engines of the benchmark."""
    return [_engine(name, arm, 'BaxterArm'),
            _engine(f'{name}, unchecked', arm.dynamics, 'BaxterArm.dynamics')]


def _engine(name: str, calls, note: str) -> Engine:
    return Engine(name, tau=calls.inverse_dynamics, split=calls.torque_terms, matrices=calls.terms,
                  forward=calls.forward_dynamics, batch=calls.inverse_dynamics,
                  notes=dict.fromkeys(CALLS, note))
