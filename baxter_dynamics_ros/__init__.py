"""Lagrange-Euler dynamics of the Baxter robot's arms, and a live torque predictor for ROS 2."""

from .core.arm import BaxterArm
from .core.effort import EffortModel
from .core.exceptions import ArgumentError
from .core.exceptions import BaxterDynamicsError
from .core.joints import joint_names
from .core.joints import JOINTS
from .core.joints import mount
from .core.parameters import ArmParameters
from .core.parameters import link_parameters
from .core.parameters import Payload

__version__ = '0.1.0'

__all__ = [
    'ArgumentError',
    'ArmParameters',
    'BaxterArm',
    'BaxterDynamicsError',
    'EffortModel',
    'JOINTS',
    'Payload',
    'joint_names',
    'link_parameters',
    'mount',
]
