"""What goes on, and what is wrong and what to do: the diagnostics of one arm."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from .arm_publisher import Arm
from ..estimation.events import DROPPED, Event, NO_EFFORT, REMEDIES, RESETS
from ..estimation.external import LOWEST_RATE
from ..model.arrays import Bools
from ..model.joints import JOINTS

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE

STALE_AFTER = 1.0  # without a valid joint state of the arm [s]
LONG_CONTACT = 30.0  # [s] after which a contact is taken for a load that the model lacks
_LOCKS_WITHIN = 3.0  # [s] that re-timing may take to find a period
_GRACE = 2.0  # [s] that the filter may take longer than it needs to settle
_SAMPLES_PER_CYCLE = 4  # of the cut-off frequency, at the least

_INPUT_EVENTS = DROPPED + (Event.REPEATED_STAMP, Event.UNSTAMPED, Event.VELOCITY_MISSING)
_FILTER_EVENTS = RESETS + (Event.SPRING_HELD,)

# What a status says, beside the REMEDIES of events. docs/node.md explains each.
SAYS = {
    'input': 'joint states arrive on {topic}',
    'no input': 'no joint states of the {side} arm on {topic}: is the bridge running, and is the '
                'ROS domain the same?',
    'other arm': 'no joint states of the {side} arm on {topic}: others arrive, so is the other '
                 'arm meant (parameter arm)?',
    'header': 'stamps are believed',
    'retimed': 'stamps are times of arrival, and are re-timed',
    'locking': 'stamps are times of arrival; their period is being found',
    'never locks': 'stamps are times of arrival of no even period: do joint states come at one '
                   'rate, from one publisher?',
    'running': 'running',
    'settling': 'settling',
    'waiting': 'waiting for joint states',
    'never settles': 'joint states arrive but the filter never settles: see input and resets',
    'slow': 'under {needed:g} joint states a second are too few for acceleration.cutoff: lower '
            'it, or raise the rate',
    'effort': 'measured effort is valid',
    'no measurement': 'nothing measured',
    'residual': 'RMS of measured - predicted effort',
    'no residual': 'no residual in the last period',
    'beginning': 'the momentum observer is settling: contact is not published yet',
    'too slow': 'no contact output: under {needed:g} joint states a second are too few to detect '
                'contact',
    'free': 'no contact',
    'learning': 'no contact; what free motion is like is still being learnt',
    'contact': 'contact: {joints}',
    'long contact': 'contact at {joints} for over 30 s: if nothing touches the arm, the '
                    'model lacks a load; set payload.* or calibrate, then call the service reset',
    'no external': 'no external effort: see input and effort',
    'withheld': '; the wrench is withheld, for the hand is near a singularity',
}


def report(place: str, topic: str, publishers: int, arm: Arm) -> list[DiagnosticStatus]:
    """
    Return the diagnostic statuses of an arm.

    Parameters
    ----------
    place : str
        The node's name with its namespace, and the arm's side where it serves both; stands in
        front of the statuses' names.
    topic : str
        Where the joint states come from.
    publishers : int
        How many publish there.
    arm : Arm
        Whose; its statistics closed.

    """
    statuses = [_input(arm, topic, publishers), _stamps(arm), _filter(arm), _effort(arm),
                _residual(arm), _external(arm)]
    for status in statuses:
        status.name = f'{place}: {status.name}'
        status.hardware_id = f'baxter_{arm.predictor.stream.intake.side}_arm'
    return statuses


def _input(arm: Arm, topic: str, publishers: int) -> DiagnosticStatus:
    status = _status('input', OK, 'input', topic=topic)
    _warn_of(status, _INPUT_EVENTS, arm)
    if arm.recent.age > STALE_AFTER:
        if status.level == OK:
            what = 'other arm' if arm.statistics.since(Event.NOT_THIS_ARM) else 'no input'
            status = _status('input', STALE, what, topic=topic,
                             side=arm.predictor.stream.intake.side)
        else:  # they arrive, and none can be used
            status.level = ERROR
    _add(status, 'rate [Hz]', f'{arm.statistics.rate:.1f}')
    _add(status, 'age [s]', f'{arm.recent.age:.3f}')
    _add(status, 'publishers', publishers)
    _add(status, 'received', arm.predictor.counts['received'])
    _add_counts(status, _INPUT_EVENTS, arm)
    return status


def _stamps(arm: Arm) -> DiagnosticStatus:
    clock = arm.predictor.stream.clock
    if arm.recent.age > STALE_AFTER:
        status = _status('stamps', STALE, 'waiting')
    elif not clock.retimed:
        status = _status('stamps', OK, 'header')
    elif clock.period:
        status = _status('stamps', OK, 'retimed')
    else:
        status = (_status('stamps', WARN, 'never locks') if arm.statistics.dry > _LOCKS_WITHIN
                  else _status('stamps', OK, 'locking'))
    _add(status, 're-timed', clock.retimed)
    if clock.retimed and clock.period:
        _add(status, 'period [s]', f'{clock.period:.6f}')
        _add(status, 'jitter of arrival [s]', f'{clock.jitter:.4f}')
    predicted, accepted = arm.recent.predicted, arm.recent.accepted
    for what, delay, nominal in (
            ('predictions', predicted and predicted.delay, arm.predictor.estimator.delay),
            ('external effort', accepted and accepted.external_delay,
             arm.predictor.estimator.velocity_lag)):
        _add(status, f'delay of {what} [s]', f'{nominal if delay is None else delay:.4f}')
    return status


def _filter(arm: Arm) -> DiagnosticStatus:
    predictor, statistics = arm.predictor, arm.statistics
    if arm.recent.age > STALE_AFTER:
        state, status = 'waiting', _status('filter', STALE, 'waiting')
    elif statistics.since('predicted'):
        state, status = 'running', _status('filter', OK, 'running')
    else:
        state = 'settling'
        long = statistics.dry > predictor.estimator.settling_time + _GRACE
        status = (_status('filter', WARN, 'never settles') if long
                  else _status('filter', OK, 'settling'))
    needed = _SAMPLES_PER_CYCLE * predictor.estimator.cutoff
    if 0.0 < statistics.highest_rate < needed:
        status = _status('filter', WARN, 'slow', needed=needed)
    _warn_of(status, _FILTER_EVENTS, arm)
    _add(status, 'state', state)
    _add(status, 'settling time [s]', f'{predictor.estimator.settling_time:.3f}')
    _add(status, 'predicted', predictor.counts['predicted'])
    _add_counts(status, _FILTER_EVENTS, arm)
    return status


def _effort(arm: Arm) -> DiagnosticStatus:
    status = _status('effort', OK, 'effort')
    _warn_of(status, NO_EFFORT, arm)
    valid = str(status.level == OK)
    if arm.recent.age > STALE_AFTER:
        status, valid = _status('effort', STALE, 'no measurement'), 'unknown'
    _add(status, 'valid', valid)
    _add_counts(status, NO_EFFORT, arm)
    return status


def _residual(arm: Arm) -> DiagnosticStatus:
    rms = arm.statistics.residual_rms
    status = _status('residual', STALE if arm.recent.age > STALE_AFTER else OK,
                     'no residual' if rms is None else 'residual')
    for i, joint in enumerate(JOINTS):
        _add(status, f'{joint} RMS [N m]', 'none' if rms is None else f'{rms[i]:.3f}')
    return status


def _external(arm: Arm) -> DiagnosticStatus:
    detector = arm.external.detector
    joints = _named(detector.joints)
    if arm.recent.age > STALE_AFTER or not arm.statistics.since('external'):
        status = _status('external', STALE, 'no external')
    elif arm.external.is_too_slow:
        status = _status('external', WARN, 'too slow', needed=LOWEST_RATE)
    elif detector.is_settling:
        status = _status('external', OK, 'beginning')
    elif detector.in_contact and detector.duration > LONG_CONTACT:
        status = _status('external', WARN, 'long contact', joints=joints)
    elif detector.in_contact:
        status = _status('external', OK, 'contact', joints=joints)
    else:
        status = _status('external', OK, 'free' if detector.has_learnt else 'learning')
    if arm.statistics.was_withheld:
        status.message += SAYS['withheld']
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
    return status


def _named(joints: Bools) -> str:
    return ', '.join(joint for joint, is_one in zip(JOINTS, joints) if is_one)


def _status(name: str, level: bytes, what: str, **details: object) -> DiagnosticStatus:
    return DiagnosticStatus(name=name, level=level, message=SAYS[what].format(**details))


def _warn_of(status: DiagnosticStatus, events: tuple[Event, ...], arm: Arm) -> None:
    """Raise the status to WARN, and say why, if any of the events occurred in the period."""
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
