"""Physical laws that hold for any arm."""

from baxter_dynamics_ros.model import lagrange_euler
import numpy as np

STEP = 3e-4  # of the fourth-order differences: truncation and rounding are both near 1e-11


def test_mass_matrix_is_symmetric_and_positive_definite(arm, random_states):
    mass = arm.mass_matrix(random_states(3000)[0])
    np.testing.assert_array_equal(mass, mass.swapaxes(-1, -2))
    assert np.linalg.eigvalsh(mass).min() > 1e-4  # kg m^2; least found: 5e-4


def test_mass_matrix_gives_the_kinetic_energy_of_the_bodies(arm, random_states):
    # K = sum m v.v / 2 + w.I w / 2 over links and payload, velocities by differences of eq. (2).
    q, qd, _ = random_states(300)
    kinetic = 0.0
    for frame, mass, center, inertia in _bodies(arm):
        motion = _derivative(lambda t: frame(q + t * qd))
        pose = frame(q)
        velocity = (motion @ np.append(center, 1.0))[:, :3]
        spin = pose[:, :3, :3].swapaxes(-1, -2) @ motion[:, :3, :3]  # R^T dR/dt, in the body
        omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
        kinetic = kinetic + (mass * _dot(velocity, velocity)
                             + _dot(omega, omega @ inertia)) / 2
    np.testing.assert_allclose(_kinetic_energy(arm, q, qd), kinetic, rtol=0.0, atol=1e-9)


def test_mass_rate_minus_twice_coriolis_is_skew(arm, random_states):
    q, qd, _ = random_states(300)
    mass_rate = _derivative(lambda t: arm.mass_matrix(q + t * qd))
    difference = mass_rate - 2 * arm.coriolis_matrix(q, qd)
    np.testing.assert_allclose(difference, -difference.swapaxes(-1, -2), rtol=0.0, atol=1e-9)


def test_gravity_is_the_gradient_of_potential_energy(arm, random_states):
    q, _, _ = random_states(300)
    gradient = np.stack([_derivative(lambda t: _potential_energy(arm, q + t * unit))
                         for unit in np.eye(7)], axis=-1)
    np.testing.assert_allclose(arm.gravity(q), gradient, rtol=0.0, atol=1e-9)


def test_free_motion_conserves_energy(arm, random_states):
    # Runge and Kutta's method is of order four: half the step, a sixteenth of the drift.
    q, qd, _ = random_states(20, speed=1.0)
    drift = [np.abs(_energy(arm, *_fall(arm, q, qd, 0.2, step)) - _energy(arm, q, qd)).max()
             for step in (2e-3, 1e-3)]
    assert drift[1] < 2e-8  # J, of energies of 10 J
    assert 12 < drift[0] / drift[1] < 20


def _derivative(f):
    """Return df/dt at 0 by a central difference of fourth order."""
    return (f(-2 * STEP) - 8 * f(-STEP) + 8 * f(STEP) - f(2 * STEP)) / (12 * STEP)


def _dot(x, y):
    return np.einsum('...i,...i->...', x, y)


def _bodies(arm):
    """Yield frame in the base (a function of q), mass, centre and inertia of each body."""
    p = arm.parameters
    for j in range(7):
        yield (lambda q, j=j: arm.mount @ lagrange_euler.transform(p, 0, j + 1, q),
               p.mass[j], p.center_of_mass[j], p.inertia[j])
    yield (lambda q: arm.mount @ lagrange_euler.transform(p, 0, 7, q),
           arm.payload.mass, np.array(arm.payload.center_of_mass), arm.payload.inertia_tensor)


def _kinetic_energy(arm, q, qd):
    return _dot(qd, (arm.mass_matrix(q) @ qd[..., None])[..., 0]) / 2


def _potential_energy(arm, q):
    """Return P (...) [J] of eq. (4), from the positions of the centres of mass."""
    return -sum(mass * (frame(q) @ np.append(center, 1.0))[..., :3] @ arm.gravity_vector
                for frame, mass, center, _ in _bodies(arm))


def _energy(arm, q, qd):
    return _kinetic_energy(arm, q, qd) + _potential_energy(arm, q)


def _fall(arm, q, qd, duration, step):
    """Return the state after ``duration`` [s] without torque, by the classical Runge-Kutta."""
    def rate(x):
        return np.stack([x[1], arm.forward_dynamics(x[0], x[1], np.zeros(7))])
    x = np.stack([q, qd])
    for _ in range(round(duration / step)):
        k1 = rate(x)
        k2 = rate(x + step / 2 * k1)
        k3 = rate(x + step / 2 * k2)
        k4 = rate(x + step * k3)
        x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x
