"""From a minute of the fake Baxter's motion to what was put into it: springs, friction, load."""

from functools import lru_cache

from baxter_dynamics_ros import Payload
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel, SPRING_COEFFICIENTS
from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')
pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # noqa: E402, I100
from baxter_dynamics_ros.calibration.fit import residual  # noqa: E402
from baxter_dynamics_ros.calibration.fit_data import observe  # noqa: E402
from baxter_dynamics_ros.simulation.exciting_trajectory import DURATION  # noqa: E402
from baxter_dynamics_ros.simulation.recorder import record  # noqa: E402
from baxter_dynamics_ros.simulation.robot import FakeBaxter  # noqa: E402

ARM = 'left'
TILT, TOWARDS = np.radians(1.2), 0.7  # of the base [rad]
PAYLOAD = Payload(1.0, (0.02, -0.03, 0.08))
TRUE_EFFORT = {
    'spring_coefficients': tuple(1.05 * np.array(SPRING_COEFFICIENTS) + [0.5, 0, 0, 0, 0]),
    'coulomb': (0.5, 0.4, 0.5, 0.3, 0.15, 0.12, 0.05),
    'dahl': (0.4, 1.2, 0.3, 0.3, 0.06, 0.06, 0.02),
    'dahl_length': 0.02,
    'bias': (0.6, -0.5, -0.4, 0.3, -0.1, 0.15, 0.05)}
TRUTH = {
    'arm': ARM, **{f'effort_model.{name}': value for name, value in TRUE_EFFORT.items()},
    'gravity': tuple(9.81 * np.array([np.sin(TILT) * np.cos(TOWARDS),
                                      np.sin(TILT) * np.sin(TOWARDS), -np.cos(TILT)])),
    'payload.mass': PAYLOAD.mass, 'payload.center_of_mass': PAYLOAD.center_of_mass}


class Recording:
    """What a fake Baxter publishes in a minute."""

    name, arm = 'exciting', ARM

    def __init__(self):
        robot = FakeBaxter(ARM, 'exciting', truth=EffortModel(**TRUE_EFFORT), payload=PAYLOAD,
                           gravity=TRUTH['gravity'], seed=2)
        self._states = list(record(robot, DURATION, 100.0, seed=3))

    def __iter__(self):
        return ((*state, state[0]) for state in self._states)


@lru_cache
def recorded():
    """Return the recording."""
    return Recording()


@lru_cache
def found():
    """Return what is found in it; the package's defaults are what is known before."""
    return calibrate([recorded()], payload=True)


def parameters(term):
    """Return what was fitted of a term, by joint or axis."""
    return {p.component.removeprefix('center ') or JOINTS[p.joint]: p
            for p in found().of_term(term)}


def test_the_payload_is_found_within_two_percent():
    assert found().values['payload.mass'] == pytest.approx(1.0, rel=0.02)
    np.testing.assert_allclose(found().values['payload.center_of_mass'], PAYLOAD.center_of_mass,
                               atol=0.01)
    fitted = parameters('payload')
    assert fitted['mass'].deviation < 0.03  # [kg]
    for axis, true in zip('xyz', PAYLOAD.center_of_mass):
        assert abs(fitted[axis].value - true) < 3 * fitted[axis].deviation < 0.03  # [m]


@pytest.mark.parametrize('term', ['bias', 'coulomb', 'viscous', 'dahl', 'added_inertia',
                                  'stiffness'])
def test_each_joints_truth_is_within_three_times_the_uncertainty(term):
    true = dict(zip(JOINTS, TRUE_EFFORT.get(term, np.zeros(7))))
    if term == 'bias':  # a spring's constant cannot be told from it
        true['s1'] += TRUE_EFFORT['spring_coefficients'][0] - SPRING_COEFFICIENTS[0]
    for joint, p in parameters(term).items():
        assert abs(p.value - true[joint]) < 3 * p.deviation, (p, p.value, p.deviation)
        assert p.deviation < (0.8 if joint == 's1' else 0.3), p


def test_the_tilt_is_found():
    fitted = parameters('tilt')
    for axis, true in zip('xy', TRUTH['gravity']):
        assert abs(fitted[axis].value - true) < 3 * fitted[axis].deviation < 0.06  # [m/s^2]
    assert np.linalg.norm(found().values['gravity']) == pytest.approx(9.81)


def test_friction_is_found_on_all_joints():
    assert set(parameters('coulomb')) == set(JOINTS)
    assert set(parameters('dahl')) >= {'s0', 's1', 'w0'}
    assert not [line for line in found().warnings if 'does not show' in line and (
        'coulomb' in line or 'dahl' in line or 'viscous' in line)]
    total = np.add(found().values['effort_model.coulomb'], found().values['effort_model.dahl'])
    np.testing.assert_allclose(total, np.add(TRUE_EFFORT['coulomb'], TRUE_EFFORT['dahl']),
                               rtol=0.2)


def test_the_spring_is_found_over_what_s1_sweeps():
    """Its five numbers trade with each other, and with the bias: the curve is what counts."""
    low, high = found().s1_range
    assert high - low > 2.0
    q = np.zeros((50, 7))
    q[:, 1] = np.linspace(low, high, 50)
    curves = [settings.effort_model.spring(q)[:, 1] + settings.effort_model.bias[1]
              for settings in map(PredictorSettings, (TRUTH, found().values, found().before))]
    assert np.abs(curves[1] - curves[0]).max() < 0.3  # [N m]
    assert np.abs(curves[2] - curves[0]).max() > 1.0  # there was something to find


def test_it_predicts_as_well_as_the_truth_does():
    motion = observe(recorded(), found().values)
    fitted, true = (np.sqrt(np.mean(residual(motion, values) ** 2, axis=0))
                    for values in (found().values, TRUTH))
    print('fitted', fitted.round(3), 'true', true.round(3))
    assert (fitted < 1.05 * true + 0.002).all()
    assert (found().rms_after < 1.15 * true + 0.005).all()
    assert (found().rms_before > 3.0 * found().rms_after).all()


def test_the_sensors_lag_is_found():
    assert found().lag.value == pytest.approx(0.0135, abs=0.0005)
