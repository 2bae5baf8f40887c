"""Fixtures of the calibration tests: initial settings and a motion."""

from importlib.util import find_spec

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from calibration.known_robot import make_motion, observe_once
import numpy as np
import pytest

collect_ignore_glob = [] if find_spec('scipy') else ['test_*.py']  # pip install ".[offline]"

# Initial settings: the defaults, and a calibration without zeros.
SETTINGS = {
    'defaults': {},
    'calibrated': {
        'arm': 'left', 'gravity': (0.25, -0.15, -9.80),
        'effort_model.coulomb': (0.8, 0.7, 0.3, 0.2, 0.1, 0.1, 0.05),
        'effort_model.coulomb_velocity': 0.1,
        'effort_model.viscous': (0.1,) * 7,
        'effort_model.dahl': (0.5, 1.2, 0.1, 0.1, 0.02, 0.02, 0.01),
        'effort_model.dahl_length': 0.03,
        'effort_model.bias': (0.5, -0.4, 0.3, -0.2, 0.1, -0.1, 0.05),
        'effort_model.stiffness': (0.1, 0.0, -0.2, 0.1, 0.0, 0.1, 0.0),
        'effort_model.added_inertia': (0.1, -0.1, 0.05, 0.0, 0.01, 0.0, 0.0),
        'payload.mass': 0.8, 'payload.center_of_mass': (0.02, -0.03, 0.09),
        'payload.inertia': (2e-3, 2e-3, 1e-3, 1e-4, 0.0, -1e-4)},
}


@pytest.fixture(params=SETTINGS.values(), ids=SETTINGS.keys())
def settings(request):
    """Return each of the initial settings."""
    return PredictorSettings.from_parameters(request.param)


@pytest.fixture(scope='module')
def motion():
    """Return a motion that sweeps s1 beyond its spring's range."""
    return make_motion(300, np.random.default_rng(3))


@pytest.fixture(scope='session', autouse=True)
def observe_recordings_once():
    """Pass each recording through the estimator once for all calibrations."""
    from baxter_dynamics_ros.calibration import calibrate_robot
    observe = calibrate_robot.observe

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibrate_robot, 'observe', lambda recording, settings: observe_once(
            observe, recording, settings.acceleration))
        yield
