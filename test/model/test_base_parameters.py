"""The base parameters are sufficient, independent and unique."""

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import base_parameters
from baxter_dynamics_ros.model.lagrange_euler import transform
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-12}


def test_regressor_times_base_parameters_is_the_torque(arm, random_states):
    q, qd, qdd = random_states(200)
    tau = arm.regressor(q, qd, qdd) @ arm.base_parameters
    np.testing.assert_allclose(tau, arm.inverse_dynamics(q, qd, qdd), **EXACT)


def test_regressor_has_full_rank_that_of_pinocchios(arm, random_states):
    # Pinocchio's regressor has 70 columns; its rank is the number of base parameters.
    pin = pytest.importorskip('pinocchio', reason='the reference engine: pip install pin')
    from baxter_dynamics_ros.newton_euler import build_model
    model = build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount)
    data = model.createData()
    states = random_states(60)
    theirs = np.concatenate([pin.computeJointTorqueRegressor(model, data, *state).copy()
                             for state in zip(*states)])
    ours = arm.regressor(*states).reshape(-1, len(arm.base_parameters))
    for regressor in (theirs, ours):
        rank = np.linalg.matrix_rank(regressor, tol=1e-8 * np.linalg.norm(regressor, 2))
        assert rank == len(arm.base_parameters)
    # ... and both span the same torques.
    solution = np.linalg.lstsq(theirs, ours, rcond=1e-12)[0]
    np.testing.assert_allclose(theirs @ solution, ours, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize('link', range(1, 7))
def test_mass_on_a_joint_axis_may_belong_to_either_link(link):
    # A point mass on the axis of joint link + 1, as part of one link or of the other.
    arm = BaxterArm()
    frames = [transform(arm.parameters, 0, k, np.zeros(7)) for k in range(8)]
    axis_point = frames[link] @ np.array([0.0, 0.0, 0.17, 1.0])  # frame {link}: z is that axis
    moved = []
    for owner in (link - 1, link):
        pseudo = arm.parameters.pseudo_inertia.copy()
        point = np.linalg.solve(frames[owner + 1], axis_point)
        pseudo[owner] += 0.8 * np.outer(point, point)
        moved.append(base_parameters.base_parameters(arm.parameters, pseudo))
    np.testing.assert_allclose(moved[0], moved[1], **EXACT)
    assert np.abs(moved[0] - arm.closed_form_parameters[:45]).max() > 1e-3 or link == 1
