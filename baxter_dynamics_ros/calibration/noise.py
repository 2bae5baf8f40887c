"""Correlation time of residuals, which determines the effective number of samples."""

import numpy as np

from ..model.arrays import Array
from ..model.joints import N_JOINTS

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
