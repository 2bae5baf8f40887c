"""
Time the model's calls on one state against Pinocchio's, alternating, in one run.

Run: python benchmarks/model.py
"""

from statistics import median
from time import perf_counter

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.core import lagrange_euler
from baxter_dynamics_ros.newton_euler import NewtonEuler
import numpy as np
import pinocchio as pin

ROUNDS = 40
CALLS = 200


def main():
    """Print one table: microseconds a call, and the ratio to ``pin.rnea``."""
    arm = BaxterArm()
    reference = NewtonEuler(arm)
    model, data = reference.model, reference.data
    q, qd, qdd = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 7))

    def pinocchio_terms():
        return (pin.crba(model, data, q), pin.computeCoriolisMatrix(model, data, q, qd),
                pin.computeGeneralizedGravity(model, data, q))

    agree(arm, pinocchio_terms, reference, q, qd, qdd)
    calls = {
        'pin.rnea': lambda: pin.rnea(model, data, q, qd, qdd),
        "Pinocchio's M, C, G (three calls)": pinocchio_terms,
        'pin.aba': lambda: pin.aba(model, data, q, qd, qdd),
        'BaxterArm.terms: M, C, G': lambda: arm.terms(q, qd),
        'BaxterArm.inverse_dynamics': lambda: arm.inverse_dynamics(q, qd, qdd),
        'BaxterArm.forward_dynamics': lambda: arm.forward_dynamics(q, qd, qdd),
        'BaxterArm.mass_matrix': lambda: arm.mass_matrix(q),
        'BaxterArm.gravity': lambda: arm.gravity(q),
    }
    times = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            start = perf_counter()
            for _ in range(CALLS):
                call()
            times[name].append((perf_counter() - start) / CALLS * 1e6)
    specification = time_specification(arm, q, qd, qdd)
    times['the specification, eqs. (5) to (11)'] = specification
    base = median(times['pin.rnea'])
    print(f'{"one state":40} {"median us":>10} {"min us":>10} {"/ pin.rnea":>10}')
    for name, each in times.items():
        print(f'{name:40} {median(each):10.1f} {min(each):10.1f} {median(each) / base:10.1f}')


def agree(arm, pinocchio_terms, reference, q, qd, qdd):
    """Refuse to time what does not agree."""
    mass, coriolis, gravity = arm.terms(q, qd)
    their_mass, their_coriolis, their_gravity = pinocchio_terms()
    assert np.abs(np.triu(mass - their_mass)).max() < 1e-12  # crba fills the upper triangle
    assert np.abs(coriolis - their_coriolis).max() < 1e-12
    assert np.abs(gravity - their_gravity).max() < 1e-12
    tau = arm.inverse_dynamics(q, qd, qdd)
    assert np.abs(tau - reference.inverse_dynamics(q, qd, qdd)).max() < 1e-12


def time_specification(arm, q, qd, qdd):
    """Time a few calls of the equations as printed."""
    times = []
    for _ in range(3):
        start = perf_counter()
        lagrange_euler.inverse_dynamics(arm.parameters, q, qd, qdd, arm.gravity_vector)
        times.append((perf_counter() - start) * 1e6)
    return times


if __name__ == '__main__':
    main()
