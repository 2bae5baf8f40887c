"""
Dynamic manipulability ellipsoid of the hand (Yoshikawa, 1985).

Torques tau = G + L u, |u| <= 1, L = diag(limit - |G|), stay within their limits and accelerate the
hand of an arm at rest by J M^-1 L u [m/s^2]. These accelerations form an ellipsoid; its axes are
the singular vectors and values, and w_d is the product of the values. The kinematic measure
w = sqrt(det(J J^T)) ignores inertia and gravity. J is the linear part of the hand Jacobian.

Run: python examples/manipulability.py
"""

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory
import numpy as np

TORQUE_LIMIT = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])  # [N m]
DURATION, STEP = 14.0, 0.01  # duration of the trajectory and time step of its reference [s]

ARM = BaxterArm(mount=mount('right'))


def ellipsoid(q):
    """Return axes (3, 3, columns), half lengths (3,) [m/s^2], and the torques L u (7, 3) [N m]."""
    scale = TORQUE_LIMIT - np.abs(ARM.gravity(q))
    jacobian = ARM.jacobian(q)[:3]
    axes, lengths, u = np.linalg.svd(
        jacobian @ np.linalg.solve(ARM.mass_matrix(q), np.diag(scale)), full_matrices=False)
    return axes, lengths, scale[:, None] * u.T


def measures(q):
    """Return w [m^3] and w_d [(m/s^2)^3]."""
    return (np.prod(np.linalg.svd(ARM.jacobian(q)[:3], compute_uv=False)),
            np.prod(ellipsoid(q)[1]))


def pose_report(q):
    """Print the ellipsoid at a posture, verified with the forward dynamics."""
    axes, lengths, torques = ellipsoid(q)
    print('hand at', *np.round(ARM.forward_kinematics(q)[:3, 3], 3), 'm')
    print('      half axis  along x y z of the base  by forward dynamics')
    for name, axis, length, torque in zip(('best', '', 'worst'), axes.T, lengths, torques.T):
        qdd = ARM.forward_dynamics(q, np.zeros(7), ARM.gravity(q) + torque)
        reached = axis @ ARM.jacobian(q)[:3] @ qdd
        print(f'{name:5} {length:6.2f} m/s^2  ' + ' '.join(f'{x:7.3f}' for x in axis)
              + f'  {reached:6.2f} m/s^2')


def main():
    """Print the ellipsoid at the start of trajectory 3(c), and both measures along it."""
    reference = HandTrajectory('right', 'lift')
    pose_report(reference.q)
    print(' t [s]  z [m]   w [m^3]  w_d [(m/s^2)^3]')
    for k in range(round(DURATION / STEP) + 1):
        if k % 100 == 0:
            w, w_d = measures(reference.q)
            z = ARM.forward_kinematics(reference.q)[2, 3]
            print(f'{k * STEP:6.1f} {z:6.3f} {w:9.4f} {w_d:16.0f}')
        reference.advance(STEP)


if __name__ == '__main__':
    main()
