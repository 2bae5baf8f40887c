"""Diagnostics of the predictor: one task per status, as in diagnostic_updater."""

from collections.abc import Callable
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node

from .arm_publisher import Arm
from .message_loss import MessageLoss
from .process import GuardedExecutor
from ..estimation.events import DROPPED, Event, NO_EFFORT, NO_VELOCITY, REMEDIES, RESETS
from ..estimation.external import LOWEST_RATE
from ..model.arrays import Bools
from ..model.joints import JOINTS

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE

STALE_AFTER = 1.0  # time without a valid joint state of the arm [s]
LONG_CONTACT = 30.0  # duration of contact that suggests a load missing from the model [s]
_LOCKS_WITHIN = 3.0  # time in which re-timing normally finds the period [s]
_GRACE = 2.0  # time allowed beyond the settling time of the filter [s]
_SAMPLES_PER_CYCLE = 4  # minimum number of samples per period of the cut-off frequency

_TYPE = 'sensor_msgs/msg/JointState'
_SHOWN = 6  # maximum number of joint names in a status message

_INPUT_EVENTS = DROPPED + NO_VELOCITY + (Event.POSITION_FROZEN, Event.REPEATED_STAMP,
                                         Event.UNSTAMPED)
_FILTER_EVENTS = RESETS + (Event.SPRING_HELD,)

# Status messages; REMEDIES has those of events. All are listed in docs/node.md.
MESSAGES = {
    'input': 'receiving joint states on {topic}',
    'no publisher': '{topic} has no publisher',
    'other type': '{topic} is published as {types}; this node needs sensor_msgs/msg/JointState',
    'no messages': 'no joint states received on {topic}; publishers: {count}',
    'no names': 'joint states on {topic} have no joint names; looking for {wanted}',
    'other names': 'joint states on {topic} contain {seen}; looking for {wanted} (parameters arm '
                   'and joint_prefix)',
    'mismatch': '; {joint} moved {moved:.3f} rad in {duration:.1f} s according to position, '
                '{integrated:.3f} rad according to velocity',
    'lost': '; {lost} messages lost in transport',
    'header': 'using header stamps',
    'arrival': 'header stamps are times of arrival: re-timing them',
    'receipt': 'using re-timed times of receipt',
    'locking': 'estimating the period of the messages',
    'never locks': 'no predictions: messages do not arrive at a steady rate',
    'running': 'acceleration filter is running',
    'settling': 'acceleration filter is settling',
    'waiting': 'waiting for joint states',
    'never settles': 'acceleration filter does not settle although joint states arrive: see the '
                     'status input and the counts of resets',
    'slow': 'acceleration.cutoff requires at least {needed:g} joint states per second: lower the '
            'cut-off or raise the rate',
    'effort': 'measured effort is valid',
    'beginning': 'momentum observer is settling: contact is not published yet',
    'too slow': 'contact is not published: its detection requires at least {needed:g} joint '
                'states per second',
    'no measurement': 'no measured effort: waiting for joint states',
    'residual': 'RMS of measured minus predicted effort',
    'no residual': 'no residual in the last second: see the statuses filter and effort',
    'callbacks': 'no callback failures',
    'callback failed': 'a callback failed in the last second: {failure}',
    'free': 'no contact',
    'learning': 'no contact; still learning the thresholds from free motion',
    'contact': 'contact at {joints}',
    'long contact': 'contact at {joints} for over 30 s: if nothing touches the arm, the '
                    'model lacks a load; set payload.* or calibrate, then call the service reset',
    'no external': 'no external effort: see the statuses input and effort',
    'withheld': '; wrench not published near a singularity of the hand',
}


class ReportContext(NamedTuple):
    """Objects that the tasks report on."""

    node: Node
    topic: str  # topic of the joint states
    arm: Arm
    loss: MessageLoss


def report(node: Node, topic: str, arm: Arm, loss: MessageLoss) -> list[DiagnosticStatus]:
    """
    Return the node's diagnostic statuses.

    Parameters
    ----------
    node : Node
        The node; status names begin with its full name.
    topic : str
        Topic of the joint states.
    arm : Arm
        The node's arm; its statistics must be closed.
    loss : MessageLoss
        Messages lost on the topic.

    """
    context = ReportContext(node, topic, arm, loss)
    statuses = []
    for name, task in TASKS.items():
        status = DiagnosticStatus(
            name=f'{node.get_fully_qualified_name().lstrip("/")}: {name}',
            hardware_id=f'baxter_{arm.predictor.stream.selector.side}_arm')
        task(status, context)
        statuses.append(status)
    return statuses


def _input(status: DiagnosticStatus, context: ReportContext) -> None:
    arm, topic = context.arm, context.topic
    stream = arm.predictor.stream
    types = sorted({publisher.topic_type for publisher in
                    context.node.get_publishers_info_by_topic(topic)})
    _summarize(status, OK, 'input', topic=topic)
    _warn_about(status, _INPUT_EVENTS, arm)
    mismatch = stream.velocity_check.mismatch
    if mismatch is not None and status.level == WARN:
        status.message += MESSAGES['mismatch'].format(**mismatch._asdict())
    lost = arm.statistics.lost_since(context.loss.lost)
    if lost:
        status.level = WARN
        status.message += MESSAGES['lost'].format(lost=lost)
    if arm.recent.age > STALE_AFTER:
        if status.level == OK:
            _explain_silence(status, context, types)
        else:  # messages arrive but none is valid
            status.level = ERROR
    _add(status, 'rate [Hz]', f'{arm.statistics.rate:.1f}')
    _add(status, 'age [s]', f'{arm.recent.age:.3f}')
    _add(status, 'publishers', context.node.count_publishers(topic))
    _add(status, 'types seen', ', '.join(types) or 'none')
    _add(status, 'joints looked for', ' '.join(stream.selector.names))
    _add(status, 'other joints seen', _listed(stream.selector.other_names or ()) or 'none')
    _add(status, 'lost', context.loss.lost)
    _add(status, 'received', arm.predictor.counts['received'])
    _add_counts(status, _INPUT_EVENTS, arm)


def _explain_silence(status: DiagnosticStatus, context: ReportContext, types: list[str]) -> None:
    """Report why no joint states of the arm arrive."""
    selector = context.arm.predictor.stream.selector
    seen = selector.other_names if context.arm.statistics.since(Event.NOT_THIS_ARM) else None
    if seen is not None:
        key = 'other names' if seen else 'no names'
    elif not types:
        key = 'no publisher'
    else:
        key = 'no messages' if _TYPE in types else 'other type'
    _summarize(status, STALE, key, topic=context.topic, types=', '.join(types),
               count=context.node.count_publishers(context.topic), seen=_listed(seen or ()),
               wanted=f'{selector.names[0]} ... {selector.names[-1]}')


def _listed(names: tuple[str, ...]) -> str:
    """Return the first names of a message, with unprintable characters escaped."""
    shown = [''.join(c if c.isprintable() else ascii(c)[1:-1] for c in name[:40])
             for name in names[:_SHOWN]]
    more = len(names) - len(shown)
    return ', '.join(shown) + (f' and {more} more' if more > 0 else '')


def _stamps(status: DiagnosticStatus, context: ReportContext) -> None:
    arm = context.arm
    clock = arm.predictor.stream.clock
    if arm.recent.age > STALE_AFTER:
        _summarize(status, STALE, 'waiting')
    elif not clock.retimed or clock.period:
        _summarize(status, OK, clock.source)
    elif arm.statistics.dry > _LOCKS_WITHIN:
        _summarize(status, WARN, 'never locks')
    else:
        _summarize(status, OK, 'locking')
    _add(status, 'source', clock.source)
    _add(status, 're-timed', clock.retimed)
    newest = arm.recent.accepted and arm.recent.accepted.state
    if newest is not None:
        _add(status, 'newest stamp [s]', f'{newest.stamp_ns * 1e-9:.3f}')
    if clock.retimed and clock.period:
        _add(status, 'period [s]', f'{clock.period:.6f}')
        _add(status, 'jitter of arrival [s]', f'{clock.jitter:.4f}')
    _add(status, Event.AWAITING_PERIOD.value, arm.predictor.counts[Event.AWAITING_PERIOD])
    predicted, accepted = arm.recent.predicted, arm.recent.accepted
    for result, delay, nominal in (
            ('predictions', predicted and predicted.delay, arm.predictor.estimator.delay),
            ('external effort', accepted and accepted.external_delay,
             arm.predictor.estimator.velocity_lag)):
        _add(status, f'delay of {result} [s]', f'{nominal if delay is None else delay:.4f}')


def _filter(status: DiagnosticStatus, context: ReportContext) -> None:
    arm = context.arm
    predictor, statistics = arm.predictor, arm.statistics
    if arm.recent.age > STALE_AFTER:
        state = 'waiting'
        _summarize(status, STALE, state)
    else:
        state = 'running' if statistics.since('predicted') else 'settling'
        _summarize(status, OK, state)
    if statistics.dry > predictor.estimator.settling_time + _GRACE:
        _summarize(status, WARN, 'never settles')
    needed = _SAMPLES_PER_CYCLE * predictor.estimator.cutoff
    if 0.0 < statistics.highest_rate < needed:
        _summarize(status, WARN, 'slow', needed=needed)
    _warn_about(status, _FILTER_EVENTS, arm)
    _add(status, 'state', state)
    _add(status, 'settling time [s]', f'{predictor.estimator.settling_time:.3f}')
    _add(status, 'predicted', predictor.counts['predicted'])
    _add_counts(status, _FILTER_EVENTS, arm)


def _effort(status: DiagnosticStatus, context: ReportContext) -> None:
    arm = context.arm
    _summarize(status, OK, 'effort')
    _warn_about(status, NO_EFFORT, arm)
    valid = str(status.level == OK)
    if arm.recent.age > STALE_AFTER:
        valid = 'unknown'
        _summarize(status, STALE, 'no measurement')
    _add(status, 'valid', valid)
    _add_counts(status, NO_EFFORT, arm)


def _residual(status: DiagnosticStatus, context: ReportContext) -> None:
    arm = context.arm
    rms = arm.statistics.residual_rms
    _summarize(status, STALE if arm.recent.age > STALE_AFTER else OK,
               'no residual' if rms is None else 'residual')
    for i, joint in enumerate(JOINTS):
        _add(status, f'{joint} RMS [N m]', 'none' if rms is None else f'{rms[i]:.3f}')


def _external(status: DiagnosticStatus, context: ReportContext) -> None:
    arm = context.arm
    detector = arm.external.detector
    joints = _named(detector.joints)
    if arm.recent.age > STALE_AFTER or not arm.statistics.since('external'):
        _summarize(status, STALE, 'no external')
    elif arm.external.is_too_slow:
        _summarize(status, WARN, 'too slow', needed=LOWEST_RATE)
    elif detector.is_settling:
        _summarize(status, OK, 'beginning')
    elif detector.in_contact and detector.duration > LONG_CONTACT:
        _summarize(status, WARN, 'long contact', joints=joints)
    elif detector.in_contact:
        _summarize(status, OK, 'contact', joints=joints)
    else:
        _summarize(status, OK, 'free' if detector.has_learnt else 'learning')
    if arm.statistics.was_withheld:
        status.message += MESSAGES['withheld']
    unknown = status.level == STALE or arm.external.is_too_slow or detector.is_settling
    _add(status, 'contact', 'unknown' if unknown else detector.in_contact)
    _add(status, 'contact for [s]', f'{detector.duration:.1f}')
    _add(status, 'joints in contact', joints)
    _add(status, 'joints in contact in the last period', _named(arm.statistics.touched))
    _add(status, 'wrenches withheld', arm.statistics.withheld)
    unexplained = arm.statistics.unexplained
    _add(status, 'unexplained by a wrench [N m]',
         'none' if unexplained is None else f'{unexplained:.3f}')
    for name, values in (('bias', detector.bias), ('sigma', detector.sigma),
                         ('threshold', detector.threshold)):
        for joint, value in zip(JOINTS, values):
            _add(status, f'{joint} {name} [N m]', f'{value:.3f}')


def _callbacks(status: DiagnosticStatus, context: ReportContext) -> None:
    executor, statistics = context.node.executor, context.arm.statistics
    failures, last = ((executor.failures, executor.last_failure)
                      if isinstance(executor, GuardedExecutor) else (0, ''))
    _summarize(status, OK, 'callbacks')
    if statistics.failures_since(failures):
        _summarize(status, WARN, 'callback failed', failure=last)
    _add(status, 'failed', failures)
    _add(status, 'last failure', last or 'none')


TASKS: dict[str, Callable[[DiagnosticStatus, ReportContext], None]] = {
    'input': _input, 'stamps': _stamps, 'filter': _filter, 'effort': _effort,
    'residual': _residual, 'external': _external, 'callbacks': _callbacks}


def _named(joints: Bools) -> str:
    return ', '.join(joint for joint, is_shown in zip(JOINTS, joints) if is_shown)


def _summarize(status: DiagnosticStatus, level: bytes, key: str, **details: object) -> None:
    """Set the level of a status and its message, by its key in MESSAGES."""
    status.level, status.message = level, MESSAGES[key].format(**details)


def _warn_about(status: DiagnosticStatus, events: tuple[Event, ...], arm: Arm) -> None:
    """Set WARN and the remedies if any of the events occurred in the last period."""
    reasons = [REMEDIES[event] for event in events
               if event in REMEDIES and arm.statistics.since(event)]
    if reasons:
        status.level = WARN
        status.message = '; '.join(reasons)


def _add_counts(status: DiagnosticStatus, events: tuple[Event, ...], arm: Arm) -> None:
    for event in events:
        _add(status, event.value, arm.predictor.counts[event])


def _add(status: DiagnosticStatus, key: str, value: object) -> None:
    status.values.append(KeyValue(key=key, value=str(value)))
