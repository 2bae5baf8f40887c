"""Export as URDF: the manufacturer's description with the parameters of one arm."""

from pathlib import Path
import xml.etree.ElementTree as ET

import numpy as np

from .common import head
from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.joints import joint_names, N_JOINTS
from ..model.lagrange_euler import transform
from ..model.parameters import from_pseudo_inertia
from ..simulation.description import DescriptionError, find_description

_ELEMENTS = {'ixx': (0, 0), 'ixy': (0, 1), 'ixz': (0, 2), 'iyy': (1, 1), 'iyz': (1, 2),
             'izz': (2, 2)}


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
    path = description or find_description()
    try:
        root = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise DescriptionError(f'{path}: cannot be read as URDF ({error})') from None
    joints = []
    for name in joint_names(side):
        joint = root.find(f"joint[@name='{name}']")
        if joint is None:
            raise DescriptionError(f"no joint {name} in the description; is it a Baxter's?")
        joints.append(joint)
    _remove_gripper(root, joints[0])
    described = [_parent_pose(root, joint) @ _origin(joint) for joint in joints]
    before = _parent_pose(root, joints[0])
    for k, joint in enumerate(joints):
        frame, mass, center, inertia = _link(arm, k, described[k])
        _set_origin(joint, np.linalg.inv(before) @ frame)
        before = frame
        _child(joint, 'dynamics').attrib.update(damping=_text(effort.viscous[[k]]),
                                                friction=_text(effort.coulomb[[k]]))
        _add_inertia(_moved(root, joint), mass, center, inertia)
    root.insert(0, ET.Comment(' ' + '\n     '.join(head(arm, command)).replace('--', '- -') + ' '))
    ET.indent(root)
    return {f'baxter_{side}.urdf': '<?xml version="1.0"?>\n' + ET.tostring(
        root, encoding='unicode') + '\n'}


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


def _add_inertia(link: ET.Element, mass: Array, center: Array, inertia: Array) -> None:
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=_text(center), rpy='0 0 0')
    ET.SubElement(inertial, 'mass', value=repr(float(mass)))
    ET.SubElement(inertial, 'inertia', {name: repr(float(inertia[place]))
                                        for name, place in _ELEMENTS.items()})


def _remove_gripper(root: ET.Element, joint: ET.Element) -> None:
    """Remove the links of a gripper beyond a joint, and the inertias of all links there."""
    link = _moved(root, joint)
    name = link.get('name', '')
    for beyond in root.findall(f"joint/parent[@link='{name}']/.."):
        _remove_gripper(root, beyond)
    for inertial in link.findall('inertial'):
        link.remove(inertial)
    if 'gripper' in name:
        for element in (link, joint, *(other for other in root.findall('gazebo')
                                       if other.get('reference') in (name, joint.get('name')))):
            root.remove(element)


def _moved(root: ET.Element, joint: ET.Element) -> ET.Element:
    """Return the link that a joint moves."""
    return next(link for link in root.findall('link')
                if link.get('name') == _child(joint, 'child').get('link'))


def _child(element: ET.Element, tag: str) -> ET.Element:
    found = element.find(tag)
    return ET.SubElement(element, tag) if found is None else found


def _parent_pose(root: ET.Element, joint: ET.Element) -> Array:
    """Return the pose (4, 4) of the link that carries a joint, all joints at zero."""
    parent = _child(joint, 'parent').get('link')
    above = root.find(f"joint/child[@link='{parent}']/..")
    return np.eye(4) if above is None else _parent_pose(root, above) @ _origin(above)


def _origin(joint: ET.Element) -> Array:
    origin = _child(joint, 'origin')
    roll, pitch, yaw = map(float, origin.get('rpy', '0 0 0').split())
    result = _turn(yaw, 'z') @ _turn(pitch, 'y') @ _turn(roll, 'x')
    result[:3, 3] = list(map(float, origin.get('xyz', '0 0 0').split()))
    return result


def _set_origin(joint: ET.Element, pose: Array) -> None:
    r = pose[:3, :3]
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    if abs(r[2, 0]) > 1 - 1e-9:  # roll and yaw turn about the same axis
        roll, yaw = np.arctan2(-r[1, 2], r[1, 1]), 0.0
    else:
        roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    _child(joint, 'origin').attrib.update(xyz=_text(pose[:3, 3]),
                                          rpy=_text(np.array([roll, pitch, yaw])))


def _turn(angle: float, axis: str) -> Array:
    """Return the rotation about an axis, (4, 4)."""
    result = np.eye(4)
    i, j = {'x': (1, 2), 'y': (2, 0), 'z': (0, 1)}[axis]
    result[[i, j], [i, j]] = np.cos(angle)
    result[j, i] = np.sin(angle)
    result[i, j] = -result[j, i]
    return result


def _text(vector: Array) -> str:
    return ' '.join(repr(float(x)) for x in vector)
