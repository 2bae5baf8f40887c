"""Events in a stream of joint states: counted, reported, and mapped to remedies."""

from enum import Enum


class Event(Enum):
    """
    Reason why a message was dropped, restarted the filter, or was only partly used.

    The value is the key of the count in the diagnostics, the remedy the text of the warning there;
    events without a remedy are normal.
    """

    remedy: str

    def __new__(cls, key: str, remedy: str = '') -> 'Event':
        """Return the event with this value."""
        event = object.__new__(cls)
        event._value_, event.remedy = key, remedy
        return event

    NOT_THIS_ARM = 'not_this_arm'
    INCOMPLETE_ARM = (
        'incomplete_arm', "messages contain some but not all of the arm's seven joints: publish "
        'all of them in each message')
    DUPLICATE_JOINT = (
        'duplicate_joint', 'messages contain a joint of the arm twice: publish each joint once '
        'per message')
    LENGTH_MISMATCH = (
        'length_mismatch', 'position, velocity or effort differs in length from name: fill the '
        'field for all joints, or leave velocity or effort empty')
    NON_FINITE = (
        'non_finite', 'messages with NaN positions or infinite values of the arm are dropped: '
        'check the publisher')
    IMPLAUSIBLE = (
        'implausible', 'values outside the range of a Baxter (2 pi rad, 40 rad/s, 1000 N m): '
        'check that the units are rad, rad/s and N m')
    OUT_OF_ORDER = (
        'out_of_order', 'stamps run backwards: check for reordered messages or a second publisher '
        'on the topic')
    DUPLICATE = (
        'duplicate', 'messages arrive twice with the same stamp and data: check whether the topic '
        'is bridged twice')
    UNCONFIRMED = (
        'unconfirmed', 'messages that do not continue the stream are dropped until the next one '
        'confirms them: check for a second publisher on the topic')
    REPEATED_STAMP = (
        'repeated_stamp', 'new data stamped less than 0.5 ms after the previous message: re-timed '
        'if this persists and the parameter stamps is auto')
    UNSTAMPED = 'unstamped', 'header stamps are zero: using the time of receipt'
    VELOCITY_MISSING = (
        'velocity_missing', 'no measured velocity (empty or NaN): using the slope of the '
        'positions')
    VELOCITY_MISMATCH = (
        'velocity_mismatch', 'measured velocity contradicts the positions: using the slope of the '
        'positions')
    POSITION_FROZEN = (
        'position_frozen', 'positions are frozen although measured velocity is not zero: check '
        'the publisher')
    RESET_GAP = (
        'reset_gap', 'more than 0.25 s between stamps: check the network, the rate of the '
        'publisher, and whether this process was suspended')
    RESET_CLOCK_JUMP = (
        'reset_clock_jump', 'stamps jumped back: check for a restarted bag or simulation, or a '
        'second publisher on the topic')
    RESET_POSITION_JUMP = (
        'reset_position_jump', 'positions jump faster than the arm can move: check for a second '
        'publisher on the topic, a simulated arm that was repositioned, or angles that wrap')
    RESET_VELOCITY_SOURCE = (
        'reset_velocity_source', 'the velocity source changed between measured velocity and slope '
        'of the positions')
    RESET_STAMP_SOURCE = (
        'reset_stamp_source', 'the stamp source changed (header, arrival or receipt): set '
        'the parameter stamps to keep one source')
    RESET_RESYNC = (
        'reset_resync', 're-timing restarted because messages no longer arrive at a steady rate: '
        'check the rate of the publisher and the network')
    RESET_REQUESTED = 'reset_requested'
    EFFORT_MISSING = (
        'effort_missing', 'no measured effort (empty or NaN): predictions only, no residual and '
        'no contact')
    EFFORT_ALL_ZERO = (
        'effort_all_zero', 'measured effort is exactly zero on all joints: predictions only, no '
        'residual and no contact')
    AWAITING_PERIOD = 'awaiting_period'
    SPRING_HELD = (
        'spring_held', 's1 is outside effort_model.spring_range: using the spring torque at the '
        'limit, expect a residual at s1; check that angles run from -pi to pi')


# The message is dropped.
DROPPED = (Event.NOT_THIS_ARM, Event.INCOMPLETE_ARM, Event.DUPLICATE_JOINT, Event.LENGTH_MISMATCH,
           Event.NON_FINITE, Event.IMPLAUSIBLE, Event.OUT_OF_ORDER, Event.DUPLICATE,
           Event.UNCONFIRMED)
# The filter restarts.
RESETS = tuple(event for event in Event if event.name.startswith('RESET_'))
# Predictions have no residual.
NO_EFFORT = (Event.EFFORT_MISSING, Event.EFFORT_ALL_ZERO)
# The slope of the positions replaces measured velocity.
NO_VELOCITY = (Event.VELOCITY_MISSING, Event.VELOCITY_MISMATCH)
