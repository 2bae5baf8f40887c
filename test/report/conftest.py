"""What the tests of the reports share: an evaluation of signals that are known."""

from baxter_dynamics_ros.offline.results import Band
from baxter_dynamics_ros.offline.results import ErrorStatistics
from baxter_dynamics_ros.offline.results import ESTIMATORS
from baxter_dynamics_ros.offline.results import Evaluation
from baxter_dynamics_ros.offline.results import METHODS
from baxter_dynamics_ros.offline.results import TERMS
import numpy as np
import pytest

AMPLITUDE = np.array([5.0, 20.0, 3.0, 8.0, 0.5, 0.6, 0.1])  # of the measured effort [N m]
OFFSET = np.array([0.5, -0.25, 0.125, 0.01, -0.02, 0.03, 0.08])  # of the error [N m]
PERIOD = 0.02  # [s]
GAP = slice(400, 450)  # samples that are missing: 1 s


@pytest.fixture(scope='session')
def evaluate():
    """Return a function that makes what would be found about n samples, one an interval."""
    return _evaluate


@pytest.fixture(scope='session')
def too_short():
    """Return what is found about a recording on which nothing can be predicted."""
    none = {signal: Band(np.zeros((0, 7)), np.zeros((0, 7))) for signal in METHODS}
    return Evaluation('too short', '/robot/joint_states', 'right', 0.0, 0.0, {'received': 1},
                      ('nothing could be predicted',), {}, {}, {}, np.zeros(0), none)


def _evaluate(name='run', effort=True, warnings=(), n=1000, empty=GAP, apart=0.0):
    time = (np.arange(n) + 0.5) * PERIOD
    measured = AMPLITUDE * np.sin(np.outer(time, np.linspace(1.0, 2.0, 7)))
    measured[:, 6] = 0.1  # so that it has no correlation
    error = OFFSET + 0.2 * np.sin(np.outer(time, np.linspace(5.0, 9.0, 7)))
    noise = np.random.default_rng(3).normal(0.0, 3.0, error.shape)
    errors = {'lagrange_euler': error, 'newton_euler': error + apart,
              'first_difference': error + noise, 'butterworth_live': 1.1 * error,
              'butterworth_aligned': error}
    signals = {'measured': measured, **{method: measured - errors[method] for method in METHODS},
               **{'error_' + name: values for name, values in errors.items()}}
    bands = {}
    for signal, values in signals.items():
        low, high = values - 0.01, values + 0.01
        low[empty] = high[empty] = np.nan
        bands[signal] = Band(low, high)
    filled = np.ones(n, bool)
    filled[empty] = False
    found = {name: _statistics(measured[filled], values[filled])
             for name, values in errors.items()}
    return Evaluation(
        name, '/robot/joint_states', 'right', n * PERIOD, 1 / PERIOD,
        {'received': n + 5, 'taken': n, 'predicted': n, 'not_this_arm': 5}, tuple(warnings),
        {method: found[method] for method in METHODS if effort},
        {estimator: found[estimator] for estimator in ESTIMATORS if effort},
        {term: AMPLITUDE / (i + 1) for i, term in enumerate(TERMS)}, time,
        bands if effort else {method: bands[method] for method in METHODS})


def _statistics(measured, error):
    with np.errstate(invalid='ignore', divide='ignore'):
        correlation = np.array([np.corrcoef(m, m - e)[0, 1]
                                for m, e in zip(measured.T, error.T)])
    correlation[measured.std(0) < 1e-12] = np.nan
    return ErrorStatistics(len(error), np.sqrt((error ** 2).mean(0)), np.abs(error).mean(0),
                           error.mean(0), correlation)
