"""How fast pushes are found, how often none is, and how noisy the residuals are, as tables."""

import argparse
from pathlib import Path
from typing import NamedTuple

from baxter_dynamics_ros.estimation.contact import ContactDetector
from baxter_dynamics_ros.estimation.observer import MomentumObserver
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.arm import BaxterArm
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names, JOINTS, mount, N_JOINTS
from baxter_dynamics_ros.simulation.plant import COULOMB
from baxter_dynamics_ros.simulation.robot import FakeBaxter, JOINT_STATE_NAMES
import numpy as np

TRAJECTORIES = ('circle', 'switch', 'lift')
SEEDS = (1, 2)
DURATION = 180.0  # of each run on the fake Baxter [s]
PERIOD = 0.01  # of its joint states [s]
LAG = 0.014  # by which velocity lags position and effort [s]
GAIN = 10.0  # of the observer [1/s]
LENGTH = 0.8  # of a push [s]
FORCE = 10.0  # at the hand [N]
ELBOW = {'fake': 2.0, 'recording': 4.0}  # at e1 [N m]
TOLD = EffortModel(coulomb=COULOMB)  # the fake Baxter's friction
_FILES = {'baxter_left_arm_tracking.npz': 12, 'baxter_point_to_point.npz': 1}


class Motion(NamedTuple):
    """A run or a recording; arrays (n, 7) in joint order."""

    name: str
    side: str
    period: float  # [s]
    q: np.ndarray  # [rad]
    qd: np.ndarray  # [rad/s]
    effort: np.ndarray  # [N m]


class Push(NamedTuple):
    """A force at the hand, or a torque at the elbow, with a sharp begin and end."""

    begin: float  # [s]
    force: np.ndarray  # (3,), axes of the base [N]
    torque: np.ndarray  # (7,) [N m]


def pushes(duration: float, elbow: float) -> list:
    """Return pushes by a fixed rule: +-x +-y +-z, +-elbow, and so on; no two in step."""
    result = []
    for k in range(int((duration - 6.0) / 2.5) + 1):
        axis, sign = k % 8 // 2, 1.0 - 2.0 * (k % 2)
        at_elbow = (np.arange(N_JOINTS) == JOINTS.index('e1')) & (axis == 3)
        result.append(Push(5.0 + 2.5 * k + 0.001 * (37 * k % 101),
                           sign * FORCE * (np.arange(3) == axis), sign * elbow * at_elbow))
    return result


def run(trajectory: str, seed: int, duration: float, plan: list = (),
        length: float = LENGTH) -> Motion:
    """Return what a fake Baxter publishes at 100 Hz while it is pushed."""
    robot = FakeBaxter(trajectory=trajectory, seed=seed)
    edges = sorted([(push.begin, push.force, push.torque) for push in plan]
                   + [(push.begin + length, np.zeros(3), np.zeros(N_JOINTS)) for push in plan],
                   key=lambda edge: edge[0])
    order, rows = [JOINT_STATE_NAMES.index(name) for name in joint_names('right')], []
    for k in range(1, round(duration / PERIOD) + 1):
        while edges and edges[0][0] <= k * PERIOD:
            begin, force, torque = edges.pop(0)
            robot.advance(begin)
            robot.force, robot.torque = force, torque
        robot.advance(k * PERIOD)
        rows.append([values[order] for values in robot.joint_state()])
    return Motion(trajectory, 'right', PERIOD, *np.array(rows).transpose(1, 0, 2))


def every_second(motion: Motion) -> Motion:
    """Return what the same robot publishes at half the rate."""
    return motion._replace(period=2 * motion.period, q=motion.q[1::2], qd=motion.qd[1::2],
                           effort=motion.effort[1::2])


def recordings(folder: Path) -> dict:
    """Return file -> list of its recordings."""
    result = {}
    for file, count in _FILES.items():
        with np.load(folder / file) as data:
            which = data['recording']
            parts = [[data[field][which == i] for field in ('position', 'velocity', 'effort')]
                     for i in range(count)]
            result[file] = [Motion(str(name), 'left', float(data['period']), *part)
                            for name, part in zip(data['recording_names'], parts)]
    return result


def times(motion: Motion) -> np.ndarray:
    """Return when its samples arrive, (n,) [s]: a run's first sample is one period old."""
    return motion.period * np.arange(1, len(motion.q) + 1)


def pushed(motion: Motion, plan: list) -> Motion:
    """Return what the motors would measure if they held the motion against pushes."""
    t, effort = times(motion), motion.effort.copy()
    arm = BaxterArm(mount=mount(motion.side))
    for push in plan:
        now = (t >= push.begin) & (t < push.begin + LENGTH)
        linear = arm.jacobian(motion.q[now])[:, :3]
        effort[now] -= push.torque + np.einsum('nij,i->nj', linear, push.force)
    return motion._replace(effort=effort)


def external_torque(motion: Motion, model: EffortModel) -> np.ndarray:
    """Return the observer's estimate for LAG before each sample, (n, 7) [N m], once settled."""
    arm, t = BaxterArm(mount=mount(motion.side)), times(motion)
    first = int(np.ceil(LAG / motion.period))
    q, effort = (np.array([np.interp(t[first:] - LAG, t, x) for x in field.T]).T
                 for field in (motion.q, motion.effort))
    qd, zero = motion.qd[first:], np.zeros_like(q)
    tau = effort - model.effort(zero, q, qd, zero)
    momentum, coriolis, gravity = arm.momentum_terms(q, qd)
    observer = MomentumObserver(GAIN)
    r = [observer.update(motion.period, *row) for row in zip(momentum, tau + coriolis - gravity)]
    return np.concatenate([np.zeros((first, N_JOINTS)), r])


def contacts(motion: Motion, model: EffortModel, **settings) -> np.ndarray:
    """Return whether the detector says contact at each sample, (n,) bool."""
    detector = ContactDetector(**settings)
    return np.array([detector.update(motion.period, *row)
                     for row in zip(external_torque(motion, model), motion.q)])


def latencies(motion: Motion, found: np.ndarray, plan: list) -> np.ndarray:
    """Return after how long each push is found [s]; infinite if it is not, or none began."""
    t, result = times(motion), []
    for push in plan:
        now = np.flatnonzero((t >= push.begin) & (t < push.begin + LENGTH))
        hits = now[found[now]]
        already = found[now[0] - 1]
        result.append(t[hits[0]] - push.begin if len(hits) and not already else np.inf)
    return np.array(result)


def begun(found: np.ndarray) -> int:
    """Return how often contact began."""
    return int(np.count_nonzero(found[1:] & ~found[:-1]))


def calibrated(motions: list) -> EffortModel:
    """Return the effort model with bias and Coulomb friction that explain free motions best."""
    rows = []
    for motion in motions:
        r, lag = external_torque(motion, EffortModel()), MomentumObserver(GAIN)
        sliding = np.tanh(motion.qd / EffortModel().coulomb_velocity)
        friction = [lag.update(motion.period, np.zeros(N_JOINTS), -x) for x in sliding]
        settled = round(1.0 / motion.period)
        rows.append((r[settled:], np.array(friction)[settled:]))
    r, friction = (np.concatenate(part) for part in zip(*rows))
    bias, coulomb = np.array([
        np.linalg.lstsq(np.stack([np.ones(len(r)), x], axis=1), -y, rcond=None)[0]
        for x, y in zip(friction.T, r.T)]).T
    return EffortModel(bias=bias, coulomb=np.maximum(coulomb, 0.0))


def residual(motion: Motion, **values) -> np.ndarray:
    """Return what the predictor leaves over, (m, 7) [N m]."""
    predictor = PredictorSettings({'arm': motion.side} | values).predictor()
    names = joint_names(motion.side)
    results = [predictor.handle(10 ** 18 + round(k * motion.period * 1e9), names, *row)
               for k, row in enumerate(zip(motion.q, motion.qd, motion.effort))]
    return np.array([x.residual for x in results if x is not None and x.residual is not None])


def first_difference(motion: Motion, model: EffortModel) -> np.ndarray:
    """Return the residual with the paper's acceleration, (n - 1, 7) [N m]."""
    qdd = np.diff(motion.qd, axis=0) / motion.period
    q, qd, effort = motion.q[1:], motion.qd[1:], motion.effort[1:]
    tau = BaxterArm(mount=mount(motion.side)).inverse_dynamics(q, qd, qdd)
    return effort - model.effort(tau, q, qd, qdd)


def without_mean(x: np.ndarray, period: float) -> np.ndarray:
    """Return x (n, 7) less its moving mean over 1 s, where that is known."""
    n = round(1.0 / period)
    total = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x, axis=0)])
    mean = (total[n:] - total[:-n]) / n
    return x[n // 2:][:len(mean)] - mean


def rms(x: np.ndarray) -> float:
    """Return the RMS over all samples and joints."""
    return float(np.sqrt(np.mean(x ** 2)))


def _row(name: str, quiet: list, loud: list, plan: list):
    """Print one row: quiet and loud are of (motion, contacts), without pushes and with them."""
    late = np.array([latencies(motion, found, pushes_)
                     for (motion, found), pushes_ in zip(loud, plan)], dtype=object)
    late = np.concatenate([x.astype(float) for x in late])
    elbow = np.concatenate([[push.torque.any() for push in pushes_] for pushes_ in plan])
    minutes = sum(len(found) * motion.period for motion, found in quiet) / 60.0
    false = sum(begun(found) for _, found in quiet)
    print(f'{name:34}', end='')
    for x in (late[~elbow], late[elbow]):
        seen = 1e3 * x[np.isfinite(x)]
        high = np.percentile(np.where(np.isfinite(x), 1e3 * x, 9999.0), 90)
        print(f'{len(seen):4}/{len(x):<4}{np.median(seen):5.0f}{high:5.0f}{seen.max():5.0f}   ',
              end='')
    print(f'{false:3} in {minutes:4.1f} min')


def _fake():
    print('\nfake Baxter, 10 N at the hand and 2 N m at the elbow; found, then median, '
          '90th percentile and slowest [ms]; false contacts without pushes')
    plan = pushes(DURATION, ELBOW['fake'])
    runs = {name: [(run(name, seed, DURATION), run(name, seed, DURATION, plan))
                   for seed in SEEDS] for name in TRAJECTORIES}
    for label, model in (('uncalibrated', EffortModel()), ('friction told', TOLD)):
        for rate in (100, 50):
            for name, pairs in runs.items():
                pairs = pairs if rate == 100 else [tuple(map(every_second, p)) for p in pairs]
                quiet, loud = ([(motion, contacts(motion, model)) for motion in part]
                               for part in zip(*pairs))
                _row(f'{label}, {rate} Hz, {name}', quiet, loud, [plan] * len(loud))
    print('\nRMS of a residual over that with the first difference, friction told')
    for name, pairs in runs.items():
        motion, settled = pairs[0][0], round(1.0 / PERIOD)
        difference = rms(first_difference(motion, TOLD))
        print(f'{name:34} predictor '
              f'{rms(residual(motion, **{"effort_model.coulomb": COULOMB})) / difference:.3f}'
              f'   external {rms(external_torque(motion, TOLD)[settled:]) / difference:.3f}')


def _recorded(folder: Path):
    print('\nrecordings, 10 N at the hand and 4 N m at the elbow')
    files = recordings(folder)
    for file, motions in files.items():
        if len(motions) > 1:
            halves = motions[::2], motions[1::2]
        else:
            halves = [[motions[0]._replace(**{field: getattr(motions[0], field)[part]
                                              for field in ('q', 'qd', 'effort')})]
                      for part in (slice(0, 9000), slice(9000, None))]
        cases = {'uncalibrated': [(motion, EffortModel()) for motion in motions],
                 'calibrated on others': _pair(*halves)}
        if len(motions) > 1:
            cases['calibrated on others'] += _pair(*reversed(halves))
        for label, pairs in cases.items():
            plans = [pushes(times(motion)[-1], ELBOW['recording']) for motion, _ in pairs]
            quiet = [(motion, contacts(motion, model)) for motion, model in pairs]
            loud = [(motion, contacts(pushed(motion, plan), model))
                    for (motion, model), plan in zip(pairs, plans)]
            _row(f'{label}, {file[7:-4]}', quiet, loud, plans)
    print('\nRMS of a residual over that with the first difference, each less its mean over 1 s')
    for motion in sum(files.values(), []):
        difference = rms(without_mean(first_difference(motion, EffortModel()), motion.period))
        external = external_torque(motion, EffortModel())[round(1.0 / motion.period):]
        print(f'{motion.name:34} predictor '
              f'{rms(without_mean(residual(motion), motion.period)) / difference:.3f}'
              f'   external {rms(without_mean(external, motion.period)) / difference:.3f}')


def _pair(to_fit: list, to_judge: list) -> list:
    model = calibrated(to_fit)
    return [(motion, model) for motion in to_judge]


def main():
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--recordings', type=Path, metavar='FOLDER',
                        help='also judge the recordings of real arms in this folder')
    arguments = parser.parse_args()
    if arguments.recordings:
        _recorded(arguments.recordings)
    _fake()


if __name__ == '__main__':
    main()
