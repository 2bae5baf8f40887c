"""
The 43 base parameters: all that torques can tell of the links' 70 masses, moments and inertias.

The torques are linear in them, tau = Y(q, qd, qdd) phi. In the other 27 directions the links can
change and no torque does: a point mass on a joint's axis belongs to either of the links it joins,
and of link 1 only the moment of inertia about its axis is felt. How well a motion tells the 43
apart is the condition number of Y stacked over it, with its columns scaled to length 1.

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
TIMES = np.arange(0.0, 60.0, 0.05)  # of a motion's samples [s]


def hand_on(mass, height):
    """Return an arm with point masses [kg] at heights [m] on axes given to the links before."""
    p = ARM.parameters
    J = p.pseudo_inertia.copy()
    for i in range(6):
        point = np.array([0.0, 0.0, height[i], 1.0])  # the axis is z of the frame before
        J[i] += mass[i] * np.outer(point, point)
        point = np.linalg.solve(link_transform(p, i + 1, np.zeros(7)), point)  # at any angle
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
    """Print the parameters, that they are all that is felt, and which motions show them."""
    phi, names = ARM.base_parameters, [name[:-1] for name in NAMES]
    print(f's0 {names[0]} {phi[0]:.4f} kg m^2; below, xx to yz in kg m^2, hx and hy in kg m')
    print('  ', *(f'{name:>8}' for name in names[1:8]))
    for joint, row in zip(JOINTS[1:], phi[1:].reshape(6, 7)):
        print(joint, *(f'{x:8.4f}' for x in row))

    states = np.random.default_rng(0).uniform(-2.0, 2.0, (3, 1000, 7))  # q, qd, qdd
    tau = ARM.inverse_dynamics(*states)
    print(f'\n|Y phi - tau| <= {np.abs(ARM.regressor(*states) @ phi - tau).max():.0e} N m')
    other = hand_on((1.0, 0.8, 0.6, 0.4, 0.2, 0.1), (0.0, 0.28, 0.0, 0.24, 0.0, 0.17))
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
