"""Noise of residuals: correlation time, weights of outliers, expected deviation."""

import numpy as np
from scipy.optimize import nnls

from ..model.arrays import Array
from ..model.effort import BAND
from ..model.joints import N_JOINTS

_TAIL = 4.0  # degrees of freedom of the residuals' t distribution
_COVERED = 0.95  # share of residuals within BAND deviations

# Lower bound of the correlation time [s]: model errors recur with the motion.
SHORTEST = 1.0


def correlation_times(residuals: list[Array], periods: list[float]) -> Array:
    """
    Return the correlation times (7,) [s] of residuals (n, 7) of recordings with some periods [s].

    The integral of their autocorrelation, summed to where it has become small (Sokal's window).
    """
    times = []
    for joint in range(N_JOINTS):
        parts = []
        for residual, period in zip(residuals, periods):
            x = residual[:, joint] - residual[:, joint].mean()
            spectrum = np.abs(np.fft.rfft(x, 2 * len(x))) ** 2
            correlation = np.fft.irfft(spectrum)[:len(x)]
            if correlation[0] == 0.0:
                continue
            integral = 2 * np.cumsum(correlation / correlation[0]) - 1
            window = np.flatnonzero(np.arange(len(x)) >= 5 * integral)
            parts.append(period * integral[window[0] if len(window) else -1])
        times.append(max(np.mean(parts), SHORTEST) if parts else SHORTEST)
    return np.array(times)


def robust_weights(residuals: list[Array]) -> list[Array]:
    """
    Return weights of residuals (n, 7), those of a t distribution: one half at two deviations.

    A short touch then hardly changes a fit.
    """
    scale = 1.4826 * np.median(np.abs(np.concatenate(residuals)), axis=0)
    return [1.0 / (1.0 + (residual / np.maximum(scale, 1e-9)) ** 2 / _TAIL)
            for residual in residuals]


def expected_deviation(residual: Array, qd: Array, qdd: Array) -> tuple[Array, ...]:
    """
    Return standard deviations (7,) of residuals at rest, per velocity and per acceleration.

    The squares of residual [N m], velocity [rad/s] and acceleration [rad/s^2], (n, 7), are
    related by least squares; the scale is such that 95 % of the residuals are within 1.96.
    """
    parts = np.stack([np.ones(qd.shape), qd ** 2, qdd ** 2], axis=-1)
    result = np.zeros((N_JOINTS, 3))
    for joint in range(N_JOINTS):
        x, y = parts[:, joint], residual[:, joint] ** 2
        variance = np.full(len(y), y.mean() + 1e-9)
        for _ in range(5):  # the deviation of a square is proportional to the variance
            square, _ = nnls(x / variance[:, None], y / variance)
            variance = x @ square + 1e-9
        scale = np.quantile(np.sqrt(y / variance), _COVERED) / BAND
        result[joint] = scale * np.sqrt(square)
    return tuple(result.T)
