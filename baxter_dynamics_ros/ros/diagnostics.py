"""What goes on, and what is wrong and what to do, once a second."""

from collections import Counter

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_msgs.msg import KeyValue
import numpy as np

from ..core.joints import JOINTS
from ..core.joints import N_JOINTS
from ..signals.events import DROPPED
from ..signals.events import Event
from ..signals.events import NO_EFFORT
from ..signals.events import REMEDIES
from ..signals.events import RESETS

STALE_AFTER = 1.0  # without a valid joint state of the arm [s]
_SAMPLES_PER_CYCLE = 4  # of the cut-off frequency, at the least

_INPUT_EVENTS = DROPPED + (Event.REPEATED_STAMP, Event.VELOCITY_MISSING)
_FILTER_EVENTS = RESETS + (Event.SPRING_HELD,)


class PeriodStatistics:
    """What has come in since the last report."""

    def __init__(self):
        self._counts = Counter()
        self.was_dry = False  # joint states, but no prediction, in the period before
        self.rate = float('inf')  # of the joint states in the period before [Hz]
        self.clear(self._counts, 1.0)

    def clear(self, counts: Counter, period: float):
        """Begin a new period; ``counts`` are those of now, at the end of one of ``period`` [s]."""
        taken = self.since(counts, 'taken')
        self.was_dry = taken > 0 and not self.since(counts, 'predicted')
        self.rate = taken / period or float('inf')
        self._counts = Counter(counts)
        self._square = np.zeros(N_JOINTS)
        self._residuals = 0

    def add(self, residual):
        """Take the residual (7,) [N m] of a prediction, or None."""
        if residual is not None:
            self._square += residual * residual
            self._residuals += 1

    def since(self, counts: Counter, event) -> int:
        """Return how often an event occurred in the period."""
        return counts[event] - self._counts[event]

    @property
    def residual_rms(self) -> 'np.ndarray | None':
        """RMS of the period's residuals (7,) [N m]; None if there were none."""
        return np.sqrt(self._square / self._residuals) if self._residuals else None


def report(node_name: str, topic: str, predictor, statistics: PeriodStatistics, age: float,
           period: float) -> list:
    """
    Return the diagnostic statuses of a predictor.

    Parameters
    ----------
    node_name : str
        With its namespace; stands in front of the statuses' names.
    topic : str
        Where the joint states come from.
    predictor : Predictor
        Whose.
    statistics : PeriodStatistics
        Of the last period.
    age : float
        Time since the arm's last valid joint state [s]; infinite if there was none.
    period : float
        Length of the period [s].

    """
    statuses = [_input(topic, predictor, statistics, age, period),
                _filter(predictor, statistics, age, period),
                _effort(predictor, statistics, age),
                _residual(predictor, statistics)]
    for status in statuses:
        status.name = f'{node_name}: {status.name}'
        status.hardware_id = f'baxter_{predictor.intake.side}_arm'
    return statuses


def _input(topic, predictor, statistics, age, period):
    counts = predictor.counts
    status = DiagnosticStatus(name='input', level=DiagnosticStatus.OK,
                              message=f'joint states arrive on {topic}')
    _warn_of(status, _INPUT_EVENTS, counts, statistics)
    if age > STALE_AFTER:
        if status.level == DiagnosticStatus.OK:
            status.level = DiagnosticStatus.STALE
            status.message = f'no joint states of the {predictor.intake.side} arm on {topic}: ' + (
                'others arrive, so is the other arm meant (parameter arm)?'
                if statistics.since(counts, Event.NOT_THIS_ARM) else
                'is the bridge running, and is the ROS domain the same?')
        else:  # they arrive, and none can be used
            status.level = DiagnosticStatus.ERROR
    rate = statistics.since(counts, 'taken') / period
    _add(status, 'rate [Hz]', f'{rate:.1f}')
    _add(status, 'age [s]', f'{age:.3f}')
    _add(status, 'received', counts['received'])
    for event in _INPUT_EVENTS:
        _add(status, event.value, counts[event])
    return status


def _filter(predictor, statistics, age, period):
    status = DiagnosticStatus(name='filter', level=DiagnosticStatus.OK)
    delay = predictor.estimator.delay
    if age > STALE_AFTER:
        state, status.level = 'waiting', DiagnosticStatus.STALE
    elif statistics.since(predictor.counts, 'predicted'):
        state = 'running'
        if predictor.prediction is not None:
            delay = (predictor.latest.stamp_ns - predictor.prediction.stamp_ns) * 1e-9
    else:
        state = 'settling'
    status.message = state
    if state == 'settling' and statistics.was_dry:
        status.level = DiagnosticStatus.WARN
        status.message = 'joint states arrive but the filter never settles: see input and resets'
    needed = _SAMPLES_PER_CYCLE * predictor.estimator.cutoff
    if 0.0 < max(statistics.since(predictor.counts, 'taken') / period, statistics.rate) < needed:
        status.level = DiagnosticStatus.WARN
        status.message = (f'under {needed:g} joint states a second are too few for '
                          'acceleration.cutoff: lower it, or raise the rate')
    _warn_of(status, _FILTER_EVENTS, predictor.counts, statistics)
    _add(status, 'state', state)
    _add(status, 'delay [s]', f'{delay:.4f}')
    _add(status, 'settling time [s]', f'{predictor.estimator.settling_time:.3f}')
    _add(status, 'predicted', predictor.counts['predicted'])
    for event in _FILTER_EVENTS:
        _add(status, event.value, predictor.counts[event])
    return status


def _effort(predictor, statistics, age):
    counts = predictor.counts
    status = DiagnosticStatus(name='effort', level=DiagnosticStatus.OK,
                              message='measured effort is valid')
    _warn_of(status, NO_EFFORT, counts, statistics)
    valid = str(status.level == DiagnosticStatus.OK)
    if age > STALE_AFTER:
        status.level, status.message, valid = DiagnosticStatus.STALE, 'nothing measured', 'unknown'
    _add(status, 'valid', valid)
    for event in NO_EFFORT:
        _add(status, event.value, counts[event])
    return status


def _residual(predictor, statistics):
    rms = statistics.residual_rms
    status = DiagnosticStatus(name='residual', level=DiagnosticStatus.OK)
    status.message = ('RMS of measured - predicted effort' if rms is not None
                      else 'no residual in the last period')
    for i, joint in enumerate(JOINTS):
        _add(status, f'{joint} RMS [N m]', 'none' if rms is None else f'{rms[i]:.3f}')
    return status


def _warn_of(status, events, counts, statistics):
    """Raise the status to WARN, and say why, if any of the events occurred in the period."""
    reasons = [REMEDIES[event] for event in events
               if event in REMEDIES and statistics.since(counts, event)]
    if reasons:
        status.level = DiagnosticStatus.WARN
        status.message = '; '.join(reasons)


def _add(status, key, value):
    status.values.append(KeyValue(key=key, value=str(value)))
