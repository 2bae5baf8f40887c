"""
Base parameters: the 43 combinations of the 70 link parameters that determine the torques.

The torques are linear in them, tau = Y(q, qd, qdd) phi. Changing the links in the other 27
directions changes no torque: a point mass on a joint axis can be assigned to either link, and
link 1 contributes only its moment of inertia about its axis. The condition number of Y, stacked
over a motion and with columns scaled to length 1, measures how well the motion identifies phi.

Run: python examples/base_parameters.py
"""

from dataclasses import replace

from baxter_dynamics_ros import BaxterArm, JOINTS
from baxter_dynamics_ros.model.base_parameters import NAMES
from baxter_dynamics_ros.model.lagrange_euler import link_transform
from baxter_dynamics_ros.model.parameters import from_pseudo_inertia
from baxter_dynamics_ros.simulation.exciting_trajectory import motion, series
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory
import numpy as np

ARM = BaxterArm()
TIMES = np.arange(0.0, 60.0, 0.05)  # sample times [s]


def shift_masses(mass, height):
    """Return an arm with point masses [kg] at heights [m] on the axes moved one link inward."""
    p = ARM.parameters
    J = p.pseudo_inertia.copy()
    for i in range(6):
        point = np.array([0.0, 0.0, height[i], 1.0])  # the axis is z of the previous frame
        J[i] += mass[i] * np.outer(point, point)
        point = np.linalg.solve(link_transform(p, i + 1, np.zeros(7)), point)  # for any angle
        J[i + 1] -= mass[i] * np.outer(point, point)
    mass, center, inertia = from_pseudo_inertia(J)
    return BaxterArm(parameters=replace(p, mass=mass, center_of_mass=center, inertia=inertia))


def follow(trajectory):
    """Return q, qd, qdd, each (n, 7), along one of the paper's trajectories."""
    reference, step = HandTrajectory('right', trajectory), TIMES[1] - TIMES[0]
    q = [reference.q]
    while len(q) < len(TIMES):
        reference.advance(step)
        q.append(reference.q)
    qd = np.gradient(q, step, axis=0)
    return np.array(q), qd, np.gradient(qd, step, axis=0)


def main():
    """Print the base parameters, show that they determine the torques, and compare motions."""
    phi, names = ARM.base_parameters, [name[:-1] for name in NAMES]
    print(f's0 {names[0]} {phi[0]:.4f} kg m^2; below, xx to yz in kg m^2, hx and hy in kg m')
    print('  ', *(f'{name:>8}' for name in names[1:8]))
    for joint, row in zip(JOINTS[1:], phi[1:].reshape(6, 7)):
        print(joint, *(f'{x:8.4f}' for x in row))

    states = np.random.default_rng(0).uniform(-2.0, 2.0, (3, 1000, 7))  # q, qd, qdd
    tau = ARM.inverse_dynamics(*states)
    print(f'\n|Y phi - tau| <= {np.abs(ARM.regressor(*states) @ phi - tau).max():.0e} N m')
    other = shift_masses((1.0, 0.8, 0.6, 0.4, 0.2, 0.1), (0.0, 0.28, 0.0, 0.24, 0.0, 0.17))
    for arm in (ARM, other):
        print('links of', *(f'{mass:.2f}' for mass in arm.parameters.mass), 'kg, eigenvalues of J '
              f'>= {np.linalg.eigvalsh(arm.parameters.pseudo_inertia).min():.1e}')
    print('their torques differ by', f'{np.abs(other.inverse_dynamics(*states) - tau).max():.0e}',
          'N m, their base parameters by', f'{np.abs(other.base_parameters - phi).max():.0e}')

    print('\ncondition number of Y')
    motions = {'random states': states, 'exciting trajectory': motion(series('right'), TIMES),
               **{name: follow(name) for name in ('circle', 'switch', 'lift')}}
    for name, states in motions.items():
        Y = ARM.regressor(*states).reshape(-1, 43)
        print(f'{name:19} {np.linalg.cond(Y / np.linalg.norm(Y, axis=0)):8.0f}')


if __name__ == '__main__':
    main()
