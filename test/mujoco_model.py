"""The arm as a MuJoCo model, from the tables of the paper."""

from baxter_dynamics_ros.model import paper_tables
import mujoco
import numpy as np


def mjcf(arm):
    """Write the arm as MJCF: body i turns about its z axis, link i's frame is fixed to it."""
    rows = zip(paper_tables.TABLE_II, paper_tables.TABLE_III, paper_tables.TABLE_IV)
    frame = _frame(arm.mount[:3, :3], arm.mount[:3, 3])
    bodies, depth = '', 0
    for i, ((d, a, alpha, mass), inertia, center) in enumerate(rows):
        # Joint i turns about the z axis of frame i - 1; theta_2 = q_2 + pi/2.
        turn = np.pi / 2 if i == 1 else 0.0
        c, s = np.cos(turn), np.sin(turn)
        offset = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        bodies += (f'<body {frame}><body {_frame(offset, np.zeros(3))}>'
                   '<joint type="hinge" axis="0 0 1"/>')
        # The link's inertia hangs in a body of its own, which stands in the link's frame.
        c, s = np.cos(alpha), np.sin(alpha)
        frame = _frame(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), [a, 0.0, d])
        bodies += f'<body {frame}>{_inertial(mass, center, inertia)}</body>'
        depth += 2
    load = arm.payload
    bodies += f'<body name="hand" {frame}>'
    if load.mass:
        bodies += _inertial(load.mass, load.center_of_mass, load.inertia)
    bodies += '</body>'
    return f"""
        <mujoco>
          <compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"
                    inertiafromgeom="false" fusestatic="false"/>
          <option gravity="{_text(arm.gravity_vector)}">
            <flag contact="disable" constraint="disable"/>
          </option>
          <worldbody>{bodies}{'</body>' * depth}</worldbody>
        </mujoco>"""


def _inertial(mass, center, inertia):
    xx, yy, zz, xy, yz, xz = inertia
    return (f'<inertial mass="{mass!r}" pos="{_text(center)}" '
            f'fullinertia="{_text([xx, yy, zz, xy, xz, yz])}"/>')  # MuJoCo's order


def _frame(rotation, translation):
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return f'pos="{_text(translation)}" quat="{_text(quaternion)}"'


def _text(numbers):
    return ' '.join(repr(float(number)) for number in numbers)
