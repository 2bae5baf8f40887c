"""The model against MuJoCo, which shares neither code nor formulation with Pinocchio."""

from baxter_dynamics_ros.model import paper_tables
import numpy as np
import pytest

mujoco = pytest.importorskip('mujoco', reason='the physics engine is not installed: '
                             'pip install mujoco')

# Its compiler turns inertias to principal axes, by an iteration. Measured: 4e-13.
CLOSE = {'rtol': 0.0, 'atol': 1e-9}


@pytest.fixture
def states(random_states):
    return random_states(1000)


@pytest.fixture
def physics(arm):
    model = mujoco.MjModel.from_xml_string(_mjcf(arm))
    return model, mujoco.MjData(model)


def test_inverse_dynamics(arm, physics, states):
    model, data = physics
    expected = []
    for data.qpos, data.qvel, data.qacc in zip(*states):
        mujoco.mj_inverse(model, data)
        expected.append(data.qfrc_inverse.copy())
    np.testing.assert_allclose(arm.inverse_dynamics(*states), expected, **CLOSE)


def test_mass_matrix(arm, physics, states):
    model, data = physics
    q, _, _ = states
    expected = np.empty((len(q), 7, 7))
    for full, data.qpos in zip(expected, q):
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
    np.testing.assert_allclose(arm.mass_matrix(q), expected, **CLOSE)


def test_bias(arm, physics, states):
    model, data = physics
    q, qd, _ = states
    expected = []
    for data.qpos, data.qvel in zip(q, qd):
        mujoco.mj_forward(model, data)
        expected.append(data.qfrc_bias.copy())
    _, coriolis, gravity = arm.terms(q, qd)
    bias = np.einsum('nik,nk->ni', coriolis, qd) + gravity
    np.testing.assert_allclose(bias, expected, **CLOSE)


def test_forward_dynamics(physics, arm, states):
    model, data = physics
    q, qd, tau = states  # qdd's numbers, as torques
    expected = []
    for data.qpos, data.qvel, data.qfrc_applied in zip(q, qd, tau):
        mujoco.mj_forward(model, data)
        expected.append(data.qacc.copy())
    np.testing.assert_allclose(arm.forward_dynamics(q, qd, tau), expected, rtol=0.0, atol=1e-6)


def test_hand_position(arm, physics, states):
    model, data = physics
    q, _, _ = states
    expected = []
    for data.qpos in q:
        mujoco.mj_kinematics(model, data)
        expected.append(data.body('hand').xpos.copy())
    np.testing.assert_allclose(arm.forward_kinematics(q)[:, :3, 3], expected, **CLOSE)


def _mjcf(arm):
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
