"""A robot with known parameters: its recordings, each made once, and their calibrations."""

from functools import cache, lru_cache

from baxter_dynamics_ros.calibration.fit_data import Motion, residual
from baxter_dynamics_ros.calibration.joint_terms import Sample
from baxter_dynamics_ros.calibration.terms import DAHL_LENGTHS
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.effort import Presliding, SPRING_COEFFICIENTS
from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
from perfect_robot import sum_of_sines

PERIOD = 0.01  # [s]
FINE = 5  # steps of the true motion per period, for Dahl friction
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
VELOCITY_NOISE = 0.004  # sd [rad/s]
POSITION_NOISE = 4e-4  # sd [rad]
CENTER = np.array([0.0, -0.45, 0.0, 1.2, 0.0, 0.4, 0.0])  # [rad]
# RMS that the noise of effort, velocity and position leaves [N m], and a margin.
LEAST = 1.15 * np.array([0.127, 0.101, 0.086, 0.051, 0.0083, 0.0157, 0.0101])

ALL = {
    'effort_model.coulomb': (0.8, 1.0, 0.4, 0.0, 0.15, 0.12, 0.04),
    'effort_model.viscous': (0.0, 0.4, 0.0, 0.0, 0.1, 0.0, 0.0),
    'effort_model.dahl': (0.5, 1.2, 0.0, 0.3, 0.0, 0.0, 0.02),
    'effort_model.bias': (0.6, -0.5, 0.4, 0.3, -0.1, 0.12, 0.05),
    'effort_model.added_inertia': (0.25, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0),
    'effort_model.stiffness': (-0.5, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0),
    'gravity': (0.15, -0.12, -9.8081)}
FRICTION = {name: ALL[name] for name in ('effort_model.coulomb', 'effort_model.bias')}


class Recording:
    """Joint states in memory."""

    topic = '/robot/joint_states'

    def __init__(self, name, arm, states):
        self.name, self.arm, self.states = name, arm, states

    def __iter__(self):
        return iter(self.states)

    def changed(self, change):
        """Return it with position, velocity and effort passed through a function."""
        return Recording(self.name, self.arm, [
            (stamp, names, *change(*arrays), received)
            for stamp, names, *arrays, received in self.states])

    def part(self, begin=None, end=None, name=None):
        """Return a part of it."""
        return Recording(name or self.name, self.arm, self.states[begin:end])

    def pushed(self, effort):
        """Return it with more effort (n, 7) [N m]."""
        return Recording(self.name, self.arm, [
            (*state[:4], state[4] + row, state[5]) for state, row in zip(self.states, effort)])


def wander(seed, t):
    """Return q, qd, qdd (n, 7) of a motion that reverses all joints; t (n,) [s]."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.03, 0.5, (4, 7))  # [rad/s]
    amplitude = np.array([0.35, 0.42, 0.35, 0.35, 0.42, 0.35, 0.42]) * np.minimum(1.0, 1.5 / w)
    return sum_of_sines(t, CENTER, amplitude, w, rng.uniform(0.0, 6.28, (4, 7)))


def record(truth=FRICTION, seed=0, duration=12.0, lag=0.014, motion=wander):
    """Return the joint states of a robot with these settings, with white noise."""
    rng = np.random.default_rng(seed)
    settings = PredictorSettings.from_parameters(truth)
    model = settings.model.effort_model
    fine = PERIOD / FINE * np.arange(round(duration / PERIOD) * FINE)
    t = fine[::FINE]
    q, qd, qdd = motion(seed, t)
    state = Presliding(model.presliding_length)
    presliding = np.array([state.update(row) for row in motion(seed, fine)[0]])[::FINE]
    effort = model.effort(settings.model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd, presliding)
    effort, velocity, position = (
        values + deviation * rng.standard_normal(q.shape) for values, deviation in (
            (effort, EFFORT_NOISE), (motion(seed, t - lag)[1], VELOCITY_NOISE),
            (q, POSITION_NOISE)))
    names = joint_names(settings.arm)
    stamps = 10 ** 18 + np.round(1e9 * t).astype(int)
    return Recording(f'motion {seed}', settings.arm, [
        (stamp, names, *arrays, stamp)
        for stamp, *arrays in zip(stamps.tolist(), position, velocity, effort)])


@cache
def recordings(kind):
    """Return recordings of a robot with all terms or with friction only; each was made once."""
    truth, n = {'all': (ALL, 3), 'friction': (FRICTION, 2)}[kind]
    return [record(truth, seed, 24.0) for seed in range(n)]


@cache
def calibrated(kind, only=(), n=None):
    """Return the calibration to the first n of these recordings."""
    from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # needs SciPy
    return calibrate(recordings(kind)[:n], only=only)


@lru_cache(maxsize=40)
def observe_once(observe, recording, acceleration):
    """Return the motion of a recording, passed through the estimator once."""
    return observe(recording, PredictorSettings(acceleration=acceleration))


def errors(calibration, truth):
    """Return the error of each parameter in standard deviations, by term, joint, component."""
    return {(p.term, p.joint, p.component): (p.value - _true_value(p, truth)) / p.deviation
            for p in calibration.parameters}


def kept(calibration):
    """Return the joints where each term was kept."""
    return {step.term: tuple(JOINTS[i] for i in step.joints) for step in calibration.steps[1:]}


def warnings(calibration):
    """Return the notices as lines of text."""
    return [str(notice) for notice in calibration.notices]


def make_motion(n, rng):
    """Return n rows at 100 Hz: two sines per joint, and random efforts."""
    time = 0.01 * np.arange(n)
    amplitude = rng.uniform(0.2, 0.6, (2, 7))
    amplitude[:, 1] = 1.2, 0.5  # beyond the range of the spring
    rate = rng.uniform(1.0, 6.0, (2, 7))  # [rad/s]
    q, qd, qdd = sum_of_sines(time, 0.0, amplitude, rate, rng.uniform(0.0, 6.0, (2, 7)))
    effort = rng.normal(0.0, 5.0, (n, 7))
    return Motion(time, q, qd, qdd, effort, np.zeros((n, 7)), q, qd, qd, effort,
                  np.full(n, 0.01), qdd, 'test')


def columns(term, settings, motion):
    """Return a term's columns for all joints, (n, 7, p), zero where it does not act."""
    presliding = {length: motion.presliding(length) for length in DAHL_LENGTHS}
    present = decoupled(motion.effort - residual(motion, settings), settings)
    sample = Sample(motion, presliding, settings.model.arm, present)
    result = np.zeros((len(motion), 7, len(term.prior)))
    for joint in np.flatnonzero(term.acts.any(1)):
        result[:, joint, term.acts[joint]] = term.columns(sample, joint)
    return result


def decoupled(effort, settings):
    """Return effort (n, 7) without the crosstalk of some settings."""
    return np.linalg.solve(np.eye(7) + settings.model.effort_model.crosstalk, effort.T).T


def updated(term, settings, deviation):
    """Return the settings with the deviations of a term."""
    return settings.replace(term.values(settings, deviation))


def _true_value(parameter, truth):
    """Return the true value of a fitted quantity."""
    values = {**DEFAULTS, **truth}
    term, which, joint = parameter.term, parameter.component, parameter.joint
    if term == 'tilt':
        return values['gravity']['xyz'.index(which)]
    if term == 'spring':  # a gain
        return values['effort_model.spring_coefficients'][2] / SPRING_COEFFICIENTS[2]
    if term == 'crosstalk':
        return values['effort_model.crosstalk'][7 * joint + JOINTS.index(which[3:])]
    if term == 'inertial':
        mass = values['links.mass'][joint]
        return mass if which == 'mass' else mass * values['links.center_of_mass'][
            3 * joint + 'xyz'.index(which[-1])]
    return values[f'effort_model.{term}'][joint]
