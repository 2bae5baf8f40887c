"""Conversions between ROS messages and NumPy arrays."""

from array import array
from collections.abc import Iterable

from geometry_msgs.msg import Vector3
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ..model import Array

_NOTHING = np.zeros(0)
_NANOSECONDS = 1_000_000_000
_LAST = 2 ** 31 * _NANOSECONDS - 1  # latest stamp: seconds are signed 32-bit integers


def from_field(field: 'array[float]') -> Array:
    """View a ``float64[]`` field as an array, without a copy."""
    return np.frombuffer(field) if len(field) else _NOTHING


def to_field(values: Array) -> 'array[float]':
    """Return a float array as the value of a ``float64[]`` field."""
    return array('d', values.tobytes())


def stamp_ns(header: Header) -> int:
    """Return a header's stamp [ns]."""
    return header.stamp.sec * _NANOSECONDS + header.stamp.nanosec


def set_stamp(header: Header, ns: int) -> None:
    """Set a header's stamp [ns], clipped to the range of a stamp."""
    header.stamp.sec, header.stamp.nanosec = divmod(min(max(ns, 0), _LAST), _NANOSECONDS)


def set_vector(vector: Vector3, values: Array) -> None:
    """Set a ``geometry_msgs/Vector3`` to values (3,)."""
    vector.x, vector.y, vector.z = values.tolist()


def joint_state(names: Iterable[str], ns: int, position: Array = _NOTHING,
                velocity: Array = _NOTHING, effort: Array = _NOTHING) -> JointState:
    """Return a joint state with a stamp [ns]."""
    message = JointState(name=list(names), position=to_field(position),
                         velocity=to_field(velocity), effort=to_field(effort))
    set_stamp(message.header, ns)
    return message
