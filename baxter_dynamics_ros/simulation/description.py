"""The manufacturer's robot description: a Baxter's URDF, and one arm of it."""

from pathlib import Path
import sys
import xml.etree.ElementTree as ET

import numpy as np

from ..model import Array, ArrayLike, BaxterDynamicsError, joint_names, Payload

_IN_WHEEL = Path('cmeel.prefix', 'share', 'hpp-baxter', 'urdf', 'baxter.urdf')
_ELEMENTS = {'ixx': (0, 0), 'ixy': (0, 1), 'ixz': (0, 2), 'iyy': (1, 1), 'iyz': (1, 2),
             'izz': (2, 2)}


class DescriptionError(BaxterDynamicsError):
    """The robot description is missing or is not a Baxter's."""


class Description:
    """
    A robot's URDF without one arm's gripper: all that moves beyond the hand, or is named gripper.

    By default the file is that of PyPI's ``hpp-baxter``. Raises DescriptionError if it cannot be
    read, lacks one of the arm's joints, or has joints that form a loop.
    """

    def __init__(self, side: str, path: str | Path | None = None) -> None:
        self.path = path = path or find_description()
        try:
            self.root = ET.parse(path).getroot()
        except (OSError, ET.ParseError, LookupError, ValueError) as error:
            raise DescriptionError(f'{path}: cannot be read as URDF ({error})') from None
        joints = {joint.get('name'): joint for joint in self.root.findall('joint')}
        links = {link.get('name'): link for link in self.root.findall('link')}
        for name in joint_names(side):
            if name not in joints or joints[name].get('type') != 'revolute':
                raise DescriptionError(f"{path}: no revolute joint {name}; is it a Baxter's URDF?")
        # The links at the ends of each joint.
        self.parent: dict[ET.Element, ET.Element] = {}
        self.child: dict[ET.Element, ET.Element] = {}
        for joint in joints.values():
            for end, found in (('parent', self.parent), ('child', self.child)):
                link = links.get(getattr(joint.find(end), 'attrib', {}).get('link'))
                if link is None:
                    raise DescriptionError(f'{path}: joint {joint.get("name")} has no {end} link')
                found[joint] = link
        self.joints = [joints[name] for name in joint_names(side)]
        self.carried = [joint for joint in joints.values()  # s0 and all joints beyond it
                        if self.joints[0] in [*self.above(joint), joint]]
        self._remove_gripper()

    def above(self, joint: ET.Element) -> list[ET.Element]:
        """Return the joints from the root to a joint, without the joint itself."""
        chain = [joint]
        while before := [other for other, link in self.child.items()
                         if link is self.parent[chain[0]]]:
            if len(before) > 1 or before[0] in chain:
                raise DescriptionError(f'{self.path}: the joints form a loop at the link '
                                       f'{self.child[before[0]].get("name")}')
            chain = before + chain
        return chain[:-1]

    def _remove_gripper(self) -> None:
        first = {joint for joint in set(self.carried).difference(self.joints)
                 if joint.get('type') != 'fixed' or 'gripper' in self.child[joint].get('name', '')}
        joints = [joint for joint in self.carried if first & {*self.above(joint), joint}]
        gripper = {*joints, *(self.child[joint] for joint in joints)}
        names = {element.get('name') for element in gripper}
        self.carried = [joint for joint in self.carried if joint not in gripper]
        self.root[:] = [element for element in self.root if element not in gripper
                        and element.get('reference', '') not in names  # <gazebo>
                        and not names & {each.get('name') for each in element.findall('joint')}]


def find_description() -> Path:
    """Return the path of the manufacturer's URDF, as PyPI's ``hpp-baxter`` installs it."""
    for folder in sys.path:
        path = Path(folder) / _IN_WHEEL
        if path.is_file():
            return path
    raise DescriptionError("the manufacturer's robot description is not installed: "
                           'pip install hpp-baxter, or name the path of a baxter.urdf')


def arm_description(side: str, path: str | Path | None = None,
                    payload: Payload | None = None) -> str:
    """
    Return the URDF of one arm: the chain from the base to the hand, bodies only.

    Geometry, the other arm, the head and the gripper are removed. The rest is the arm that the
    paper's tables describe, with independent numbers. A payload becomes a link fixed to the hand.
    Raises DescriptionError as :class:`Description` does, or if there is no hand.
    """
    robot = Description(side, path)
    joints = [*robot.above(robot.joints[0]), *robot.carried]
    links = [robot.parent[joints[0]], *(robot.child[joint] for joint in joints)]
    hand = next((link for link in links if link.get('name') in hand_names(side)), None)
    if hand is None:
        raise DescriptionError(f'{robot.path}: no link {hand_names(side)[0]}')
    robot.root[:] = [element for element in robot.root if element in {*joints, *links}]
    for link in links:
        for shape in link.findall('visual') + link.findall('collision'):
            link.remove(shape)
    if payload is not None and payload.mass > 0.0:
        load = ET.SubElement(robot.root, 'link', name='payload')
        add_inertia(load, payload.mass, payload.center_of_mass, payload.inertia_tensor)
        joint = ET.SubElement(robot.root, 'joint', name='payload', type='fixed')
        ET.SubElement(joint, 'parent', link=hand.get('name', ''))
        ET.SubElement(joint, 'child', link='payload')
    return ET.tostring(robot.root, encoding='unicode')


def hand_names(side: str) -> tuple[str, str]:
    """Return the names that descriptions use for the hand link."""
    return f'{side}_hand', f'{side}_hand_link'


def add_inertia(link: ET.Element, mass: ArrayLike, center: ArrayLike, inertia: Array) -> None:
    """Add mass, centre of mass (3,) and inertia about it (3, 3) to a link."""
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=numbers(center), rpy='0 0 0')
    ET.SubElement(inertial, 'mass', value=numbers(mass))
    ET.SubElement(inertial, 'inertia', {name: numbers(inertia[place])
                                        for name, place in _ELEMENTS.items()})


def numbers(values: ArrayLike) -> str:
    """Return numbers as the text of an attribute."""
    return ' '.join(repr(float(value)) for value in np.ravel(values))
