"""Joint states of one arm in a recording, and the choice of the arm."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, Protocol

from ..model.arrays import Array
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import joint_names, SIDES

USUAL_TOPIC = '/robot/joint_states'
JOINT_STATE = 'sensor_msgs/msg/JointState'
_SHOWN = 8  # names in a message


class BagError(BaxterDynamicsError):
    """A recording cannot be read or written; the message begins with its path."""


class JointState(NamedTuple):
    """A joint state as recorded."""

    stamp_ns: int  # of the header [ns]
    names: Sequence[str]  # joints
    position: Array  # [rad]; as long as names, unless the message is malformed
    velocity: Array  # [rad/s]; as long, or empty
    effort: Array  # [N m]; as long, or empty
    received_ns: int  # time of recording [ns]


class Recording(Protocol):
    """Joint states of one arm, in the order of recording."""

    name: str
    topic: str
    arm: str
    count: int  # messages

    def __iter__(self) -> Iterator[JointState]:
        """Yield each joint state."""


def choose_arm(where: str, names: set[str], arm: 'str | None') -> str:
    """Return the requested arm, or the only one, among recorded joints; raise BagError."""
    sides = sides_of(names, arm)
    if not sides:
        found = f'only {listed(names)}' if names else 'its joint states name no joints'
        raise BagError(f'{where} has no joints of {f"the {arm}" if arm else "an"} arm, {found}')
    if len(sides) > 1:
        raise BagError(f"{where} has both arms' joints: choose --arm right or --arm left")
    return sides[0]


def sides_of(names: set[str], arm: 'str | None' = None) -> list[str]:
    """Return the sides whose joints are among the names, restricted to arm if given."""
    return [side for side in SIDES
            if arm in (None, side) and not names.isdisjoint(joint_names(side))]


def listed(names: Iterable[str]) -> str:
    """Return the first names in alphabetical order, and the number of the others."""
    names = sorted(names)
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return ', '.join(names[:_SHOWN]) + more
