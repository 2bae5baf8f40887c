"""Data check: whether a recording's effort and velocity are what the model takes them for."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from .notices import Notice
from .velocity_lag import Lag, TRAVEL, VelocitySums
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.effort import EffortModel
from ..model.joints import JOINTS, N_JOINTS, S1

USUAL_LAG = 0.014  # of Baxter's velocity [s]

_ROWS = 4000  # most samples that are kept, evenly spaced
_SHORTEST = 5.0  # duration below which nothing is judged [s]
_KNOWN = 0.25  # largest standard deviation of a gain that is judged
_ACCELERATES = 0.3  # standard deviation of an acceleration that is not just noise [rad/s^2]
_LOAD_BEARING = slice(0, 4)  # s0, s1, e0, e1: a gripper multiplies the small torques of the wrist
_MOVED_COST = 1.0  # log of variance that each exchanged joint must save
_SLIDING = 0.05  # width of the change of sign of friction [rad/s]


class Gain(NamedTuple):
    """Gain of measured effort on a part of the predicted effort, per joint; NaN if unknown."""

    value: Array  # (7,)
    deviation: Array  # (7,) standard deviation

    @property
    def known(self) -> Bools:
        """Return where the motion shows the gain, (7,) bool."""
        return np.nan_to_num(self.deviation, nan=np.inf) < _KNOWN

    def median(self, joints: slice = _LOAD_BEARING) -> float:
        """Return the median over the joints where it is known; NaN if there is none."""
        values = self.value[joints][self.known[joints]]
        return float(np.median(values)) if len(values) else np.nan


@dataclass(frozen=True, eq=False)
class DataCheck:
    """
    What measured effort and velocity have in common with the model.

    Attributes
    ----------
    gain, correlation : ndarray (7,)
        Slope of measured over predicted effort without friction, and their correlation; NaN for a
        joint that does not move.
    inertial, gravity, spring : Gain
        Gain of the measured effort on M qdd + C qd, on G, and on the spring at s1.
    coulomb : ndarray (7,)
        Coulomb friction beside these gains [N m].
    lag : Lag or None
        Lag of the velocity; None if unknown.
    velocity_scale : float
        Change of position over integrated velocity; NaN if unknown.
    problems : tuple of Notice
        What is wrong with the data, most fundamental first.

    """

    gain: Array
    correlation: Array
    inertial: Gain
    gravity: Gain
    spring: Gain
    coulomb: Array
    lag: 'Lag | None'
    velocity_scale: float
    problems: tuple[Notice, ...]


class DataChecker:
    """
    Collects samples of one or more recordings of an arm, and checks them.

    Memory does not grow with the length of the recordings.

    Parameters
    ----------
    settings : PredictorSettings
        The model that the data are compared with.

    """

    def __init__(self, settings: PredictorSettings) -> None:
        self._settings = settings
        self._parts: list[Array] = []  # (n, 4, 7): q, qd, qdd, measured effort
        self._stride = 1
        self._seen = 0
        self._duration = 0.0  # [s]
        self._recent: list[tuple[Array, Array, Array]] = []
        self._velocity = VelocitySums()

    def add(self, time: Array, state: Array, newest_q: Array, newest_qd: Array) -> None:
        """
        Add consecutive samples of a recording.

        Parameters
        ----------
        time : ndarray (n,)
            Stamps [s].
        state : ndarray (n, 4, 7)
            q, qd, qdd and measured effort of one instant, in rad, s and N m.
        newest_q, newest_qd : ndarray (n, 7)
            Position and velocity as in the messages [rad, rad/s].

        """
        self._parts.append(state[-self._seen % self._stride::self._stride])
        self._seen += len(state)
        self._recent.append((time, newest_q, newest_qd))
        if sum(len(part) for part in self._parts) > 2 * _ROWS:
            self._parts = [np.concatenate(self._parts)[::2]]
            self._stride *= 2
        if sum(len(recent[0]) for recent in self._recent) > _ROWS:
            self._flush()

    def end_recording(self) -> None:
        """End a recording: what follows is not consecutive."""
        self._flush()

    def result(self) -> 'DataCheck | None':
        """Return what was found; None if there are too few samples with effort."""
        self._flush()
        rows = np.concatenate(self._parts) if self._parts else np.empty((0, 4, N_JOINTS))
        if len(rows) < 2 or self._duration < _SHORTEST:
            return None
        return _check(rows, self._duration, self._velocity, self._settings)

    def _flush(self) -> None:
        if self._recent:
            time, q, qd = (np.concatenate(column) for column in zip(*self._recent))
            steps = np.diff(time)
            self._duration += float(steps[(steps > 0.0) & (steps < 0.3)].sum())
            self._velocity.add(time, q, qd)
            self._recent = []


class _Data(NamedTuple):
    """Samples and the parts of the prediction that they are compared with, (n, 7) each."""

    q: Array
    qd: Array
    qdd: Array
    measured: Array
    inertial: Array  # M qdd + C qd [N m]
    gravity: Array  # [N m]
    spring: Array  # of the default shape if the settings have none [N m]
    predicted: Array  # without friction and bias [N m]
    moves: Bools  # (7,)
    duration: float  # [s]
    settings: PredictorSettings


def _check(rows: Array, duration: float, velocity: VelocitySums,
           settings: PredictorSettings) -> DataCheck:
    q, qd, qdd, measured = rows.swapaxes(0, 1)
    data = _Data(q, qd, qdd, measured, *_predicted(settings, q, qd, qdd),
                 (np.ptp(q, axis=0) > TRAVEL) & (np.ptp(measured, axis=0) > 1e-6),
                 duration, settings)
    gains = np.array([_gains(data, joint) for joint in range(N_JOINTS)])  # (7, 4, 2)
    gain, correlation = _overall(data)
    inertial, on_gravity, on_spring = (Gain(*gains[:, k].T) for k in range(3))
    check = DataCheck(gain, correlation, inertial, on_gravity, on_spring, gains[:, 3, 0],
                      velocity.lag(), velocity.scale(), ())
    return DataCheck(**{**vars(check), 'problems': tuple(_problems(data, check))})


def _predicted(settings: PredictorSettings, q: Array, qd: Array,
               qdd: Array) -> tuple[Array, Array, Array, Array]:
    arm, model = settings.arm, settings.effort_model
    gravity = arm.gravity(q)
    tau = arm.inverse_dynamics(q, qd, qdd)
    spring = (model if model.has_spring else EffortModel()).spring(q)
    return tau - gravity, gravity, spring, tau + spring * model.has_spring


def _gains(data: _Data, joint: int) -> Array:
    """Return gain and deviation for inertial, gravity, spring and Coulomb torque, (4, 2)."""
    result = np.full((4, 2), np.nan)
    if not data.moves[joint]:
        return result
    columns = [data.inertial[:, joint], data.gravity[:, joint], data.spring[:, joint],
               np.tanh(data.qd[:, joint] / _SLIDING)]
    used = [k for k, column in enumerate(columns) if column.std() > 1e-6
            and (k > 0 or data.qdd[:, joint].std() > _ACCELERATES)]
    x = np.stack([np.ones(len(data.q)), *(columns[k] for k in used)], axis=1)
    solution = np.linalg.lstsq(x, data.measured[:, joint], rcond=None)[0]
    left = data.measured[:, joint] - x @ solution
    # Residuals stay alike for about a second, so a second counts as one sample.
    variance = left.var() * len(x) / max(data.duration, 1.0)
    deviation = np.sqrt(variance * np.diag(np.linalg.pinv(x.T @ x)))
    result[used] = np.stack([solution, deviation], axis=1)[1:]
    return result


def _overall(data: _Data) -> tuple[Array, Array]:
    """Return slope of measured over predicted effort, and correlation, (7,) each."""
    x, y = (values - values.mean(0) for values in (data.predicted, data.measured))
    with np.errstate(invalid='ignore', divide='ignore'):
        slope = (x * y).sum(0) / (x * x).sum(0)
        correlation = (x * y).sum(0) / np.sqrt((x * x).sum(0) * (y * y).sum(0))
    return np.where(data.moves, slope, np.nan), np.where(data.moves, correlation, np.nan)


def _problems(data: _Data, check: DataCheck) -> Iterator[Notice]:
    """Yield what is wrong; a rule is asked only while those before it found nothing."""
    yield from _constant_effort(data)
    lag = _odd_lag(check)
    found: list[Notice] = []
    rule: Any = None
    for rule in (_velocity_scale, _exchanged, _sign, _without_gravity, _scale, _hand_guided,
                 _springs):
        found = list(rule(data, check))
        yield from found
        if found:
            break
    if lag is not None and not (found and rule is _velocity_scale):
        yield lag


def _constant_effort(data: _Data) -> Iterator[Notice]:
    constant = np.ptp(data.measured, axis=0) < 1e-6
    for joint in np.flatnonzero(constant):
        yield Notice('effort_constant', f'effort of {JOINTS[joint]} is always '
                     f'{data.measured[0, joint]:g} N m: it is not measured',
                     (JOINTS[joint],), refuses=True)


def _velocity_scale(data: _Data, check: DataCheck) -> Iterator[Notice]:
    scale = check.velocity_scale
    if np.isfinite(scale) and not 0.8 < scale < 1.25:
        degrees = np.radians(1.0)
        cause = ('their sign is opposite' if scale < 0.0 else
                 'velocities in degrees per second do that: convert them to rad/s'
                 if 0.8 < scale / degrees < 1.25 else
                 f'check whether the period of the stamps is {1 / scale:.2g} times the true one, '
                 'or velocities are not in rad/s')
        yield Notice('velocity_scale', f'positions change by {scale:.3g} of what the velocities '
                     f'integrate to, instead of 1: {cause}', refuses=True)


def _odd_lag(check: DataCheck) -> 'Notice | None':
    lag = check.lag
    if lag is None or abs(lag.value - USUAL_LAG) < max(0.009, 3 * lag.uncertainty):
        return None
    return Notice('velocity_lag', f'velocities lag positions by {1e3 * lag.value:.1f} ± '
                  f'{1e3 * lag.uncertainty:.1f} ms; Baxter has {1e3 * USUAL_LAG:.0f} ms, a '
                  'simulator none: check the period of the stamps, and how velocities were made')


def _exchanged(data: _Data, check: DataCheck) -> Iterator[Notice]:
    """Look for joints whose effort fits another joint's prediction, or which are exchanged."""
    errors = data.measured[:, :, None] - data.predicted[:, None]
    cost = np.log(errors.var(axis=0) + 1e-4)  # [measured, predicted]
    orders = np.array(list(permutations(range(N_JOINTS))))
    identity = np.arange(N_JOINTS)
    total = cost[identity, orders].sum(1) + _MOVED_COST * (orders != identity).sum(1)
    constant = np.ptp(data.measured, axis=0) < 1e-6
    total[(constant & (orders != identity)).any(1)] = np.inf
    best = orders[int(np.argmin(total))]
    what = 'efforts'
    bearing = np.nan_to_num(check.correlation[_LOAD_BEARING][data.moves[_LOAD_BEARING]])
    # Efforts with the shape of their own joint's prediction belong to it, whatever their gain.
    if (best == identity).all() and not (np.abs(bearing) > 0.7).all():
        best, what = _exchanged_joints(data, float(np.trace(cost))), 'joints'
    where = np.flatnonzero(best != identity)
    if len(where):
        names = tuple(JOINTS[i] for i in where)
        fits = ', '.join(f'{JOINTS[i]} fits {JOINTS[best[i]]}' for i in where)
        yield Notice('joints_exchanged', f'{what} of {", ".join(names)} look exchanged ({fits}): '
                     'check the order of the names', names, refuses=True)


def _exchanged_joints(data: _Data, cost: float) -> Any:
    """Return the order (7,) in which two joints are exchanged, if that explains the effort."""
    identity = np.arange(N_JOINTS)
    rows = slice(None, None, max(len(data.q) // 400, 1))
    q, qd, qdd, measured = (x[rows] for x in (data.q, data.qd, data.qdd, data.measured))
    best, least = identity, cost - 4 * _MOVED_COST
    for i in range(N_JOINTS):
        for k in range(i + 1, N_JOINTS):
            order = identity.copy()
            order[[i, k]] = k, i
            predicted = _predicted(data.settings, q[:, order], qd[:, order], qdd[:, order])[-1]
            trial = float(np.log((measured[:, order] - predicted).var(0) + 1e-4).sum())
            if trial < least:
                best, least = order, trial
    return best


def _sign(data: _Data, check: DataCheck) -> Iterator[Notice]:
    negative = (check.correlation < -0.6) & (data.predicted.std(0) > 0.3)
    if negative.any():
        yield Notice('effort_sign', f'measured effort has the opposite sign of the prediction at '
                     f'{_numbers(negative, check.correlation, "correlation ")}: negate it',
                     _names(negative), refuses=True)


def _without_gravity(data: _Data, check: DataCheck) -> Iterator[Notice]:
    gravity = check.gravity.median()
    if gravity < 0.4 and not check.inertial.median() < 0.4:
        joints = check.gravity.known & (np.arange(N_JOINTS) < _LOAD_BEARING.stop)
        yield Notice('no_gravity', f'measured effort holds {gravity:.2f} of the torque of gravity '
                     f'({_numbers(joints, check.gravity.value)}), instead of 1: effort without '
                     'gravity compensation cannot be compared; for a simulator without gravity '
                     'use simulation.yaml with gravity [0, 0, 0]', _names(joints), refuses=True)


def _scale(data: _Data, check: DataCheck) -> Iterator[Notice]:
    bearing = (data.predicted.std(0) > 0.5) & (np.arange(N_JOINTS) < _LOAD_BEARING.stop)
    bearing &= np.abs(check.correlation) > 0.7
    overall = np.median(check.gain[bearing]) if bearing.any() else 1.0
    odd = bearing & ((check.gain < 0.45) | (check.gain > 2.2))
    if not 0.6 < overall < 1.7:
        odd = bearing
    if odd.any():
        yield Notice('effort_scale', 'measured effort is the predicted one times '
                     f'{_numbers(odd, check.gain)}: check its unit', _names(odd), refuses=True)


def _springs(data: _Data, check: DataCheck) -> Iterator[Notice]:
    spring = check.spring
    if not spring.known[S1]:
        return
    value, has_spring = spring.value[S1], data.settings.effort_model.has_spring
    if has_spring and value < 0.4:
        yield Notice('no_springs', f"measured effort of s1 holds {value:.2f} of the springs' "
                     'torque, instead of 1: simulators have no springs; use simulation.yaml',
                     ('s1',), refuses=True)
    elif not has_spring and value > 0.6:
        yield Notice('springs', f"measured effort of s1 holds {value:.2f} of the springs' torque "
                     'that these settings leave out: for a real robot enable effort_model',
                     ('s1',))


def _hand_guided(data: _Data, check: DataCheck) -> Iterator[Notice]:
    joints = check.inertial.known & (np.arange(N_JOINTS) < _LOAD_BEARING.stop)
    inertial = check.inertial.median()
    if not inertial < 0.35:
        return
    friction = joints & (check.coulomb < 0.0)
    text = (f'measured effort holds {inertial:.2f} of the inertial and Coriolis torque '
            f'({_numbers(joints, check.inertial.value)}), instead of 1')
    if friction.any():
        text += f', and friction is negative ({_numbers(friction, check.coulomb, unit=" N m")})'
    yield Notice('moved_by_hand', f'{text}: the motors did not make this motion. An arm moved by '
                 'hand cannot be calibrated: record a motion that the motors make',
                 _names(joints), refuses=True)


def _names(where: Bools) -> tuple[str, ...]:
    return tuple(JOINTS[i] for i in np.flatnonzero(where))


def _numbers(where: Bools, values: Array, before: str = '', unit: str = '') -> str:
    return ', '.join(f'{JOINTS[i]} {before}{values[i]:.2f}{unit}' for i in np.flatnonzero(where))
