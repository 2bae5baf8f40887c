"""Diagnostic statuses of the predictor: one method per status, each with levels of REP-107."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from .diagnostic_updater import ERROR, first_case, OK, STALE, WARN
from .process import GuardedExecutor
from .step_statistics import MAX_AGE, StepStatistics
from .topics import EFFORT_RESIDUAL
from ..estimation.events import DROPPED, Event, NO_EFFORT, NO_VELOCITY, RESETS
from ..estimation.external import ExternalEffort, LOWEST_RATE
from ..estimation.predictor import Predictor
from ..model import first_names, JOINTS, names_of

LONG_CONTACT = 30.0  # duration of contact that suggests a load missing from the model [s]
_LOCKS_WITHIN = 3.0  # time in which re-timing normally finds the period [s]
_GRACE = 2.0  # time allowed beyond the settling time of the filter [s]
_SAMPLES_PER_CYCLE = 4  # minimum number of samples per period of the cutoff frequency

_TYPE = 'sensor_msgs/msg/JointState'
_SHOWN = 6  # maximum number of joint names in a status message

_INPUT_EVENTS = DROPPED + NO_VELOCITY + (Event.POSITION_FROZEN, Event.REPEATED_STAMP,
                                         Event.UNSTAMPED)
_FILTER_EVENTS = RESETS + (Event.SPRING_HELD,)
_CLOCKS = {'header': 'using header stamps',
           'arrival': 'header stamps are times of arrival: re-timing them',
           'receipt': 'using re-timed times of receipt'}


@dataclass
class PredictorDiagnostics:
    """Objects that the statuses report on."""

    node: Node
    topic: str  # topic of the joint states
    predictor: Predictor
    statistics: StepStatistics
    explain: Callable[[], str]  # returns the explanation of the residual

    def report(self, period: float) -> dict[str, DiagnosticStatus]:
        """Return all statuses, given the time since the last report [s]."""
        executor = cast(GuardedExecutor, self.node.executor)
        self.statistics.close(
            Counter({**self.predictor.counts, 'failed': executor.failures}), period)
        self._is_stale = self.statistics.age > MAX_AGE
        return {'input': self._input(), 'stamps': self._stamps(), 'filter': self._filter(),
                'effort': self._effort(), 'residual': self._residual(),
                'external': self._external(), 'callbacks': self._callbacks(executor)}

    def _input(self) -> DiagnosticStatus:
        types = sorted({publisher.topic_type for publisher in
                        self.node.get_publishers_info_by_topic(self.topic)})
        selector, lost = self.predictor.stream.selector, self.statistics.since('lost')
        seen = first_names([name[:40] for name in selector.other_names or ()], _SHOWN)
        problems = self._remedies(_INPUT_EVENTS)
        mismatch = self.predictor.stream.velocity_check.mismatch
        if mismatch is not None and problems:
            problems.append('{joint} moved {moved:.3f} rad in {duration:.1f} s according to '
                            'position, {integrated:.3f} rad according to velocity'.format(
                                **mismatch._asdict()))
        if lost:
            problems.append(f'{lost} messages lost in transport')
        return first_case(
            {'rate [Hz]': f'{self.statistics.rate:.1f}',
             'age [s]': f'{self.statistics.age:.3f}',
             'publishers': self.node.count_publishers(self.topic),
             'types seen': ', '.join(types) or 'none',
             'joints looked for': ' '.join(selector.names),
             'other joints seen': seen or 'none',
             **self._counts('lost', 'received', *_INPUT_EVENTS)},
            # Stale with problems: messages arrive but none is valid.
            (problems, ERROR if self._is_stale else WARN, '; '.join(problems)),
            (self._is_stale, STALE, self._cause_of_silence(types, seen)),
            (True, OK, f'receiving joint states on {self.topic}'))

    def _cause_of_silence(self, types: list[str], seen: str) -> str:
        """Return why no joint states of the arm arrive, given types and joints that do."""
        topic, selector = self.topic, self.predictor.stream.selector
        wanted = f'; looking for {selector.names[0]} ... {selector.names[-1]}'
        if self.statistics.since(Event.NOT_THIS_ARM) and selector.other_names is not None:
            return (f'joint states on {topic} contain {seen}{wanted} (parameters arm and '
                    'joint_prefix)' if seen else
                    f'joint states on {topic} contain no joint names{wanted}')
        if not types:
            return f'{topic} has no publisher: is a bridge running with the same ROS_DOMAIN_ID?'
        if _TYPE not in types:
            return f'{topic} is published as {", ".join(types)}; this node needs {_TYPE}'
        return (f'no joint states received on {topic}; publishers: '
                f'{self.node.count_publishers(topic)}')

    def _stamps(self) -> DiagnosticStatus:
        clock, estimator = self.predictor.stream.clock, self.predictor.estimator
        accepted, predicted = self.statistics.accepted, self.statistics.predicted
        is_searching = clock.retimed and not clock.period
        values = {'source': clock.source, 're-timed': clock.retimed}
        if accepted.state:
            values['newest stamp [s]'] = f'{accepted.state.stamp_ns * 1e-9:.3f}'
        if clock.retimed and clock.period:
            values['period [s]'] = f'{clock.period:.6f}'
            values['jitter of arrival [s]'] = f'{clock.jitter:.4f}'
        for result, delay, nominal in (
                ('predictions', predicted.delay_of(predicted.estimate), estimator.delay),
                ('external effort', accepted.delay_of(accepted.external), estimator.velocity_lag)):
            values[f'delay of {result} [s]'] = f'{nominal if delay is None else delay:.4f}'
        return first_case(
            {**values, **self._counts(Event.AWAITING_PERIOD)},
            (self._is_stale, STALE, 'waiting for joint states'),
            (not is_searching, OK, _CLOCKS[clock.source]),
            (self.statistics.dry > _LOCKS_WITHIN, WARN,
             'no predictions: messages do not arrive at a steady rate'),
            (True, OK, 'estimating the period of the messages'))

    def _filter(self) -> DiagnosticStatus:
        estimator, statistics = self.predictor.estimator, self.statistics
        needed = _SAMPLES_PER_CYCLE * self.predictor.settings.acceleration.cutoff
        state = ('waiting' if self._is_stale else
                 'running' if statistics.since('predicted') else 'settling')
        problems = self._remedies(_FILTER_EVENTS)
        return first_case(
            {'state': state, 'settling time [s]': f'{estimator.settling_time:.3f}',
             **self._counts('predicted', *_FILTER_EVENTS)},
            (problems, WARN, '; '.join(problems)),
            (statistics.highest_rate < needed, WARN,
             f'acceleration.cutoff requires at least {needed:g} joint states per second: lower '
             'the cutoff or raise the rate'),
            (statistics.dry > estimator.settling_time + _GRACE, WARN,
             'acceleration filter does not settle although joint states arrive: see the status '
             'input and the counts of resets'),
            (self._is_stale, STALE, 'waiting for joint states'),
            (True, OK, f'acceleration filter is {state}'))

    def _effort(self) -> DiagnosticStatus:
        problems = self._remedies(NO_EFFORT)
        return first_case(
            {'valid': 'unknown' if self._is_stale else not problems, **self._counts(*NO_EFFORT)},
            (self._is_stale, STALE, 'no measured effort: waiting for joint states'),
            (problems, WARN, '; '.join(problems)),
            (True, OK, 'measured effort is valid'))

    def _residual(self) -> DiagnosticStatus:
        rms, level = self.statistics.residual_rms, STALE if self._is_stale else OK
        own = self.node.resolve_topic_name(f'~/{EFFORT_RESIDUAL}')
        return first_case(
            {'explanation': 'none' if self._is_stale else self.explain(),
             **{f'{joint} RMS [N m]': 'none' if rms is None else f'{rms[i]:.3f}'
                for i, joint in enumerate(JOINTS)}},
            (self.node.count_publishers(own) > 1, WARN, f'{own} has other publishers: results may '
             'arrive twice; check for a second predictor of this name'),
            (rms is not None, level, 'RMS of measured minus predicted effort'),
            (True, level, 'no residual in the last second: see the statuses filter and effort'))

    def _external(self) -> DiagnosticStatus:
        external = cast(ExternalEffort, self.predictor.external)
        detector, unexplained = external.detector, self.statistics.unexplained
        is_missing = self._is_stale or not self.statistics.since('external')
        is_unknown = is_missing or external.is_too_slow or detector.is_settling
        joints = ', '.join(names_of(detector.joints))
        status = first_case(
            {'contact': 'unknown' if is_unknown else detector.in_contact,
             'contact for [s]': f'{detector.duration:.1f}',
             'joints in contact': joints,
             'joints in contact in the last period': ', '.join(names_of(self.statistics.touched)),
             'wrenches withheld': self.statistics.counts['withheld'],
             'unexplained by a wrench [N m]': (
                 'none' if unexplained is None else f'{unexplained:.3f}'),
             **{f'{joint} {name} [N m]': f'{value:.3f}' for name, values in (
                 ('bias', detector.bias), ('sigma', detector.sigma),
                 ('threshold', detector.threshold)) for joint, value in zip(JOINTS, values)}},
            (is_missing, STALE, 'no external effort: see the statuses input and effort'),
            (external.is_too_slow, WARN, 'contact is not published: its detection requires at '
             f'least {LOWEST_RATE:g} joint states per second'),
            (detector.is_settling, OK,
             'momentum observer is settling: contact is not published yet'),
            (detector.in_contact and detector.duration > LONG_CONTACT, WARN,
             f'contact at {joints} for over {LONG_CONTACT:.0f} s: if nothing touches the arm, the '
             'model lacks a load; set payload.* or calibrate, then call the service reset'),
            (detector.in_contact, OK, f'contact at {joints}'),
            (detector.has_learnt, OK, 'no contact'),
            (True, OK, 'no contact; still learning the thresholds from free motion'))
        if self.statistics.since('withheld'):
            status.message += '; wrench not published near a singularity of the hand'
        return status

    def _callbacks(self, executor: GuardedExecutor) -> DiagnosticStatus:
        return first_case(
            {**self._counts('failed'), 'last failure': executor.last_failure or 'none'},
            (self.statistics.since('failed'), WARN,
             f'a callback failed in the last second: {executor.last_failure}'),
            (True, OK, 'no callback failures'))

    def _remedies(self, events: tuple[Event, ...]) -> list[str]:
        """Return the remedies of events in the last period."""
        return [event.remedy for event in events
                if event.remedy and self.statistics.since(event)]

    def _counts(self, *events: Event | str) -> dict[str, object]:
        return {event.value if isinstance(event, Event) else event: self.statistics.counts[event]
                for event in events}
