"""The exported URDF in Pinocchio and MuJoCo against BaxterArm."""

import xml.etree.ElementTree as ET

from baxter_dynamics_ros import joint_names
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.export import urdf
from baxter_dynamics_ros.simulation.description import DescriptionError, find_description
import numpy as np
import pytest

SETTINGS = {'payload.mass': 1.2, 'payload.center_of_mass': [0.03, -0.02, 0.11],
            'payload.inertia': [3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4],
            'gravity': [1.3, -2.1, -9.4], 'effort_model.coulomb': [0.5] * 7,
            'effort_model.viscous': [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]}


@pytest.fixture(params=['right', 'left'])
def described(request):
    """Return the settings of an arm, and its exported URDF."""
    try:
        find_description()
    except DescriptionError as error:
        pytest.skip(str(error))
    settings = PredictorSettings.from_parameters({'arm': request.param, **SETTINGS})
    ((name, text),) = urdf.files(
        settings.model.arm, 'baxter_dynamics export -o a---b', request.param,
        settings.model.effort_model).items()
    assert name == f'baxter_{request.param}.urdf'
    return settings, text


def test_pinocchio_on_the_urdf(described, pin, random_states):
    settings, text = described
    model = pin.buildModelFromXML(text)
    model.gravity.linear = settings.model.arm.gravity_vector
    data, names = model.createData(), joint_names(settings.arm)
    q_at, v_at = ([getattr(model.joints[model.getJointId(name)], index) for name in names]
                  for index in ('idx_q', 'idx_v'))
    for q, qd, qdd in zip(*random_states(50)):
        position, (velocity, acceleration) = pin.neutral(model), np.zeros((2, model.nv))
        position[q_at], velocity[v_at], acceleration[v_at] = q, qd, qdd
        tau = pin.rnea(model, data, position, velocity, acceleration)[v_at]
        np.testing.assert_allclose(tau, settings.model.arm.inverse_dynamics(q, qd, qdd), rtol=0.0,
                                   atol=1e-9)


def test_mujoco_on_the_urdf(described, random_states):
    mujoco = pytest.importorskip('mujoco', reason='needs MuJoCo: pip install mujoco')
    settings, text = described
    root = ET.fromstring(text)
    assert {joint.get('name') for joint in root.findall('joint')}.issuperset(
        joint.get('name') for joint in root.findall('transmission/joint'))
    for link in root.findall('link'):  # the meshes are not installed
        for shape in link.findall('visual') + link.findall('collision'):
            link.remove(shape)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding='unicode'))
    model.opt.gravity[:] = settings.model.arm.gravity_vector
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data, names = mujoco.MjData(model), joint_names(settings.arm)
    at = [model.joint(name).dofadr[0] for name in names]
    np.testing.assert_array_equal(model.dof_damping[at], settings.model.effort_model.viscous)
    np.testing.assert_array_equal(model.dof_frictionloss[at], settings.model.effort_model.coulomb)
    for q, qd, qdd in zip(*random_states(5)):
        data.qpos[:], data.qvel[:], data.qacc[:] = 0.0, 0.0, 0.0
        data.qpos[[model.joint(name).qposadr[0] for name in names]] = q
        data.qvel[at], data.qacc[at] = qd, qdd
        mujoco.mj_inverse(model, data)
        tau = settings.model.arm.inverse_dynamics(q, qd, qdd)
        tau = tau + settings.model.effort_model.viscous * qd
        np.testing.assert_allclose(data.qfrc_inverse[at], tau, rtol=0.0, atol=1e-9)


def test_other_descriptions_are_refused(tmp_path, described):
    settings, text = described
    path, joint = tmp_path / 'other.urdf', (
        '<joint name="x"><parent link="{}"/><child link="{}"/></joint></robot>')
    below = f'{settings.arm}_hand_link', f'{settings.arm}_upper_elbow'
    for changed, expected in (
            (text.replace('0.069', '0.269'), 'lies elsewhere'),
            (text.replace('</robot>', joint.format('torso', 'base')), 'a loop at the link base'),
            (text.replace('</robot>', joint.format(*below)), f'a loop at the link {below[1]}'),
            ('<?xml version="1.0" encoding="x"?><robot/>', 'unknown encoding')):
        path.write_text(changed)
        with pytest.raises(DescriptionError, match=expected):
            urdf.files(settings.model.arm, '', settings.arm, settings.model.effort_model, path)
