"""What goes on, and what is wrong and what to do, once a second."""

from collections import Counter

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_msgs.msg import KeyValue
import numpy as np

from ..core.joints import JOINTS
from ..core.joints import N_JOINTS
from ..signals.events import Event
from ..signals.events import REMEDIES

STALE_AFTER = 1.0  # without a joint state of the arm [s]

_EFFORT_EVENTS = (Event.EFFORT_MISSING, Event.EFFORT_ALL_ZERO)
_INPUT_EVENTS = tuple(event for event in Event
                      if event not in _EFFORT_EVENTS and event is not Event.SPRING_HELD
                      and not event.value.startswith('reset_'))
_FILTER_EVENTS = tuple(event for event in Event if event.value.startswith('reset_'))


class PeriodStatistics:
    """What has come in since the last report."""

    def __init__(self):
        self._counts = Counter()
        self.clear(self._counts)

    def clear(self, counts: Counter):
        """Begin a new period; ``counts`` are those of now."""
        self._counts = Counter(counts)
        self.samples = 0
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
        In front of the statuses' names.
    topic : str
        Where the joint states come from.
    predictor : Predictor
        Whose.
    statistics : PeriodStatistics
        Of the last period.
    age : float
        Time since the arm's last joint state [s]; infinite if there was none.
    period : float
        Length of the period [s].

    """
    statuses = [_input(topic, predictor, statistics, age, period),
                _filter(predictor, statistics, age),
                _effort(predictor, statistics),
                _residual(predictor, statistics)]
    for status in statuses:
        status.name = f'{node_name}: {status.name}'
        status.hardware_id = 'baxter_' + predictor.intake.names[0].split('_')[0] + '_arm'
    return statuses


def _input(topic, predictor, statistics, age, period):
    counts = predictor.counts
    status = DiagnosticStatus(name='input', level=DiagnosticStatus.OK,
                              message=f'joint states arrive on {topic}')
    _warn_of(status, _INPUT_EVENTS, counts, statistics)
    if age > STALE_AFTER:
        status.level = DiagnosticStatus.STALE
        arm = predictor.intake.names[0].split('_')[0]
        status.message = (f'no joint states of the {arm} arm on {topic}: is the bridge running, '
                          'and is the ROS domain the same?')
    rate = statistics.since(counts, 'taken') / period
    _add(status, 'rate [Hz]', f'{rate:.1f}')
    _add(status, 'age [s]', f'{age:.3f}')
    _add(status, 'received', counts['received'])
    for event in _INPUT_EVENTS:
        _add(status, event.value, counts[event])
    return status


def _filter(predictor, statistics, age):
    status = DiagnosticStatus(name='filter', level=DiagnosticStatus.OK)
    if age > STALE_AFTER:
        state = 'waiting'
        status.level = DiagnosticStatus.STALE
    else:
        state = 'running' if predictor.prediction is not None else 'settling'
    status.message = state
    _warn_of(status, _FILTER_EVENTS + (Event.SPRING_HELD,), predictor.counts, statistics)
    _add(status, 'state', state)
    _add(status, 'delay [s]', f'{predictor.estimator.delay:.4f}')
    _add(status, 'settling time [s]', f'{predictor.estimator.settling_time:.3f}')
    _add(status, 'predicted', predictor.counts['predicted'])
    for event in _FILTER_EVENTS + (Event.SPRING_HELD,):
        _add(status, event.value, predictor.counts[event])
    return status


def _effort(predictor, statistics):
    counts = predictor.counts
    status = DiagnosticStatus(name='effort', level=DiagnosticStatus.OK,
                              message='measured effort is valid')
    _warn_of(status, _EFFORT_EVENTS, counts, statistics)
    _add(status, 'valid', status.level == DiagnosticStatus.OK)
    for event in _EFFORT_EVENTS:
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
