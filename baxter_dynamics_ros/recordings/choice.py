"""Choice of a bag's topic and arm: the given one, or the only one."""

from collections.abc import Callable, Iterable
from pathlib import Path

from .diagnosis import BagError
from ..model.joints import joint_names, SIDES

JOINT_STATE = 'sensor_msgs/msg/JointState'
READABLE = ('cdr', 'ros1')  # encodings of messages
USUAL_TOPIC = '/robot/joint_states'
_SHOWN = 8  # names in a message


def choose_arm(where: str, names: set[str], arm: 'str | None') -> str:
    """
    Return the side of the arm whose joint states are recorded.

    Parameters
    ----------
    where : str
        What an error begins with: path and topic.
    names : set of str
        The joints that are recorded there.
    arm : str or None
        The side that is wanted; None to find it.

    Raises
    ------
    BagError
        If that arm's joints are not there, or, without one wanted, no arm's or both arms'.

    """
    sides = sides_of(names)
    only = f'only {_list(names)}' if names else 'for its joint states name no joints'
    if not sides:
        raise BagError(f'{where} has no joints of an arm, {only}')
    if arm is None:
        if len(sides) > 1:
            raise BagError(f"{where} holds both arms' joints: choose --arm right or --arm left")
        return sides[0]
    if arm not in sides:
        raise BagError(f'{where} has no joints of the {arm} arm, {only}')
    return arm


def choose_topic(path: Path, topics: dict[str, set[str]], topic: 'str | None', arm: 'str | None',
                 peek: Callable[[str], set[str]]) -> str:
    """
    Return the topic that holds an arm's joint states.

    Parameters
    ----------
    path : Path
        What an error begins with.
    topics : dict
        Topic -> set of the types of its messages; topics without messages are left out.
    topic : str or None
        The topic that is wanted; None for the robot's usual one, or else the only one.
    arm : str or None
        The side that is wanted; None for any.
    peek : callable
        Topic -> set of the joints that its first messages name.

    Raises
    ------
    BagError
        If there is none, or more than one; says what there is.

    """
    if not topics:
        raise BagError(f'{path}: holds no messages')
    candidates = sorted(name for name, types in topics.items() if JOINT_STATE in types)
    there = _contents(topics, candidates)
    if topic is not None:
        if topic in candidates:
            return topic
        if topic in topics:
            raise BagError(f'{path}: {topic} holds {_list(topics[topic])}, not {JOINT_STATE}; '
                           f'{there}')
        raise BagError(f'{path}: has no messages on {topic}; {there}')
    if not candidates:
        raise BagError(f'{path}: {there}')
    if len(candidates) == 1 or USUAL_TOPIC in candidates and sides_of(peek(USUAL_TOPIC), arm):
        return USUAL_TOPIC if USUAL_TOPIC in candidates else candidates[0]
    fitting = [name for name in candidates if sides_of(peek(name), arm)]
    options = ' or '.join(f'--topic {name}' for name in fitting)
    if not fitting:
        raise BagError(f'{path}: no topic holds joints of {_any(arm)}; '
                       + '; '.join(f'{name} has {_list(peek(name))}' for name in candidates))
    if USUAL_TOPIC in candidates:
        raise BagError(f'{path}: {USUAL_TOPIC} has no joints of {_any(arm)}, only '
                       f'{_list(peek(USUAL_TOPIC))}; choose {options}')
    if len(fitting) > 1:
        raise BagError(f"{path}: several topics hold an arm's joints: choose {options}")
    return fitting[0]


def sides_of(names: set[str], arm: 'str | None' = None) -> list[str]:
    """Return the sides whose joints are among the names, or of these the given one."""
    return [side for side in SIDES
            if arm in (None, side) and not names.isdisjoint(joint_names(side))]


def _contents(topics: dict[str, set[str]], candidates: list[str]) -> str:
    if candidates:
        return f'joint states are on {_list(candidates)}'
    for name, types in sorted(topics.items()):
        for kind in types:
            if kind.startswith(f'{JOINT_STATE} ('):
                return (f'the joint states on {name} are encoded as {kind.split("(")[1][:-1]}; '
                        'only CDR and ROS 1 messages can be read')
    return f'no topic holds joint states; there are {_list(topics)}'


def _any(arm: 'str | None') -> str:
    return f'the {arm} arm' if arm else 'an arm'


def _list(names: Iterable[str]) -> str:
    names = sorted(names)
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return ', '.join(names[:_SHOWN]) + more
