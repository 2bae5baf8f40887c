"""Calibration on a minute of the fake Baxter: springs, friction, tilt and payload are found."""

from baxter_dynamics_ros import Payload
from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.calibration.fit_data import observe, residual
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import EffortModel, JOINTS, rms
from baxter_dynamics_ros.model.effort import SPRING_COEFFICIENTS
from calibration.known_robot import Recording
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.exciting_trajectory import DURATION  # noqa: E402, I100
from baxter_dynamics_ros.simulation.robot import FakeBaxter, record  # noqa: E402

ARM = 'left'
TILT, TOWARDS = np.radians(1.2), 0.7  # of the base [rad]
PAYLOAD = Payload(1.0, (0.02, -0.03, 0.08))
EFFORT = {
    'spring_coefficients': tuple(1.05 * np.array(SPRING_COEFFICIENTS) + [0.5, 0, 0, 0, 0]),
    'coulomb': (0.5, 0.4, 0.5, 0.3, 0.15, 0.12, 0.05),
    'dahl': (0.4, 1.2, 0.3, 0.3, 0.06, 0.06, 0.02),
    'dahl_length': 0.02,
    'bias': (0.6, -0.5, -0.4, 0.3, -0.1, 0.15, 0.05)}
TRUTH = PredictorSettings.from_parameters({
    'arm': ARM, **{f'effort_model.{name}': value for name, value in EFFORT.items()},
    'gravity': tuple(9.81 * np.array([np.sin(TILT) * np.cos(TOWARDS),
                                      np.sin(TILT) * np.sin(TOWARDS), -np.cos(TILT)])),
    'payload.mass': PAYLOAD.mass, 'payload.center_of_mass': PAYLOAD.center_of_mass})


@pytest.fixture(scope='module')
def recorded():
    """Return the recording of a fake Baxter's exciting motion."""
    robot = FakeBaxter(ARM, 'exciting', truth=EffortModel(**EFFORT), payload=PAYLOAD,
                       gravity=TRUTH.gravity, seed=2)
    return Recording('exciting', ARM, [
        (*state, state[0]) for state in record(robot, DURATION, 100.0, seed=3)])


@pytest.fixture(scope='module')
def found(recorded):
    """Return the calibration that starts from the package's defaults."""
    return calibrate([recorded], payload=True)


def test_payload_and_tilt_are_found(found):
    assert found.after.payload.mass == pytest.approx(1.0, rel=0.02)
    assert np.linalg.norm(found.after.gravity) == pytest.approx(9.81)
    true = [1.0, *PAYLOAD.center_of_mass, *TRUTH.gravity[:2]]  # [kg], [m], [m/s^2]
    fitted = found.of_term('payload') + found.of_term('tilt')
    for one, truth, limit in zip(fitted, true, [0.09] + 3 * [0.03] + 2 * [0.06], strict=True):
        assert abs(one.value - truth) < 3 * one.deviation < limit, one


def test_parameters_of_joints_are_found_within_three_deviations(found):
    for term in ('bias', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness'):
        true = np.array(EFFORT.get(term, np.zeros(7)))
        if term == 'bias':  # includes the constant of the spring
            true[1] += EFFORT['spring_coefficients'][0] - SPRING_COEFFICIENTS[0]
        for one in found.of_term(term):
            assert abs(one.value - true[one.joint]) < 3 * one.deviation, one
            assert one.deviation < (0.8 if one.joint == 1 else 0.3), one
    assert {one.joint for one in found.of_term('coulomb')} == set(range(7))
    assert {JOINTS[one.joint] for one in found.of_term('dahl')} >= {'s0', 's1', 'w0'}
    total = np.add(found.after.effort_model.coulomb, found.after.effort_model.dahl)
    np.testing.assert_allclose(total, np.add(EFFORT['coulomb'], EFFORT['dahl']), rtol=0.2)


def test_spring_curve_is_found_over_the_range_of_s1(found):
    """The coefficients are not determined individually, nor is the bias; the curve is."""
    low, high = found.s1_range
    assert high - low > 2.0
    q = np.linspace(low, high, 50)[:, None] * np.eye(7)[1]
    true, fitted, default = (
        settings.model.effort_model.spring(q)[:, 1] + settings.model.effort_model.bias[1]
        for settings in (TRUTH, found.after, found.before))
    assert np.abs(fitted - true).max() < 0.3  # [N m]
    assert np.abs(default - true).max() > 1.0


def test_prediction_is_as_good_as_with_the_truth(found, recorded):
    motion = observe(recorded, found.after)
    fitted, true = (rms(residual(motion, settings)) for settings in (found.after, TRUTH))
    assert (fitted < 1.05 * true + 0.002).all()
    assert (found.total.after < 1.15 * true + 0.005).all()
    assert (found.total.before > 3.0 * found.total.after).all()
    assert found.lag.value == pytest.approx(0.0135, abs=0.0005)
