"""What can be wrong with a joint state, and what to do about it: counted, reported, never lost."""

from enum import Enum


class Event(Enum):
    """
    A reason why a message gave no prediction, or restarted the filter.

    The value is the key under which it is counted in the diagnostics.
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
    RESET_RETIMED = 'reset_retimed'
    RESET_RESYNC = 'reset_resync'
    RESET_REQUESTED = 'reset_requested'
    EFFORT_MISSING = 'effort_missing'
    EFFORT_ALL_ZERO = 'effort_all_zero'
    VELOCITY_MISSING = 'velocity_missing'
    UNSTAMPED = 'unstamped'
    SPRING_HELD = 'spring_held'


# The message is dropped.
DROPPED = (Event.NOT_THIS_ARM, Event.INCOMPLETE_ARM, Event.DUPLICATE_JOINT, Event.LENGTH_MISMATCH,
           Event.NON_FINITE, Event.IMPLAUSIBLE, Event.OUT_OF_ORDER, Event.DUPLICATE,
           Event.UNCONFIRMED)
# The filter starts anew.
RESETS = (Event.RESET_GAP, Event.RESET_CLOCK_JUMP, Event.RESET_POSITION_JUMP,
          Event.RESET_VELOCITY_SOURCE, Event.RESET_RETIMED, Event.RESET_RESYNC,
          Event.RESET_REQUESTED)
# There is no residual.
NO_EFFORT = (Event.EFFORT_MISSING, Event.EFFORT_ALL_ZERO)

# What a user should know of each, in one line. Those without a line are normal.
REMEDIES = {
    Event.INCOMPLETE_ARM:
        "messages name some of the arm's joints but not all: check the publisher",
    Event.DUPLICATE_JOINT: 'messages name a joint of the arm twice: check the publisher',
    Event.LENGTH_MISMATCH:
        'position, velocity or effort is not as long as name: check the publisher',
    Event.NON_FINITE: 'messages hold NaN or infinity: check the publisher',
    Event.IMPLAUSIBLE:
        'positions beyond a full turn, or velocities or efforts no Baxter has: are they in rad, '
        'rad/s, N m?',
    Event.OUT_OF_ORDER: 'stamps run backwards: is there a second publisher on the topic?',
    Event.DUPLICATE: 'the same message arrives twice: is the topic bridged twice?',
    Event.UNCONFIRMED:
        'messages that do not continue the stream are dropped until the next one confirms them: '
        'is there a second publisher on the topic?',
    Event.REPEATED_STAMP:
        'several messages bear one stamp, as times of arrival do: the parameter stamps at auto '
        're-times them once that is certain, arrival from the start',
    Event.UNSTAMPED:
        'the stamps are not filled in: the time of arrival at this node takes their place',
    Event.RESET_GAP:
        'more than 0.25 s between stamps: check the network and the rate, and whether this '
        'process was stopped',
    Event.RESET_CLOCK_JUMP:
        "the stamps' clock was set back: did a bag loop or a simulation start over, or are there "
        'two publishers on the topic?',
    Event.RESET_POSITION_JUMP:
        'positions jump faster than the arm can move: is there a second publisher on the topic, '
        'or was a simulated arm put elsewhere?',
    Event.RESET_VELOCITY_SOURCE:
        'velocity comes and goes: is there a second publisher on the topic?',
    Event.RESET_RETIMED:
        'stamps are times of arrival and are re-timed from here on; better is a bridge that '
        "keeps the robot's stamps",
    Event.RESET_RESYNC:
        'times of arrival ran away from the re-timed ones: did the rate change, or are many '
        'messages lost?',
    Event.EFFORT_MISSING: 'no measured effort: predictions only, no residual',
    Event.EFFORT_ALL_ZERO:
        'measured effort is exactly zero on all joints, as some simulators publish: effort '
        'invalid, no residual',
    Event.VELOCITY_MISSING: 'no measured velocity: using the slope of the positions',
    Event.SPRING_HELD:
        's1 is outside the range for which the spring is known: its value at the border is held, '
        'expect a residual at s1',
}
