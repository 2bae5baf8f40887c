"""Dynamics, kinematics and effort model of the arm; needs only NumPy."""

from .arm import BaxterArm
from .arrays import Array, ArrayLike, Bools, finite, Indices, rms
from .effort import BAND, EffortModel, Presliding
from .exceptions import ArgumentError, BaxterDynamicsError, first_names, printable
from .joints import (BASE_FRAME, joint_names, JOINTS, mount, N_JOINTS, names_of, S1, SIDES,
                     VELOCITY_LIMIT)
from .parameters import ArmParameters, link_parameters, Payload
from .setting import Setting

__all__ = [
    'ArgumentError', 'ArmParameters', 'Array', 'ArrayLike', 'BAND', 'BASE_FRAME', 'BaxterArm',
    'BaxterDynamicsError', 'Bools', 'EffortModel', 'finite', 'first_names', 'Indices',
    'joint_names', 'JOINTS', 'link_parameters', 'mount', 'N_JOINTS', 'names_of', 'Payload',
    'Presliding', 'printable', 'rms', 'S1', 'Setting', 'SIDES', 'VELOCITY_LIMIT']
