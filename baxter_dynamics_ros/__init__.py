"""Lagrange-Euler dynamics of the Baxter robot's arms, with a live torque predictor for ROS 2."""

from .model.arm import BaxterArm
from .model.effort import EffortModel
from .model.exceptions import ArgumentError, BaxterDynamicsError
from .model.joints import joint_names, JOINTS, mount
from .model.parameters import ArmParameters, link_parameters, Payload

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
