"""
Two properties used in stability proofs: dM/dt - 2 C is skew-symmetric, and the arm is passive.

First, x^T (dM/dt - 2 C) x = 0 for any x, with dM/dt from differences of M; it fails for another
matrix C' with the same torques, C' qd = C qd. Second, the energy E = qd^T M qd / 2 + P of a driven
arm changes by the work of the torques, up to an integration error that decreases with the fourth
power of the step.

Run: python examples/passivity.py
"""

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model.lagrange_euler import transform
import numpy as np

DURATION = 2.0  # [s]
STEPS = (0.02, 0.01, 0.005, 0.0025)  # integration steps [s]
DRIVE = np.array([5.0, 5.0, 2.0, 2.0, 0.05, 0.1, 0.001])  # torque amplitudes [N m]
START = np.array([0.0, -0.5, 0.0, 1.0, 0.0, 0.5, 0.0])  # [rad]

ARM = BaxterArm()


def matrices(q, qd):
    """Return dM/dt by differences, the Christoffel matrix C, and a C' with the same torques."""
    dt = 1e-5  # [s]
    mass_rate = (ARM.mass_matrix(q + dt * qd) - ARM.mass_matrix(q - dt * qd)) / (2.0 * dt)
    h = ARM.christoffel_symbols(q)
    gradient = h + h.swapaxes(-3, -2)  # dM_ik/dq_m
    other = (np.einsum('nikm,nm->nik', gradient, qd)
             - np.einsum('nmki,nm->nik', gradient, qd) / 2.0)
    return mass_rate, np.einsum('nikm,nm->nik', h, qd), other


def energy(q, qd):
    """Return the sum of kinetic and potential energy of one state, eq. (4) [J]."""
    p = ARM.parameters
    moment = sum(transform(p, 0, j + 1, q) @ p.pseudo_inertia[j, :, 3] for j in range(7))
    return qd @ ARM.mass_matrix(q) @ qd / 2.0 - ARM.gravity_vector @ moment[:3]


def rate(t, x):
    """Return the rate of change of x = (q, qd, work of the torques)."""
    q, qd = x[:7], x[7:14]
    tau = ARM.gravity(q) + DRIVE * np.cos(5.0 * t)
    return np.concatenate([qd, ARM.forward_dynamics(q, qd, tau), [qd @ tau]])


def move(step):
    """Return the change of energy and the work [J], by the classical Runge-Kutta method."""
    x = np.concatenate([START, np.zeros(8)])
    for t in step * np.arange(round(DURATION / step)):
        k1 = rate(t, x)
        k2 = rate(t + step / 2.0, x + step / 2.0 * k1)
        k3 = rate(t + step / 2.0, x + step / 2.0 * k2)
        k4 = rate(t + step, x + step * k3)
        x = x + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return energy(x[:7], x[7:14]) - energy(START, np.zeros(7)), x[14]


def main():
    """Print numerical evidence for both properties."""
    q, qd, x = np.random.default_rng(0).uniform(-2.0, 2.0, (3, 1000, 7))  # [rad, rad/s, any]
    mass_rate, *candidates = matrices(q, qd)
    print('largest of 1000 states |x^T (dM/dt - 2 C) x|  |C qd - torque| [N m]')
    for name, c in zip(('Christoffel C', "another, C'"), candidates):
        form = np.einsum('ni,nik,nk->n', x, mass_rate - 2.0 * c, x)
        error = np.einsum('nik,nk->ni', c, qd) - ARM.coriolis_torque(q, qd)
        print(f'{name:22} {np.abs(form).max():22.1e} {np.abs(error).max():22.1e}')
    print(f'\n{"step [s]":>9} {"change of E [J]":>18} {"work [J]":>15} {"difference [J]":>17}')
    for step in STEPS:
        change, work = move(step)
        print(f'{step:9.4f} {change:18.9f} {work:15.9f} {change - work:17.1e}')


if __name__ == '__main__':
    main()
