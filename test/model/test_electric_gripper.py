"""The gripper's parameter file against the manufacturer's description."""

from pathlib import Path

from baxter_dynamics_ros import BaxterArm, joint_names, mount
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import SIDES
from baxter_dynamics_ros.simulation.description import (arm_description, DescriptionError,
                                                        find_description)
import numpy as np
import pytest

pytest.importorskip('yaml', reason='parameter files need PyYAML: pip install pyyaml')
from baxter_dynamics_ros.recordings.parameter_file import read_parameters  # noqa: E402, I100

FILE = Path(__file__).parents[2] / 'config' / 'electric_gripper.yaml'


@pytest.mark.parametrize('side', SIDES)
def test_gravity_torques(pin, side, random_states):
    try:
        models = [pin.buildModelFromUrdf(str(find_description())),
                  pin.buildModelFromXML(arm_description(side))]
    except DescriptionError as error:
        pytest.skip(str(error))
    payload = PredictorSettings.from_parameters(read_parameters(FILE)).model.arm.payload
    arms = [BaxterArm(payload, mount=mount(side)), BaxterArm(mount=mount(side))]
    for q in random_states(20)[0]:
        torques = []
        for model in models:
            joints = [model.joints[model.getJointId(name)] for name in joint_names(side)]
            position = pin.neutral(model)
            position[[joint.idx_q for joint in joints]] = q
            torque = pin.computeGeneralizedGravity(model, model.createData(), position)
            torques.append(torque[[joint.idx_v for joint in joints]])
        np.testing.assert_allclose(arms[0].gravity(q) - arms[1].gravity(q),
                                   torques[0] - torques[1], rtol=0.0, atol=2e-3)
