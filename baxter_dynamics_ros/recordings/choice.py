"""Choice of a bag's topic and arm: the requested one, or the only one."""

from collections.abc import Callable, Iterable
from pathlib import Path

from .diagnosis import BagError
from ..model.joints import joint_names, SIDES

JOINT_STATE = 'sensor_msgs/msg/JointState'
READABLE = ('cdr', 'ros1')  # encodings of messages
USUAL_TOPIC = '/robot/joint_states'
_SHOWN = 8  # names in a message


def choose_arm(where: str, names: set[str], arm: 'str | None') -> str:
    """Return the requested arm, or the only one, among recorded joints; raise BagError."""
    sides = sides_of(names, arm)
    if not sides:
        found = f'only {_list(names)}' if names else 'its joint states name no joints'
        raise BagError(f'{where} has no joints of {_any(arm)}, {found}')
    if len(sides) > 1:
        raise BagError(f"{where} has both arms' joints: choose --arm right or --arm left")
    return sides[0]


def choose_topic(path: Path, topics: dict[str, set[str]], topic: 'str | None', arm: 'str | None',
                 peek: Callable[[str], set[str]]) -> str:
    """
    Return the topic with an arm's joint states.

    Parameters
    ----------
    path : Path
        The bag, for error messages.
    topics : dict
        Topic -> types of its messages, with the encoding in parentheses if it is not readable.
    topic, arm : str or None
        Requested topic and arm; by default the robot's usual topic, or else the only one.
    peek : callable
        Topic -> joints that its first messages name.

    """
    candidates = sorted(name for name, types in topics.items() if JOINT_STATE in types)
    if topic in candidates:
        return topic
    if topic is not None or not candidates:
        problem = '' if topic is None else (
            f'{topic} holds {_list(topics[topic])}, not {JOINT_STATE}; ' if topic in topics else
            f'has no messages on {topic}; ' if topics else '')
        raise BagError(f'{path}: {problem}{_contents(topics, candidates)}')
    usual = USUAL_TOPIC in candidates
    if len(candidates) == 1 or usual and sides_of(peek(USUAL_TOPIC), arm):
        return USUAL_TOPIC if usual else candidates[0]
    fitting = [name for name in candidates if sides_of(peek(name), arm)]
    options = ' or '.join(f'--topic {name}' for name in fitting)
    if not fitting:
        raise BagError(f'{path}: no topic has joints of {_any(arm)}; '
                       + '; '.join(f'{name} has {_list(peek(name))}' for name in candidates))
    if usual:
        raise BagError(f'{path}: {USUAL_TOPIC} has no joints of {_any(arm)}, only '
                       f'{_list(peek(USUAL_TOPIC))}; choose {options}')
    if len(fitting) > 1:
        raise BagError(f"{path}: several topics have an arm's joints: choose {options}")
    return fitting[0]


def sides_of(names: set[str], arm: 'str | None' = None) -> list[str]:
    """Return the sides whose joints are among the names, restricted to arm if given."""
    return [side for side in SIDES
            if arm in (None, side) and not names.isdisjoint(joint_names(side))]


def _contents(topics: dict[str, set[str]], candidates: list[str]) -> str:
    if not topics:
        return 'has no messages'
    if candidates:
        return f'joint states are on {_list(candidates)}'
    for name, types in sorted(topics.items()):
        for kind in types:
            if kind.startswith(f'{JOINT_STATE} ('):
                return (f'the joint states on {name} are encoded as {kind.split("(")[1][:-1]}; '
                        'only CDR and ROS 1 messages can be read')
    return f'no topic has joint states; there are {_list(topics)}'


def _any(arm: 'str | None') -> str:
    return f'the {arm} arm' if arm else 'an arm'


def _list(names: Iterable[str]) -> str:
    names = sorted(names)
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return ', '.join(names[:_SHOWN]) + more
