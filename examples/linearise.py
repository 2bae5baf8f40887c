"""
Linearise the arm about its two equilibria, hanging and upright, and about a state in motion.

Joint stops are ignored: the arm could not hang straight down.

With x = (q, qd) and u = tau, d(dx)/dt = A dx + B du, where A and B come from the gradient of the
inverse dynamics: d(qdd)/dq = -M^-1 d(tau)/dq and d(qdd)/d(qd) = -M^-1 d(tau)/d(qd). Eigenvalues
of A describe the free motion; central differences of the forward dynamics verify A and B.

Run: python examples/linearise.py
"""

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
import numpy as np

STEP = 1e-5  # of the central differences [rad, rad/s, N m]
STILL = np.zeros(7)

ARM = BaxterArm(mount=mount('right'))


def linearise(q, qd, tau):
    """Return A (14, 14) and B (14, 7) of the arm under torques tau, all arguments (7,)."""
    qdd = ARM.forward_dynamics(q, qd, tau)
    dtau_dq, dtau_dqd = ARM.inverse_dynamics_gradient(q, qd, qdd)
    inverse = np.linalg.inv(ARM.mass_matrix(q))
    A = np.block([[np.zeros((7, 7)), np.eye(7)], [-inverse @ dtau_dq, -inverse @ dtau_dqd]])
    return A, np.vstack([np.zeros((7, 7)), inverse])


def differences(q, qd, tau):
    """Return A and B from central differences of the forward dynamics."""
    def rate(x):
        return np.concatenate([x[7:14], ARM.forward_dynamics(x[:7], x[7:14], x[14:])])
    x = np.concatenate([q, qd, tau])
    columns = [(rate(x + step) - rate(x - step)) / (2.0 * STEP) for step in STEP * np.eye(21)]
    return np.transpose(columns[:14]), np.transpose(columns[14:])


def equilibrium(direction):
    """Return q with G(q) = 0, the potential's minimum (direction 1) or maximum (-1)."""
    q = direction * np.array([0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(50):  # Newton's method, always downhill for 1 and uphill for -1
        curvature, axes = np.linalg.eigh(ARM.inverse_dynamics_gradient(q, STILL, STILL)[0])
        slope = axes.T @ ARM.gravity(q)
        q = q - direction * axes @ (slope / np.maximum(np.abs(curvature), 1e-3))  # [N m/rad]
    return q


def describe(eigenvalue):
    """Return a description of a pair of eigenvalues and the motion along their eigenvectors."""
    size = abs(eigenvalue)
    if size < 1e-3:
        return f'+-{size:7.3f}  1/s   drifts: gravity has no effect'
    if abs(eigenvalue.imag) > abs(eigenvalue.real):
        return f'+-{size:7.3f}j 1/s   swings at {size / (2.0 * np.pi):.2f} Hz'
    return f'+-{size:7.3f}  1/s   falls: doubles in {np.log(2.0) / size:.3f} s'


def main():
    """Print the eigenvalues of A, and the error of A and B against finite differences."""
    q, qd, qdd = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 7))
    states = {'hanging': (equilibrium(1), STILL, STILL),
              'upright': (equilibrium(-1), STILL, STILL),
              'in motion': (q, qd, ARM.inverse_dynamics(q, qd, qdd))}
    for name, state in states.items():
        A, B = linearise(*state)
        print(f'{name}, q [rad]:', *(f'{j} {angle:.2f}' for j, angle in zip(JOINTS, state[0])))
        if state[1] is STILL:
            print(f'  |G| <= {np.abs(ARM.gravity(state[0])).max():.0e} N m; eigenvalues of A:')
            for eigenvalue in sorted(np.linalg.eigvals(A), key=abs)[::2]:  # they come in pairs
                print('   ', describe(eigenvalue))
        errors = [np.abs(x - y).max() for x, y in zip((A, B), differences(*state))]
        print('  from finite differences, A differs by {:.1e}, B by {:.1e}'.format(*errors))


if __name__ == '__main__':
    main()
