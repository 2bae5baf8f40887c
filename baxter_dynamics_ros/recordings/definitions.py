"""The message types of recordings, as ROS 2 defines them."""

from functools import lru_cache

from rosbags.convert.converter import is_same_wireformat
from rosbags.interfaces import (Connection, ConnectionExtRosbag1, MessageDefinition,
                                MessageDefinitionFormat)
from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import get_types_from_idl, get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

JOINT_STATE = 'sensor_msgs/msg/JointState'

_HEADER = 'std_msgs/msg/Header'  # has a field less in ROS 2
_SEPARATOR = '=' * 80 + '\n'  # between the types of a definition


class UnknownTypeError(Exception):
    """A connection's type cannot be had as ROS 2 defines it; the message says why."""


@lru_cache
def ros1() -> Typestore:
    """Return ROS 1's own types (Noetic)."""
    return get_typestore(Stores.ROS1_NOETIC)


@lru_cache
def ros2() -> Typestore:
    """Return ROS 2's own types (Jazzy)."""
    return get_typestore(Stores.ROS2_JAZZY)


def is_ros1(connection: Connection) -> bool:
    """Return whether the connection's messages are laid out as ROS 1 does."""
    return isinstance(connection.ext, ConnectionExtRosbag1)


def standard_types(name: str) -> Typesdict:
    """Return one of ROS 2's own types and those it is made of: name -> definition."""
    return get_types_from_msg(ros2().generate_msgdef(name, ros_version=2)[0], name)


def types_of(connection: Connection) -> Typesdict:
    """
    Return a connection's type and those it is made of, as ROS 2 has them: name -> definition.

    They are the bag's own, but where it has none, and for ROS 1's standard types.

    Raises
    ------
    UnknownTypeError
        If neither the bag nor ROS 2 defines it, the definition cannot be read, or a standard type
        has other fields in ROS 2.

    """
    name, definition = connection.msgtype, connection.msgdef
    is_standard = name in ros2().fielddefs
    if definition.format == MessageDefinitionFormat.NONE:
        if not is_standard:
            raise UnknownTypeError(f'the bag does not define its type {name}')
        return standard_types(name)
    own = get_typestore(Stores.EMPTY)
    try:
        types = _parse(definition, name)
        own.register(types)
        own.generate_msgdef(name)
        own.hash_rihs01(name)  # these two fail if it is made of something unknown
    except Exception as error:  # of the parser: whatever the text leads it to
        raise UnknownTypeError(f'the definition of its type {name} cannot be read '
                               f'({type(error).__name__})') from None
    if not is_ros1(connection):
        return types
    if not is_standard:
        return types | ({_HEADER: ros2().fielddefs[_HEADER]} if _HEADER in types else {})
    if not is_same_wireformat(own, ros2(), name, name):
        raise UnknownTypeError(f'its type {name} has other fields in ROS 2')
    return standard_types(name)


def _parse(definition: MessageDefinition, name: str) -> Typesdict:
    if definition.format == MessageDefinitionFormat.MSG:
        return get_types_from_msg(definition.data, name)
    if not definition.data.startswith(_SEPARATOR):
        return get_types_from_idl(definition.data)
    types = {}
    for part in definition.data.split(_SEPARATOR)[1:]:
        types.update(get_types_from_idl(part.partition('\n')[2]))  # without its line 'IDL: name'
    return types
