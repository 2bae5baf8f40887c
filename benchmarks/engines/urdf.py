"""The arm as a URDF, for the engines that read one."""

from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np


def arm_urdf(parameters, extra: str = '') -> str:
    """
    Return a URDF of the arm, fixed to a link ``world`` that is frame {0}.

    Link i turns with joint i about the z axis of frame {i-1} and has that frame's axes at
    q_i = 0, so that what follows it in eq. (2), theta_offset included, lies in the link.

    Inertias are in principal axes: an engine that wants them so would get there by an iteration
    of its own (PyBullet's ends at 1e-9 N m).

    Parameters
    ----------
    parameters : ArmParameters
        The links.
    extra : str, optional
        Elements of the engine's own.

    """
    parts = [f'<robot name="arm">{extra}<link name="world"/>']
    parent, origin = 'world', ''
    for i, joint in enumerate(JOINTS):
        offset, alpha = parameters.theta_offset[i], parameters.alpha[i]
        rotation = _rotation_z(offset) @ _rotation_x(alpha)  # from link i's frame of the paper
        translation = _rotation_z(offset) @ [parameters.a[i], 0.0, parameters.d[i]]
        center = translation + rotation @ parameters.center_of_mass[i]
        moments, axes = np.linalg.eigh(rotation @ parameters.inertia[i] @ rotation.T)
        axes[:, 0] *= np.linalg.det(axes)  # right-handed
        xx, yy, zz = (repr(float(moment)) for moment in moments)
        parts.append(
            f'<joint name="{joint}" type="continuous">{origin}<axis xyz="0 0 1"/>'
            f'<parent link="{parent}"/><child link="link_{joint}"/></joint>'
            f'<link name="link_{joint}"><inertial>{_origin(center, _angles(axes))}'
            f'<mass value="{float(parameters.mass[i])!r}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
            '</inertial></link>')
        parent, origin = f'link_{joint}', _origin(translation, (alpha, 0.0, offset))
    return ''.join(parts) + '</robot>'


def _rotation_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _angles(rotation: np.ndarray) -> tuple:
    """Return roll, pitch and yaw [rad] of a rotation whose x axis is not along z."""
    return (np.arctan2(rotation[2, 1], rotation[2, 2]), np.arcsin(-rotation[2, 0]),
            np.arctan2(rotation[1, 0], rotation[0, 0]))


def _origin(xyz, rpy) -> str:
    return f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>'


def _text(numbers) -> str:
    return ' '.join(repr(float(number)) for number in numbers)
