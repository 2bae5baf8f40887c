"""Export as URDF: the manufacturer's description with the parameters of one arm."""

from collections.abc import Iterator
from pathlib import Path
import xml.etree.ElementTree as ET

import numpy as np

from .legend import head
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
    left out: a payload stands for it. The other arm and the head stay as they are.

    Parameters
    ----------
    arm : BaxterArm
        With the mount of its side.
    command : str
        Command that exports.
    side : str
        'right' or 'left'.
    effort : EffortModel
        Friction of the joints.
    description : Path, optional
        The robot's URDF; :func:`.find_description` by default.

    Raises
    ------
    DescriptionError
        If there is no description, or it is not a Baxter's.

    """
    path = description or find_description()
    try:
        root = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise DescriptionError(f'{path}: cannot be read as URDF ({error})') from None
    tree = _Tree(root, joint_names(side))
    tree.remove_gripper()
    before = tree.pose(tree.above[_child(tree.arm[0], 'parent').get('link')])
    for k, (joint, (frame, center, inertia, mass)) in enumerate(zip(
            tree.arm, _links(arm, [tree.pose(joint) for joint in tree.arm]))):
        _set_pose(joint, np.linalg.inv(before) @ frame)
        before = frame
        _child(joint, 'dynamics').attrib.update(damping=repr(float(effort.viscous[k])),
                                                friction=repr(float(effort.coulomb[k])))
        tree.set_inertia(joint, mass, center, inertia)
    root.insert(0, ET.Comment(' ' + '\n     '.join(head(arm, command)).replace('--', '- -') + ' '))
    ET.indent(root)
    return {f'baxter_{side}.urdf': '<?xml version="1.0"?>\n' + ET.tostring(
        root, encoding='unicode') + '\n'}


class _Tree:
    """Joints and links of a description, and those of one arm."""

    def __init__(self, root: ET.Element, names: tuple[str, ...]) -> None:
        self.root = root
        self.links = {link.get('name'): link for link in root.findall('link')}
        self.above = {_child(joint, 'child').get('link'): joint for joint in root.findall('joint')}
        by_name = {joint.get('name'): joint for joint in self.above.values()}
        missing = [name for name in names if name not in by_name]
        if missing:
            raise DescriptionError(f"no joint {missing[0]} in the description; is it a Baxter's?")
        self.arm = [by_name[name] for name in names]

    def pose(self, joint: ET.Element) -> Array:
        """Return the pose of a joint in the root frame where all joints are at zero, (4, 4)."""
        parent = self.above.get(_child(joint, 'parent').get('link'))
        own = _pose(joint)
        return own if parent is None else self.pose(parent) @ own

    def remove_gripper(self) -> None:
        """Remove the links of the gripper and the inertias of all that is fixed to the arm."""
        for name in list(self._beyond(_child(self.arm[0], 'child').get('link'))):
            link, joint = self.links[name], self.above[name]
            if 'gripper' in str(name):
                self.root.remove(link)
                self.root.remove(joint)
                for other in self.root.findall('gazebo'):
                    if other.get('reference') in (name, joint.get('name')):
                        self.root.remove(other)
            for inertial in link.findall('inertial'):
                link.remove(inertial)

    def set_inertia(self, joint: ET.Element, mass: float, center: Array, inertia: Array) -> None:
        """Set the inertia of the link that a joint moves."""
        inertial = ET.SubElement(self.links[_child(joint, 'child').get('link')], 'inertial')
        ET.SubElement(inertial, 'origin', xyz=_text(center), rpy='0 0 0')
        ET.SubElement(inertial, 'mass', value=repr(float(mass)))
        ET.SubElement(inertial, 'inertia', {name: repr(float(inertia[place]))
                                            for name, place in _ELEMENTS.items()})

    def _beyond(self, name: str | None) -> Iterator[str | None]:
        """Yield a link and all beyond it."""
        yield name
        for child, joint in self.above.items():
            if _child(joint, 'parent').get('link') == name:
                yield from self._beyond(child)


def _links(arm: BaxterArm, described: list[Array]) -> Iterator[tuple[Array, Array, Array, float]]:
    """Yield of each link: frame in the base, centre and inertia about it in that frame, mass."""
    p = arm.parameters
    pseudo = p.pseudo_inertia.copy()
    pseudo[-1] += arm.payload.pseudo_inertia
    for k in range(N_JOINTS):
        before, frame = (arm.mount @ transform(p, 0, i, np.zeros(N_JOINTS)) for i in (k, k + 1))
        joint = before @ _turn(p.theta_offset[k], 'z')
        # The description turns its frames about the joint's axis by multiples of 90 degrees and
        # shifts them along it.
        offset = np.linalg.inv(joint) @ described[k]
        quarters = round(np.arctan2(offset[1, 0], offset[0, 0]) / (np.pi / 2))
        own = joint @ _turn(np.pi / 2 * quarters, 'z')
        own[:3, 3] += offset[2, 3] * own[:3, 2]
        if np.abs(own - described[k]).max() > 0.02:
            raise DescriptionError(f'link {k + 1} of the description lies elsewhere than Table II '
                                   "and the mount say; is it a Baxter's arm?")
        to_own = np.linalg.inv(own) @ frame
        mass, center, inertia = from_pseudo_inertia(to_own @ pseudo[k] @ to_own.T)
        yield own, center, inertia, float(mass)


def _child(element: ET.Element, tag: str) -> ET.Element:
    found = element.find(tag)
    return ET.SubElement(element, tag) if found is None else found


def _pose(joint: ET.Element) -> Array:
    origin = _child(joint, 'origin')
    roll, pitch, yaw = map(float, origin.get('rpy', '0 0 0').split())
    result = _turn(yaw, 'z') @ _turn(pitch, 'y') @ _turn(roll, 'x')
    result[:3, 3] = list(map(float, origin.get('xyz', '0 0 0').split()))
    return result


def _set_pose(joint: ET.Element, pose: Array) -> None:
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
