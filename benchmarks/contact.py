"""Measure contact detection: latency of pushes, false contacts, noise of the residuals."""

import argparse
from pathlib import Path
from typing import NamedTuple

from baxter_dynamics_ros.estimation.external import MomentumObserver
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import ExternalEffortSettings, PredictorSettings
from baxter_dynamics_ros.model.arm import BaxterArm
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names, JOINTS, mount, N_JOINTS
from baxter_dynamics_ros.simulation.plant import COULOMB
from baxter_dynamics_ros.simulation.robot import FakeBaxter, JOINT_STATE_NAMES
import numpy as np

TRAJECTORIES = ('hold', 'circle', 'switch', 'lift')
RATES = (50, 100, 400)  # of joint states [Hz]
FORCES = (10.0, 20.0, 40.0, 60.0, 100.0, 150.0, 200.0)  # at the hand [N]
QUIET = 180.0  # duration of a run without pushes [s]
LENGTH, SPACING = 0.8, 2.5  # of pushes [s]
ELBOW = {'fake': 2.0, 'recording': 4.0}  # at e1 [N m]
FRICTION = {'effort_model.coulomb': COULOMB}  # of the fake Baxter
_FILES = ('baxter_left_arm_tracking.npz', 'baxter_point_to_point.npz')
_NOTHING = np.full(N_JOINTS, np.nan)


class JointTrace(NamedTuple):
    """Joint states of a simulation or a recording; arrays (n, 7) in joint order."""

    name: str
    side: str
    period: float  # [s]
    q: np.ndarray  # [rad]
    qd: np.ndarray  # [rad/s]
    effort: np.ndarray  # [N m]

    @property
    def times(self) -> np.ndarray:
        """Time of each sample (n,) [s]."""
        return self.period * np.arange(1, len(self.q) + 1)

    def part(self, rows: slice) -> 'JointTrace':
        """Return the samples in ``rows``."""
        return JointTrace(self.name, self.side, (rows.step or 1) * self.period,
                          *(x[rows] for x in self[3:]))


class Push(NamedTuple):
    """A force at the hand, or a torque at the elbow, that starts and ends abruptly."""

    begin: float  # [s]
    force: np.ndarray  # (3,), axes of the base [N]
    torque: np.ndarray  # (7,) [N m]


def during(motion: JointTrace, push: Push) -> np.ndarray:
    """Return which samples lie within a push, (n,) bool."""
    return (motion.times >= push.begin) & (motion.times < push.begin + LENGTH)


class Result(NamedTuple):
    """Output of the predictor for each sample of a motion."""

    residual: np.ndarray  # (n, 7), NaN where there is none [N m]
    external: np.ndarray  # (n, 7), NaN where there is none [N m]
    contact: np.ndarray  # (n,) bool; False where contact is unknown


def pushes(count: int, elbow: float, forces: tuple = (10.0,)) -> list:
    """Return pushes of each force along +x -x +y -y +z -z and at the elbow, repeated."""
    result = []
    for k in range(count):
        axis, sign = k % 8 // 2, 1.0 - 2.0 * (k % 2)
        at_elbow = (np.arange(N_JOINTS) == JOINTS.index('e1')) & (axis == 3)
        result.append(Push(
            5.0 + SPACING * k + 0.001 * (37 * k % 101),
            sign * forces[k // 8 % len(forces)] * (np.arange(3) == axis), sign * elbow * at_elbow))
    return result


def run(trajectory: str, seed: int, duration: float, plan: list = (),
        length: float = LENGTH) -> JointTrace:
    """Return the joint states of a pushed fake Baxter at the highest rate."""
    robot, period = FakeBaxter(trajectory=trajectory, seed=seed), 1.0 / max(RATES)
    edges = [edge for push in plan for edge in (
        push, Push(push.begin + length, np.zeros(3), np.zeros(N_JOINTS)))]
    order, rows = [JOINT_STATE_NAMES.index(name) for name in joint_names('right')], []
    for k in range(1, round(duration / period) + 1):
        while edges and edges[0][0] <= k * period:
            begin, force, torque = edges.pop(0)
            robot.advance(begin)
            robot.plant.force, robot.plant.torque = force, torque
        robot.advance(k * period)
        rows.append([values[order] for values in robot.joint_state()])
    return JointTrace(trajectory, 'right', period, *np.array(rows).transpose(1, 0, 2))


def at_rate(motion: JointTrace, rate: int) -> JointTrace:
    """Return the joint states that the same robot publishes at a lower rate."""
    n = round(1.0 / motion.period / rate)
    return motion.part(slice(n - 1, None, n))


def recordings(folder: Path) -> dict:
    """Return file -> list of its recordings."""
    result = {}
    for file in _FILES:
        with np.load(folder / file) as data:
            fields = [data[field] for field in ('position', 'velocity', 'effort')]
            result[file] = [
                JointTrace(str(name), 'left', float(data['period']),
                           *(x[data['recording'] == i] for x in fields))
                for i, name in enumerate(data['recording_names'])]
    return result


def plan_for(motion: JointTrace) -> list:
    """Return the pushes for a recording."""
    return pushes(int((motion.times[-1] - 6.0) / SPACING) + 1, ELBOW['recording'])


def pushed(motion: JointTrace, plan: list) -> JointTrace:
    """Return the effort that the motors would supply if they held the motion against pushes."""
    effort, arm = motion.effort.copy(), BaxterArm(mount=mount(motion.side))
    for push in plan:
        now = during(motion, push)
        linear = arm.jacobian(motion.q[now])[:, :3]
        effort[now] -= push.torque + np.einsum('nij,i->nj', linear, push.force)
    return motion._replace(effort=effort)


def play(motion: JointTrace, values: dict = {}) -> Result:
    """Play a motion to a new predictor with these settings by name."""
    settings = PredictorSettings.from_parameters({'arm': motion.side} | values)
    predictor, names, rows = Predictor(settings, external=True), joint_names(motion.side), []
    for stamp, *fields in zip(np.round(motion.times * 1e9), *motion[3:]):
        step = predictor.handle(10 ** 18 + int(stamp), names, *fields)
        residual, external = step.prediction and step.prediction.residual, step.external
        rows.append((_NOTHING if residual is None else residual,
                     _NOTHING if external is None else external.effort,
                     external is not None and bool(external.contact)))
    return Result(*map(np.array, zip(*rows)))


def latencies(motion: JointTrace, contact: np.ndarray, plan: list) -> np.ndarray:
    """Return the delay of each detection [s]; infinite where contact does not begin."""
    result = []
    for push in plan:
        now = np.flatnonzero(during(motion, push))
        hits = now[contact[now]]
        found = len(hits) and not contact[now[0] - 1]
        result.append(motion.times[hits[0]] - push.begin if found else np.inf)
    return np.array(result)


def shares(motion: JointTrace, contact: np.ndarray, plan: list) -> np.ndarray:
    """Return the share of messages with contact from each detection to the end of the push."""
    each = [contact[during(motion, push)] for push in plan]
    return np.array([now[np.argmax(now):].mean() if now.any() else 0.0 for now in each])


def begun(contact: np.ndarray) -> int:
    """Return the number of contacts."""
    return int(np.count_nonzero(contact[1:] & ~contact[:-1]))


def calibrated(motions: list) -> dict:
    """Return the bias and Coulomb friction that explain free motions best, as settings."""
    rows = []
    for motion in motions:
        lag, settled = MomentumObserver(ExternalEffortSettings.gain), round(1.0 / motion.period)
        sliding = np.tanh(motion.qd / EffortModel().coulomb_velocity)
        friction = [lag.update(motion.period, np.zeros(N_JOINTS), -x) for x in sliding]
        rows.append((play(motion).external[settled:], np.array(friction)[settled:]))
    r, friction = (np.concatenate(part) for part in zip(*rows))
    coulomb, bias = np.transpose([np.polyfit(x, -y, 1) for x, y in zip(friction.T, r.T)])
    return {'effort_model.bias': bias, 'effort_model.coulomb': np.maximum(coulomb, 0.0)}


def noise(motion: JointTrace, values: dict = {}, window: float = 0.0) -> tuple:
    """Return RMS of residual and external torque relative to a residual by first differences."""
    model = PredictorSettings.from_parameters({'arm': motion.side} | values).model
    found = play(motion, values)
    qdd = np.diff(motion.qd, axis=0) / motion.period
    q, qd, effort = (x[1:] for x in motion[3:])
    first_difference = effort - model.effort_model.effort(
        model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd)
    rms = []
    for x in (found.residual, found.external, first_difference):
        x = x[round(1.0 / motion.period):]
        if window:  # [s]: all minus their moving means
            n = round(window / motion.period)
            mean = np.lib.stride_tricks.sliding_window_view(x, n, axis=0).mean(axis=-1)
            x = x[n // 2:][:len(mean)] - mean
        rms.append(np.sqrt(np.mean(x ** 2)))
    return rms[0] / rms[2], rms[1] / rms[2]


def _row(name: str, loud: list, quiet: list):
    """Print a row of the table; loud: (motion, plan, settings), quiet: (motion, settings)."""
    found = [(motion, play(motion, values).contact, plan) for motion, plan, values in loud]
    late, kept = (np.concatenate([f(*each) for each in found]) for f in (latencies, shares))
    elbow = np.array([push.torque.any() for _, plan, _ in loud for push in plan])
    print(f'{name:36}', end='')
    for x in (1e3 * late[~elbow], 1e3 * late[elbow]):
        high = np.percentile(np.minimum(x, 9999.0), [50, 90, 100])
        print(f'{np.isfinite(x).sum():4}/{len(x):<4}', *(f'{y:4.0f}' for y in high), end='  ')
    minutes = sum(motion.times[-1] for motion, _ in quiet) / 60.0
    false = sum(begun(play(*each).contact) for each in quiet)
    print(f'{100 * kept.min():4.0f} %  {false} in {minutes:.1f} min')


def _fake():
    print('\nfake Baxter, pushes of', *FORCES, 'N at the hand and 2 N m at the elbow')
    plan = pushes(8 * len(FORCES), ELBOW['fake'], FORCES)
    for name in TRAJECTORIES:
        loud, quiet = run(name, 1, plan[-1].begin + SPACING, plan), run(name, 2, QUIET)
        for label, values in (('uncalibrated', {}), ('friction known', FRICTION)):
            for rate in RATES:
                _row(f'{name}, {label}, {rate} Hz', [(at_rate(loud, rate), plan, values)],
                     [(at_rate(quiet, rate), values)])
        print(f'{name}: RMS of residual %.3f, external torque %.3f of the first difference'
              % noise(at_rate(quiet, 100), FRICTION))


def _recorded(folder: Path):
    print('\nrecordings, 10 N at the hand and 4 N m at the elbow')
    for file, motions in recordings(folder).items():
        halves = ((motions[::2], motions[1::2]) if len(motions) > 1 else
                  ([motions[0].part(slice(9000))], [motions[0].part(slice(9000, None))]))
        quiet = {'uncalibrated': [(motion, {}) for motion in motions],
                 'calibrated on others': [
                     (motion, values) for fitted, others in (halves, halves[::-1])[:len(motions)]
                     for values in [calibrated(fitted)] for motion in others]}
        for label, cases in quiet.items():
            plans = [plan_for(motion) for motion, _ in cases]
            _row(f'{label}, {file[7:-4]}', [
                (pushed(motion, plan), plan, values)
                for (motion, values), plan in zip(cases, plans)], cases)
        for motion in motions:
            print(f'{motion.name}: RMS of residual %.3f, external torque %.3f of the first '
                  'difference, each less its mean over 1 s' % noise(motion, window=1.0))


def main():
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--recordings', type=Path, metavar='FOLDER',
                        help='also judge the recordings of real arms in this folder')
    arguments = parser.parse_args()
    print('found of how many and after how long (median, 90th percentile, slowest) [ms], at the '
          'hand and at the elbow;\nlowest share of messages with contact until a push ends; '
          'false contacts without pushes')
    if arguments.recordings:
        _recorded(arguments.recordings)
    _fake()


if __name__ == '__main__':
    main()
