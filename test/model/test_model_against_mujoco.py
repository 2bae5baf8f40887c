"""The model against MuJoCo, which shares neither code nor formulation with Pinocchio."""

import numpy as np
import pytest

mujoco = pytest.importorskip('mujoco', reason='the physics engine is not installed: '
                             'pip install mujoco')
from mujoco_model import mjcf  # noqa: E402, I100

# Its compiler turns inertias to principal axes, by an iteration. Measured: 4e-13.
CLOSE = {'rtol': 0.0, 'atol': 1e-9}


@pytest.fixture
def states(random_states):
    return random_states(1000)


@pytest.fixture
def physics(arm):
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    return model, mujoco.MjData(model)


def test_inverse_dynamics(arm, physics, states):
    model, data = physics
    expected = []
    for data.qpos, data.qvel, data.qacc in zip(*states):
        mujoco.mj_inverse(model, data)
        expected.append(data.qfrc_inverse.copy())
    np.testing.assert_allclose(arm.inverse_dynamics(*states), expected, **CLOSE)


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
