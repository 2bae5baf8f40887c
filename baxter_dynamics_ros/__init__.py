"""Lagrange-Euler dynamics of the Baxter robot's arms, with a live torque predictor for ROS 2."""

from .model import (ArgumentError, ArmParameters, BaxterArm, BaxterDynamicsError, EffortModel,
                    joint_names, JOINTS, link_parameters, mount, Payload)

__version__ = '0.1.0'

__all__ = ['ArgumentError', 'ArmParameters', 'BaxterArm', 'BaxterDynamicsError', 'EffortModel',
           'joint_names', 'JOINTS', 'link_parameters', 'mount', 'Payload']
