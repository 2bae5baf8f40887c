"""Problems of joint states that are counted and reported, with their remedies."""

from enum import Enum


class Event(Enum):
    """
    A reason why a message gave no prediction, or restarted the filter, or is used only in part.

    The value is the key of its count in the diagnostics.
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
# There is no residual.
NO_EFFORT = (Event.EFFORT_MISSING, Event.EFFORT_ALL_ZERO)
# The slope of the positions replaces measured velocity.
NO_VELOCITY = (Event.VELOCITY_MISSING, Event.VELOCITY_MISMATCH)

# One line for the user per event. Events without a line are normal.
REMEDIES = {
    Event.INCOMPLETE_ARM:
        "messages name some of the arm's joints but not all seven: publish all in each message",
    Event.DUPLICATE_JOINT:
        'messages name a joint of the arm twice: publish each joint once in a message',
    Event.LENGTH_MISMATCH:
        'position, velocity or effort does not have as many values as name: fill the field for '
        'all joints, or leave velocity or effort empty',
    Event.NON_FINITE:
        'messages contain NaN positions or infinite values of the arm: dropped',
    Event.IMPLAUSIBLE:
        'values beyond the range of a Baxter (2 pi rad, 40 rad/s, 1000 N m): check the units, '
        'which must be rad, rad/s and N m',
    Event.OUT_OF_ORDER:
        'stamps run backwards: check for reordered messages or a second publisher on the topic',
    Event.DUPLICATE:
        'messages arrive twice with the same stamp and data: check for a topic that is bridged '
        'twice',
    Event.UNCONFIRMED:
        'messages that do not continue the stream are dropped until the next one confirms them: '
        'check for a second publisher on the topic',
    Event.REPEATED_STAMP:
        'new data are stamped less than 0.5 ms after the last message: with the parameter stamps '
        'at auto they are re-timed if that persists',
    Event.UNSTAMPED:
        'header stamps are zero: using the time of receipt',
    Event.VELOCITY_MISSING:
        'no measured velocity (empty or NaN): using the slope of the positions',
    Event.VELOCITY_MISMATCH:
        'measured velocity contradicts the positions: using the slope of the positions',
    Event.POSITION_FROZEN:
        'positions do not change although measured velocity is not zero',
    Event.RESET_GAP:
        'more than 0.25 s between stamps: check the network, the rate of the publisher, and '
        'whether this process was suspended',
    Event.RESET_CLOCK_JUMP:
        'stamps went back by 0.5 s or more: check for a bag or simulation that started over, or '
        'a second publisher on the topic',
    Event.RESET_POSITION_JUMP:
        'positions jump faster than the arm can move: check for a second publisher on the topic, '
        'or a simulated arm that was repositioned',
    Event.RESET_VELOCITY_SOURCE:
        'the source of velocity changed (measured, or slope of the positions)',
    Event.RESET_STAMP_SOURCE:
        'the source of stamps changed (header, arrival or receipt): see stamps',
    Event.RESET_RESYNC:
        'messages left the even time line by more than their jitter: check the rate of the '
        'publisher and the network',
    Event.EFFORT_MISSING:
        'no measured effort (empty or NaN): predictions only, no residual and no contact',
    Event.EFFORT_ALL_ZERO:
        'measured effort is exactly zero on all joints: predictions only, no residual and no '
        'contact',
    Event.SPRING_HELD:
        's1 is outside effort_model.spring_range: its value at the border is held, expect a '
        'residual at s1',
}
