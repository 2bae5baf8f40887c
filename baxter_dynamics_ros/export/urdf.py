"""Export as URDF: the manufacturer's description with the parameters of one arm."""

from pathlib import Path
import re
import xml.etree.ElementTree as ET

import numpy as np

from .sources import head
from ..model import Array, BaxterArm, EffortModel, N_JOINTS
from ..model.lagrange_euler import transform
from ..model.parameters import from_pseudo_inertia
from ..simulation.description import add_inertia, Description, DescriptionError, numbers


def files(arm: BaxterArm, command: str, side: str, effort: EffortModel,
          description: Path | None = None) -> dict[str, str]:
    """
    Return the exported file: its name -> its text.

    The arm's joints get the geometry of Table II, its links the masses, centres of mass and
    inertias of the arm with its payload, and its joints the viscous and Coulomb friction of the
    effort model. Link frames keep their orientation, so that meshes stay in place. The gripper is
    left out: a payload stands for it. The other arm and the head are unchanged. ``arm`` has the
    mount of its side; ``description`` is the robot's URDF, by default an installed one.
    """
    robot = Description(side, description)
    for joint in robot.carried:
        for inertial in robot.child[joint].findall('inertial'):
            robot.child[joint].remove(inertial)
    described = [_pose([*robot.above(joint), joint]) for joint in robot.joints]
    before = _pose(robot.above(robot.joints[0]))
    for k, joint in enumerate(robot.joints):
        frame, mass, center, inertia = _link(arm, k, described[k])
        _set_origin(joint, np.linalg.inv(before) @ frame)
        before = frame
        _child(joint, 'dynamics').attrib.update(damping=numbers(effort.viscous[k]),
                                                friction=numbers(effort.coulomb[k]))
        add_inertia(robot.child[joint], mass, center, inertia)
    # A comment in XML contains no two hyphens in a row.
    about = re.sub('-(?=-)', '- ', '\n     '.join(head(arm, command)))
    robot.root.insert(0, ET.Comment(f' {about} '))
    ET.indent(robot.root)
    return {f'baxter_{side}.urdf': '<?xml version="1.0"?>\n' + ET.tostring(
        robot.root, encoding='unicode') + '\n'}


def _link(arm: BaxterArm, k: int, described: Array) -> tuple[Array, Array, Array, Array]:
    """Return a link's frame in the base, mass, and centre and inertia about it in that frame."""
    p = arm.parameters
    before, frame = (arm.mount @ transform(p, 0, i, np.zeros(N_JOINTS)) for i in (k, k + 1))
    joint = before @ _turn(p.theta_offset[k], 'z')
    # The description turns its frames about the joint's axis by multiples of 90 degrees and
    # shifts them along it.
    offset = np.linalg.inv(joint) @ described
    quarters = round(np.arctan2(offset[1, 0], offset[0, 0]) / (np.pi / 2))
    own = joint @ _turn(np.pi / 2 * quarters, 'z')
    own[:3, 3] += offset[2, 3] * own[:3, 2]
    if np.abs(own - described).max() > 0.02:
        raise DescriptionError(f'link {k + 1} of the description lies elsewhere than Table II '
                               "and the mount say; is it a Baxter's arm?")
    to_own = np.linalg.inv(own) @ frame
    pseudo = p.pseudo_inertia[k]
    if k == N_JOINTS - 1:
        pseudo = pseudo + arm.payload.pseudo_inertia
    return own, *from_pseudo_inertia(to_own @ pseudo @ to_own.T)


def _child(element: ET.Element, tag: str) -> ET.Element:
    found = element.find(tag)
    return ET.SubElement(element, tag) if found is None else found


def _pose(joints: list[ET.Element]) -> Array:
    """Return the pose (4, 4) of the last of a chain of joints, all at zero."""
    pose = np.eye(4)
    for joint in joints:
        origin = _child(joint, 'origin')
        roll, pitch, yaw = map(float, origin.get('rpy', '0 0 0').split())
        turned = _turn(yaw, 'z') @ _turn(pitch, 'y') @ _turn(roll, 'x')
        turned[:3, 3] = list(map(float, origin.get('xyz', '0 0 0').split()))
        pose = pose @ turned
    return pose


def _set_origin(joint: ET.Element, pose: Array) -> None:
    r = pose[:3, :3]
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    if abs(r[2, 0]) > 1 - 1e-9:  # roll and yaw turn about the same axis
        roll, yaw = np.arctan2(-r[1, 2], r[1, 1]), 0.0
    else:
        roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    _child(joint, 'origin').attrib.update(xyz=numbers(pose[:3, 3]),
                                          rpy=numbers([roll, pitch, yaw]))


def _turn(angle: float, axis: str) -> Array:
    """Return the rotation about an axis, (4, 4)."""
    result = np.eye(4)
    i, j = {'x': (1, 2), 'y': (2, 0), 'z': (0, 1)}[axis]
    result[[i, j], [i, j]] = np.cos(angle)
    result[j, i] = np.sin(angle)
    result[i, j] = -result[j, i]
    return result
