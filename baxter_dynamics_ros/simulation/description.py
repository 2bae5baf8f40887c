"""The manufacturer's robot description, reduced to one arm."""

from pathlib import Path
import sys
import xml.etree.ElementTree as ET

from ..model.exceptions import BaxterDynamicsError
from ..model.joints import joint_names
from ..model.parameters import Payload

_IN_WHEEL = Path('cmeel.prefix', 'share', 'hpp-baxter', 'urdf', 'baxter.urdf')


class DescriptionError(BaxterDynamicsError):
    """The robot description is missing or is not a Baxter's."""


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
    The path is that of the robot's URDF; :func:`find_description` by default. Raises
    DescriptionError if the file cannot be read or lacks one of the arm's joints or its hand.
    """
    path = Path(path) if path else find_description()
    try:
        robot = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise DescriptionError(f'{path}: cannot be read as URDF ({error})') from None
    joints = {joint.get('name', ''): joint for joint in robot.findall('joint')}
    for name in joint_names(side):
        if name not in joints:
            raise DescriptionError(f"{path}: no joint {name}; is it a Baxter's URDF?")
    keep = _links_of_arm(joints, joint_names(side))
    hand = next((name for name in hand_names(side) if name in keep), None)
    if hand is None:
        raise DescriptionError(f'{path}: no link {hand_names(side)[0]}')
    for element in list(robot):
        link = _link(element, 'child') if element.tag == 'joint' else element.get('name')
        if element.tag not in ('joint', 'link') or link not in keep:
            robot.remove(element)
        for shape in element.findall('visual') + element.findall('collision'):
            element.remove(shape)
    if payload is not None and payload.mass > 0.0:
        robot.extend(_load(hand, payload))
    return ET.tostring(robot, encoding='unicode')


def hand_names(side: str) -> tuple[str, str]:
    """Return the names that descriptions use for the hand link."""
    return f'{side}_hand', f'{side}_hand_link'


def _load(hand: str, payload: Payload) -> ET.Element:
    """Return the link and the joint that fix a payload to the hand."""
    numbers = dict(zip(('ixx', 'iyy', 'izz', 'ixy', 'iyz', 'ixz'), map(repr, payload.inertia)))
    inertia = ' '.join(f'{name}="{value}"' for name, value in numbers.items())
    center = ' '.join(map(repr, payload.center_of_mass))
    return ET.fromstring(
        f'<robot><link name="payload"><inertial><origin xyz="{center}"/>'
        f'<mass value="{payload.mass!r}"/><inertia {inertia}/></inertial></link>'
        f'<joint name="payload" type="fixed"><parent link="{hand}"/><child link="payload"/>'
        '</joint></robot>')


def _links_of_arm(joints: dict[str, ET.Element], arm: tuple[str, ...]) -> set[str]:
    """Return the links from the root to the wrist, with links fixed to the arm but no gripper."""
    parents = {_link(joint, 'child'): joint for joint in joints.values()}

    def is_of_arm(link: str) -> bool:
        joint = parents.get(link)
        if joint is None or joint.get('name') in arm:
            return joint is not None
        return (joint.get('type') == 'fixed' and 'gripper' not in link
                and is_of_arm(_link(joint, 'parent')))

    links = set(filter(is_of_arm, parents))
    link = _link(joints[arm[0]], 'parent')
    while link in parents:
        links.add(link)
        link = _link(parents[link], 'parent')
    return links | {link}


def _link(joint: ET.Element, end: str) -> str:
    """Return the link at an end of a joint, 'parent' or 'child'."""
    element = joint.find(end)
    if element is None or not element.get('link'):
        raise DescriptionError(f'joint {joint.get("name")} of the description: no {end} link')
    return element.get('link', '')
