"""Momentum observer: law, sign, settling time, zero steps and changes of the model."""

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.estimation.external import MomentumObserver
import numpy as np
from perfect_robot import trajectory as motion
import pytest

GAIN = 10.0  # [1/s]
PUSH = np.array([3.0, -2.0, 1.5, -1.0, 0.5, 0.3, -0.2])  # tau_ext [N m]
ZERO = np.zeros(7)


def observe(period, duration=2.0, push=PUSH, arm=None, gain=GAIN):
    """Return r (n, 7) of a moving arm under a constant push, without noise."""
    arm = arm or BaxterArm()
    q, qd, qdd = motion(period * np.arange(round(duration / period) + 1))
    tau = arm.inverse_dynamics(q, qd, qdd) - push
    momentum, coriolis, gravity = arm.momentum_terms(q, qd)
    observer = MomentumObserver(gain)
    return np.array([observer.update(period, *row)
                     for row in zip(momentum, tau + coriolis - gravity)])


@pytest.mark.parametrize('gain', [2.0, 10.0, 40.0])
def test_external_torque_is_approached_exponentially(arm, gain):
    period, settling = 1e-4, MomentumObserver(gain).settling_time
    r = observe(period, settling, arm=arm, gain=gain)
    t = period * np.arange(len(r))[:, None]
    np.testing.assert_allclose(r, PUSH * (1.0 - np.exp(-gain * t)), atol=0.01)
    np.testing.assert_allclose(r[-1], 0.99 * PUSH, atol=2e-3)


def test_error_in_free_motion_is_of_first_order_in_the_step():
    errors = [np.abs(observe(period, push=ZERO)).max() for period in (0.02, 0.01, 0.005)]
    np.testing.assert_allclose(errors[:-1], 2.0 * np.array(errors[1:]), rtol=0.1)


def test_agrees_with_the_momentum_of_an_independent_engine(engine, pin):
    from baxter_dynamics_ros.newton_euler import build_model
    arm = BaxterArm(payload=Payload(1.2, (0.03, -0.02, 0.11)))
    reference = engine(build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount))
    t = 0.01 * np.arange(100)
    q, qd, qdd = motion(t)
    mass, coriolis = reference.mass_matrix(q), reference.coriolis_matrix(q, qd)
    momentum = np.einsum('nij,nj->ni', mass, qd)
    rate = (reference.inverse_dynamics(q, qd, qdd) - PUSH
            + np.einsum('nji,nj->ni', coriolis, qd) - reference.gravity(q))
    observer = MomentumObserver(GAIN)
    expected = np.array([observer.update(0.01, *row) for row in zip(momentum, rate)])
    np.testing.assert_allclose(observe(0.01, 0.99, arm=arm), expected, atol=1e-9)


@pytest.mark.parametrize('gain', [2.0, 10.0, 40.0])
def test_solves_the_integral_equation(gain, rng):
    observer, integral, first = MomentumObserver(gain), 0.0, None
    for _ in range(200):
        dt, momentum, rate = 10.0 ** rng.uniform(-4.0, 1.0), rng.normal(size=7), rng.normal(size=7)
        r = observer.update(dt, momentum, rate)
        if first is None:
            first = momentum
        else:
            integral = integral + (rate + r) * dt
        np.testing.assert_allclose(r, gain * (momentum - integral - first), atol=1e-9)


def test_a_dt_of_zero_is_harmless():
    with_, without = MomentumObserver(GAIN), MomentumObserver(GAIN)
    for k in range(20):
        momentum, rate = 0.1 * k * PUSH, np.cos(k) * PUSH
        r = with_.update(0.01, momentum, rate)
        np.testing.assert_array_equal(with_.update(0.0, momentum, rate), r)
        np.testing.assert_allclose(r, without.update(0.01, momentum, rate), atol=1e-12)


def test_reset_forgets():
    observer = MomentumObserver(GAIN)
    for _ in range(10):
        observer.update(0.01, PUSH, -PUSH)
    observer.reset()
    observer.rebase(PUSH, PUSH)  # nothing to change before the first sample
    np.testing.assert_array_equal(observer.update(0.01, -PUSH, ZERO), ZERO)


def test_a_change_of_the_model_in_motion_is_not_seen_as_a_push():
    before, after, period = BaxterArm(), BaxterArm(payload=Payload(2.0)), 1e-3
    q, qd, qdd = motion(period * np.arange(1000))
    observer, r = MomentumObserver(GAIN), []
    for k, row in enumerate(zip(q, qd, qdd)):
        arm = before if k < 500 else after
        if k == 500:
            last = q[k - 1], qd[k - 1]
            change = after.momentum_terms(*last)[0] - before.momentum_terms(*last)[0]
            assert np.abs(GAIN * change).max() > 2.0  # the error without it
            observer.rebase(change, ZERO)
        momentum, coriolis, gravity = arm.momentum_terms(*row[:2])
        r.append(observer.update(period, momentum,
                                 arm.inverse_dynamics(*row) + coriolis - gravity))
    assert np.abs(r).max() < 0.02
