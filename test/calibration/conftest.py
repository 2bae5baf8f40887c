"""Fixtures of the calibration tests: a robot with known parameters, and motions."""

from functools import lru_cache

from baxter_dynamics_ros.calibration.fit_data import Motion, residual
from baxter_dynamics_ros.calibration.term import Sample
from baxter_dynamics_ros.calibration.terms import dahl_lengths
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.effort import Presliding, SPRING_COEFFICIENTS
from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

PERIOD = 0.01  # [s]
FINE = 5  # steps of the true motion per period, for Dahl friction
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
VELOCITY_NOISE = 0.004  # sd [rad/s]
POSITION_NOISE = 4e-4  # sd [rad]
CENTER = np.array([0.0, -0.45, 0.0, 1.2, 0.0, 0.4, 0.0])  # [rad]

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


class Recording:
    """Joint states in memory."""

    def __init__(self, name, arm, states):
        self.name = name
        self.arm = arm
        self.states = states

    def __iter__(self):
        return iter(self.states)

    def changed(self, change):
        """Return it with position, velocity and effort passed through a function."""
        return Recording(self.name, self.arm, [
            (stamp, names, *change(*arrays), received)
            for stamp, names, *arrays, received in self.states])

    def part(self, *span):
        """Return a slice of it."""
        return Recording(self.name, self.arm, self.states[slice(*span)])


def _wander(seed, t):
    """Return q, qd, qdd (n, 7) of a motion that reverses all joints; t (n,) [s]."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.03, 0.5, (4, 7))  # [rad/s]
    amplitude = np.array([0.35, 0.42, 0.35, 0.35, 0.42, 0.35, 0.42]) * np.minimum(1.0, 1.5 / w)
    angle = w * t[:, None, None] + rng.uniform(0.0, 6.28, (4, 7))
    return (CENTER + (amplitude * np.sin(angle)).sum(1), (amplitude * w * np.cos(angle)).sum(1),
            -(amplitude * w ** 2 * np.sin(angle)).sum(1))


def _recording(truth, seed, duration=30.0, lag=0.014, motion=_wander, noise=1.0):
    """Return the joint states of a robot with these settings, with white noise."""
    rng = np.random.default_rng(seed)
    settings = PredictorSettings.from_parameters(truth)
    fine = PERIOD / FINE * np.arange(round(duration / PERIOD) * FINE)
    state = Presliding(settings.model.effort_model.dahl_length)
    presliding = np.array([state.update(q) for q in motion(seed, fine)[0]])[::FINE]
    t = fine[::FINE]
    q, qd, qdd = motion(seed, t)
    effort = settings.model.effort_model.effort(
        settings.model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd, presliding)
    effort = effort + noise * EFFORT_NOISE * rng.standard_normal(q.shape)
    velocity = motion(seed, t - lag)[1] + noise * VELOCITY_NOISE * rng.standard_normal(q.shape)
    position = q + noise * POSITION_NOISE * rng.standard_normal(q.shape)
    names = joint_names(settings.arm)
    stamps = 10 ** 18 + np.round(1e9 * t).astype(int)
    return Recording(f'motion {seed}', settings.arm, [
        (stamp, names, *arrays, stamp)
        for stamp, *arrays in zip(stamps.tolist(), position, velocity, effort)])


class KnownRobot:
    """Robot with known parameters, its recordings and their calibrations, each made once."""

    ALL = {
        'effort_model.coulomb': (0.8, 1.0, 0.4, 0.0, 0.15, 0.12, 0.04),
        'effort_model.viscous': (0.0, 0.4, 0.0, 0.0, 0.1, 0.0, 0.0),
        'effort_model.dahl': (0.5, 1.2, 0.0, 0.3, 0.0, 0.0, 0.02),
        'effort_model.bias': (0.6, -0.5, 0.4, 0.3, -0.1, 0.12, 0.05),
        'effort_model.added_inertia': (0.25, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0),
        'effort_model.stiffness': (-0.5, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0),
        'gravity': (0.15, -0.12, -9.8081),
    }
    FRICTION = {'effort_model.coulomb': ALL['effort_model.coulomb'],
                'effort_model.bias': ALL['effort_model.bias']}
    # RMS that the noise of effort, velocity and position leaves [N m], and a margin.
    LEAST = 1.15 * np.array([0.127, 0.101, 0.086, 0.051, 0.0083, 0.0157, 0.0101])
    CENTER = CENTER
    EFFORT_NOISE = EFFORT_NOISE
    recording = staticmethod(_recording)
    wander = staticmethod(_wander)

    @lru_cache  # there is one robot a session
    def recordings(self, kind):
        """Return recordings of a robot with all terms or with friction only."""
        truth, n = {'all': (self.ALL, 4), 'friction': (self.FRICTION, 2)}[kind]
        return [_recording(truth, seed) for seed in range(n)]

    @lru_cache
    def calibrated(self, kind):
        """Return their calibration."""
        from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # needs SciPy
        return calibrate(self.recordings(kind))

    @staticmethod
    def off(calibration, truth) -> dict:
        """Return the error of each parameter in standard deviations, by name."""
        return {(p.term, p.joint, p.component): (p.value - _true_value(p, truth)) / p.deviation
                for p in calibration.parameters}

    @staticmethod
    def kept(calibration) -> dict:
        """Return the joints where each term was kept."""
        result = {}
        for step in calibration.steps[1:]:
            result[step.term] = result.get(step.term, ()) + tuple(JOINTS[i] for i in step.joints)
        return result


@pytest.fixture(scope='session')
def in_memory():
    """Return the class of recordings in memory."""
    return Recording


@pytest.fixture(scope='session')
def robot():
    """Return the robot."""
    return KnownRobot()


@pytest.fixture(params=SETTINGS.values(), ids=SETTINGS.keys())
def settings(request):
    """Return each of the initial settings."""
    return PredictorSettings.from_parameters(request.param)


@pytest.fixture(scope='session')
def make_motion():
    """Return a function that makes a motion of n rows at 100 Hz."""
    return _make_motion


@pytest.fixture(scope='module')
def motion():
    """Return a motion that sweeps s1 beyond its spring's range."""
    return _make_motion(300, np.random.default_rng(3))


@pytest.fixture(scope='session')
def decoupled():
    """Return a function that removes the crosstalk of some settings from effort (n, 7)."""
    return _decoupled


@pytest.fixture(scope='session')
def columns():
    """Return a function that returns a term's columns for all joints, (n, 7, p)."""
    return _columns


def _true_value(parameter, truth):
    """Return the true value of a fitted quantity."""
    values = {**DEFAULTS, **truth}
    term, which = parameter.term, parameter.component
    if term == 'tilt':
        return values['gravity']['xyz'.index(which)]
    if term == 'spring':
        names = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')
        gain = values['effort_model.spring_coefficients'][2] / SPRING_COEFFICIENTS[2]
        return gain if which == 'gain' else values['effort_model.spring_coefficients'][
            names.index(which)]
    if term == 'crosstalk':
        return values['effort_model.crosstalk'][7 * parameter.joint + JOINTS.index(which[3:])]
    if term == 'inertial':
        mass = values['links.mass'][parameter.joint]
        return mass if which == 'mass' else mass * values['links.center_of_mass'][
            3 * parameter.joint + 'xyz'.index(which[-1])]
    if term == 'payload':
        return (values['payload.mass'] if which == 'mass' else
                values['payload.center_of_mass']['xyz'.index(which[-1])])
    return values[f'effort_model.{term}'][parameter.joint]


def _make_motion(n, rng):
    """Return n rows at 100 Hz: two sines per joint, and random efforts."""
    time = 0.01 * np.arange(n)
    amplitude = rng.uniform(0.2, 0.6, (2, 7))
    amplitude[:, 1] = 1.2, 0.5
    rate = rng.uniform(1.0, 6.0, (2, 7))  # [rad/s]
    angle = rate * time[:, None, None] + rng.uniform(0.0, 6.0, (2, 7))
    q, qd, qdd = (x.sum(1) for x in (amplitude * np.sin(angle), amplitude * rate * np.cos(angle),
                                     -amplitude * rate ** 2 * np.sin(angle)))
    return Motion('test', time, q, qd, qdd, rng.normal(0.0, 5.0, (n, 7)), q, qd,
                  np.ones((n, 7)))


def _columns(term, settings, motion):
    """Return a term's columns for all joints, (n, 7, p), zero where it does not act."""
    presliding = {length: motion.presliding(length)
                  for length in dahl_lengths(settings.model.effort_model)}
    present = _decoupled(motion.effort - residual(motion, settings), settings)
    sample = Sample(motion, presliding, settings.model.arm, present)
    result = np.zeros((len(motion), 7, len(term.prior)))
    for joint in np.flatnonzero(term.acts.any(1)):
        result[:, joint, term.acts[joint]] = term.columns(sample, joint)
    return result


def _decoupled(effort, settings):
    """Return effort (n, 7) without the crosstalk of some settings."""
    return np.linalg.solve(np.eye(7) + settings.model.effort_model.crosstalk, effort.T).T
