"""Events in a stream of joint states: counted, reported, and mapped to remedies."""

from enum import Enum


class Event(Enum):
    """
    Reason why a message was dropped, restarted the filter, or was only partly used.

    The value is the key of the count in the diagnostics.
    """

    NOT_THIS_ARM = 'not_this_arm'
    INCOMPLETE_ARM = 'incomplete_arm'
    DUPLICATE_JOINT = 'duplicate_joint'
    LENGTH_MISMATCH = 'length_mismatch'
    NON_FINITE = 'non_finite'
    IMPLAUSIBLE = 'implausible'
    OUT_OF_ORDER = 'out_of_order'
    DUPLICATE = 'duplicate'
    UNCONFIRMED = 'unconfirmed'
    REPEATED_STAMP = 'repeated_stamp'
    RESET_GAP = 'reset_gap'
    RESET_CLOCK_JUMP = 'reset_clock_jump'
    RESET_POSITION_JUMP = 'reset_position_jump'
    RESET_VELOCITY_SOURCE = 'reset_velocity_source'
    RESET_STAMP_SOURCE = 'reset_stamp_source'
    RESET_RESYNC = 'reset_resync'
    RESET_REQUESTED = 'reset_requested'
    EFFORT_MISSING = 'effort_missing'
    EFFORT_ALL_ZERO = 'effort_all_zero'
    VELOCITY_MISSING = 'velocity_missing'
    VELOCITY_MISMATCH = 'velocity_mismatch'
    POSITION_FROZEN = 'position_frozen'
    UNSTAMPED = 'unstamped'
    AWAITING_PERIOD = 'awaiting_period'
    SPRING_HELD = 'spring_held'


# The message is dropped.
DROPPED = (Event.NOT_THIS_ARM, Event.INCOMPLETE_ARM, Event.DUPLICATE_JOINT, Event.LENGTH_MISMATCH,
           Event.NON_FINITE, Event.IMPLAUSIBLE, Event.OUT_OF_ORDER, Event.DUPLICATE,
           Event.UNCONFIRMED)
# The filter restarts.
RESETS = (Event.RESET_GAP, Event.RESET_CLOCK_JUMP, Event.RESET_POSITION_JUMP,
          Event.RESET_VELOCITY_SOURCE, Event.RESET_STAMP_SOURCE, Event.RESET_RESYNC,
          Event.RESET_REQUESTED)
# Predictions have no residual.
NO_EFFORT = (Event.EFFORT_MISSING, Event.EFFORT_ALL_ZERO)
# The slope of the positions replaces measured velocity.
NO_VELOCITY = (Event.VELOCITY_MISSING, Event.VELOCITY_MISMATCH)

# Diagnostic message per event; events without one are normal.
REMEDIES = {
    Event.INCOMPLETE_ARM:
        "messages contain some but not all of the arm's seven joints: publish all of them in each "
        'message',
    Event.DUPLICATE_JOINT:
        'messages contain a joint of the arm twice: publish each joint once per message',
    Event.LENGTH_MISMATCH:
        'position, velocity or effort differs in length from name: fill the field for all joints, '
        'or leave velocity or effort empty',
    Event.NON_FINITE:
        'messages with NaN positions or infinite values of the arm are dropped: check the '
        'publisher',
    Event.IMPLAUSIBLE:
        'values outside the range of a Baxter (2 pi rad, 40 rad/s, 1000 N m): check that the '
        'units are rad, rad/s and N m',
    Event.OUT_OF_ORDER:
        'stamps run backwards: check for reordered messages or a second publisher on the topic',
    Event.DUPLICATE:
        'messages arrive twice with the same stamp and data: check whether the topic is bridged '
        'twice',
    Event.UNCONFIRMED:
        'messages that do not continue the stream are dropped until the next one confirms them: '
        'check for a second publisher on the topic',
    Event.REPEATED_STAMP:
        'new data stamped less than 0.5 ms after the previous message: re-timed if this persists '
        'and the parameter stamps is auto',
    Event.UNSTAMPED:
        'header stamps are zero: using the time of receipt',
    Event.VELOCITY_MISSING:
        'no measured velocity (empty or NaN): using the slope of the positions',
    Event.VELOCITY_MISMATCH:
        'measured velocity contradicts the positions: using the slope of the positions',
    Event.POSITION_FROZEN:
        'positions are frozen although measured velocity is not zero: check the publisher',
    Event.RESET_GAP:
        'more than 0.25 s between stamps: check the network, the rate of the publisher, and '
        'whether this process was suspended',
    Event.RESET_CLOCK_JUMP:
        'stamps jumped back by 0.5 s or more: check for a restarted bag or simulation, or a '
        'second publisher on the topic',
    Event.RESET_POSITION_JUMP:
        'positions jump faster than the arm can move: check for a second publisher on the topic, '
        'or a simulated arm that was repositioned',
    Event.RESET_VELOCITY_SOURCE:
        'the velocity source changed between measured velocity and slope of the positions',
    Event.RESET_STAMP_SOURCE:
        'the stamp source changed (header, arrival or receipt): see the status stamps',
    Event.RESET_RESYNC:
        're-timing restarted because messages no longer arrive at a steady rate: check the rate '
        'of the publisher and the network',
    Event.EFFORT_MISSING:
        'no measured effort (empty or NaN): predictions only, no residual and no contact',
    Event.EFFORT_ALL_ZERO:
        'measured effort is exactly zero on all joints: predictions only, no residual and no '
        'contact',
    Event.SPRING_HELD:
        's1 is outside effort_model.spring_range: using the spring torque at the limit, expect a '
        'residual at s1',
}
