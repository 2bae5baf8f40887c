"""BaxterArm with NumPy alone: as it is used, the engine inside it, and the generated function."""

from itertools import cycle, islice
from math import cos, sin

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import _closed_form
import numpy as np

from .engine import CALLS, Engine

PYTHON = 'python'


def engines(arm) -> list:
    """Return the calls of BaxterArm, which check their arguments, and those inside it."""
    arm = BaxterArm(parameters=arm.parameters, gravity=arm.gravity_vector, engine=PYTHON)
    return [*pair('ours, NumPy', arm), _bare(arm.dynamics.constants)]


def pair(name: str, arm) -> list:
    """Return an arm and its engine, as engines of the benchmark."""
    return [_engine(name, arm, 'BaxterArm'),
            _engine(f'{name}, unchecked', arm.dynamics, 'BaxterArm.dynamics')]


def _bare(constants: tuple) -> Engine:
    """Return the generated functions as they are: from floats to floats, sines included."""
    def computed(name):
        function = getattr(_closed_form, f'{name}_upright')
        out = [0.0] * _closed_form.SIZES[name]

        def call(q, *rest):
            function(map(sin, q), map(cos, q), *rest, constants, out)
            return out

        def loop(*arrays):
            rows = list(zip(*(array.tolist() for array in arrays)))

            def run(n):
                for q, *rest in islice(cycle(rows), n):
                    function(map(sin, q), map(cos, q), *rest, constants, out)
            return run
        return call, loop

    tau, tau_loop = computed('inverse_dynamics')
    terms, terms_loop = computed('torque_terms')

    def split(q, qd):
        out = np.array(terms(q, qd))
        return out[:49].reshape(7, 7), out[49:56], out[56:]

    return Engine('ours, NumPy, bare', tau=tau, split=split,
                  loops={'tau': tau_loop, 'split': terms_loop},
                  notes=dict.fromkeys(('tau', 'split'), 'the generated function, on floats'))


def _engine(name: str, calls, note: str) -> Engine:
    return Engine(name, tau=calls.inverse_dynamics, split=calls.torque_terms, matrices=calls.terms,
                  forward=calls.forward_dynamics, batch=calls.inverse_dynamics,
                  notes=dict.fromkeys(CALLS, note))
