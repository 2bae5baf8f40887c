"""Robot whose effort is fully modelled and whose velocity lags like that of a real robot."""

from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np

VELOCITY_LAG = 0.014  # [s]


def sum_of_sines(t, center, amplitude, w, phase) -> tuple:
    """Return q, qd, qdd (n, 7) at times t (n,) [s]: k sines per joint, (k, 7), w in rad/s."""
    angle = w * np.asarray(t)[:, None, None] + phase
    return (center + (amplitude * np.sin(angle)).sum(1), (amplitude * w * np.cos(angle)).sum(1),
            -(amplitude * w ** 2 * np.sin(angle)).sum(1))


def trajectory(t, scale=1.0) -> tuple:
    """Return q, qd, qdd (n, 7) at times t (n,) [s]: a slow sine per joint, s1 in spring range."""
    amplitude = scale * np.array([0.4, 0.3, 0.4, 0.4, 0.5, 0.5, 0.5])  # [rad]
    w = 2 * np.pi * np.array([0.3, 0.25, 0.35, 0.3, 0.4, 0.45, 0.5])  # [rad/s]
    return sum_of_sines(t, [0.0, -0.5, 0.0, 1.2, 0.0, 0.6, 0.0], amplitude, w, np.arange(7))


_RNG = np.random.default_rng(1)
_AMPLITUDE = _RNG.uniform(0.05, 0.2, (3, 7))  # [rad]
_PHASE = _RNG.uniform(0.0, 2 * np.pi, (3, 7))  # [rad]
_FREQUENCY = 2 * np.pi * np.array([[0.2], [0.5], [0.9]])  # [rad/s]


def sines(t) -> tuple:
    """Return q, qd, qdd (n, 7) at times t (n,) [s]: a sum of three sines per joint."""
    return sum_of_sines(t, 0.0, _AMPLITUDE, _FREQUENCY, _PHASE)


def rows(t, settings=PredictorSettings()) -> list:
    """Return what is measured at each of the times t (n,) [s]: (q, qd, effort), (7,) each."""
    return list(zip(*measured(settings, t)))


def measured(settings, t, motion=trajectory) -> tuple:
    """Return measured position, velocity and effort (n, 7) at times t (n,) [s]."""
    q, qd, qdd = motion(t)
    effort = settings.model.effort_model.effort(
        settings.model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd)
    return q, motion(t - VELOCITY_LAG)[1], effort
