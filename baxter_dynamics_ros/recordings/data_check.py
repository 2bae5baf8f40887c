"""Data check: whether measured effort and velocity have the meaning that the model assumes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Any, NamedTuple

import numpy as np

from .playback import Lag, lag_and_scale, Samples, stamp_statistics, TRAVEL, velocity_sums
from ..estimation.events import Event
from ..estimation.settings import PredictorSettings
from ..model import Array, Bools, EffortModel, JOINTS, N_JOINTS, names_of, S1

USUAL_LAG = 0.014  # of Baxter's velocity [s]

_ROWS = 8000  # maximum number of samples compared, evenly spaced
_SHORTEST = 5.0  # duration below which nothing is checked [s]
_KNOWN = 0.25  # maximum standard deviation of a gain that is checked
_ACCELERATES = 0.3  # standard deviation of an acceleration that is not just noise [rad/s^2]
_BEARS_LOAD = np.arange(N_JOINTS) < 4  # a gripper multiplies the small torques of the wrist
_MOVED_COST = 1.0  # minimum decrease of log variance per exchanged joint
_SLIDING = 0.05  # width of the change of sign of friction [rad/s]
_FEW = 0.1  # share of implausible joint states, of the others, that may be errors of transport
_SAME = np.arange(N_JOINTS)
_Found = tuple[str, Bools, str, str]  # kind, joints concerned (7,), finding, remedy


@dataclass(frozen=True)
class Notice:
    """A warning about a recording or a fit."""

    kind: str  # such as 'effort_sign' or the value of an event
    finding: str  # one sentence with numbers
    joints: tuple[str, ...] = ()  # joints concerned; empty for all or none
    recording: str = ''  # recording concerned; empty for all
    refuses: bool = False  # whether a calibration must not use the data
    remedy: str = ''

    def __str__(self) -> str:
        """Return the finding in one line, with its recording and remedy."""
        return ': '.join(filter(None, (self.recording, self.finding, self.remedy)))


class Gain(NamedTuple):
    """Gain of measured effort on a part of the predicted effort, per joint; NaN if unknown."""

    value: Array  # (7,)
    deviation: Array  # (7,) standard deviation

    @property
    def known(self) -> Bools:
        """Return whether the motion determines the gain, (7,)."""
        return np.nan_to_num(self.deviation, nan=np.inf) < _KNOWN

    def median(self) -> float:
        """Return the median over load-bearing joints with known gain; NaN if there are none."""
        values = self.value[self.known & _BEARS_LOAD]
        return float(np.median(values)) if len(values) else np.nan


@dataclass(frozen=True, eq=False)
class DataCheck:
    """Comparison of measured effort and velocity with the model; arrays (7,)."""

    gain: Array  # slope of measured over predicted effort without friction; NaN at rest
    correlation: Array  # of these; NaN for a joint at rest
    inertial: Gain  # of the measured effort on M qdd + C qd
    gravity: Gain  # on G
    spring: Gain  # on the spring at s1
    coulomb: Array  # on the sign of velocity: Coulomb friction [N m]
    lag: 'Lag | None'  # of the velocity; None if unknown
    velocity_scale: float  # change of position over integrated velocity; NaN if unknown
    problems: tuple[Notice, ...] = ()  # most fundamental first


class RunningCheck:
    """Compares samples with the model of settings; its memory does not grow with their number."""

    def __init__(self, settings: PredictorSettings) -> None:
        self._settings = settings
        self._rows = np.empty((0, 4, N_JOINTS))  # q, qd, qdd, effort of every stride-th sample
        self._seen, self._stride = 0, 1
        self._duration = 0.0  # [s]
        self._velocity = np.zeros((2, 2, N_JOINTS))  # sums

    def add(self, part: Samples) -> None:
        """Add consecutive samples that have an effort."""
        self._duration += stamp_statistics(np.diff(part.time)).duration
        self._velocity += velocity_sums(part)
        rows = np.stack([part.q, part.qd, part.qdd, part.effort], axis=1)
        self._rows = np.concatenate([self._rows, rows[-self._seen % self._stride::self._stride]])
        self._seen += len(rows)
        while len(self._rows) > _ROWS:
            self._rows = self._rows[::2].copy()
            self._stride *= 2

    def result(self) -> 'DataCheck | None':
        """Return the comparison; None if there are too few samples."""
        if self._duration < _SHORTEST:
            return None
        data = _Data.of(self._settings, self._rows.swapaxes(0, 1))
        inertial, gravity, spring, coulomb = _gains(data, self._duration)
        data = data._replace(complete=data.complete ^ spring.known & (np.abs(spring.value) < 0.4))
        check = DataCheck(*_overall(data), inertial, gravity, spring, coulomb.value,
                          *lag_and_scale(self._velocity))
        return replace(check, problems=tuple(_problems(data, check)))


class _Data(NamedTuple):
    """Samples and the parts of their prediction, (n, 7) each."""

    settings: PredictorSettings
    q: Array  # [rad]
    qd: Array
    qdd: Array
    measured: Array  # effort [N m]
    gravity: Array  # [N m]
    inertial: Array  # M qdd + C qd [N m]
    spring: Array  # of the default shape if the settings have none [N m]
    predicted: Array  # without friction and bias [N m]
    complete: Bools  # (7,); false for s1 where settings and effort may differ in the springs

    @classmethod
    def of(cls, settings: PredictorSettings, motion: Array) -> '_Data':
        (q, qd, qdd, measured), model = motion, settings.model.effort_model
        gravity = settings.model.arm.gravity(q)
        tau = settings.model.arm.inverse_dynamics(q, qd, qdd)
        spring = (model if model.has_spring else EffortModel()).spring(q)
        return cls(settings, q, qd, qdd, measured, gravity, tau - gravity, spring,
                   model.coupled(tau + model.spring(q)), (_SAME != S1) | model.has_spring)

    @property
    def constant(self) -> Bools:
        """Return whether the measured effort is constant, (7,)."""
        return np.ptp(self.measured, axis=0) < 1e-6

    @property
    def moves(self) -> Bools:
        """Return whether the joint moves and its measured effort varies, (7,)."""
        return (np.ptp(self.q, axis=0) > TRAVEL) & ~self.constant


def _gains(data: _Data, duration: float) -> list[Gain]:
    """Return the gains on inertial, gravity and spring torque and on the sign of velocity."""
    parts = np.stack([data.inertial, data.gravity, data.spring, np.tanh(data.qd / _SLIDING)])
    varies = parts.std(axis=1) > 1e-6  # (4, 7)
    varies[0] &= data.qdd.std(axis=0) > _ACCELERATES
    result = np.full((4, 2, N_JOINTS), np.nan)
    for joint in np.flatnonzero(data.moves):
        used = varies[:, joint]
        x = np.column_stack([np.ones(len(data.q)), *parts[used, :, joint]])
        solution = np.linalg.lstsq(x, data.measured[:, joint], rcond=None)[0]
        left = data.measured[:, joint] - x @ solution
        # Residuals are correlated for about a second, so a second counts as one sample.
        variance = left.var() * len(x) / max(duration, 1.0)
        deviation = np.sqrt(variance * np.diag(np.linalg.pinv(x.T @ x)))
        result[used, :, joint] = np.stack([solution, deviation], axis=1)[1:]
    return [Gain(*pair) for pair in result]


def _overall(data: _Data) -> tuple[Array, Array]:
    """Return slope of measured over predicted effort, and correlation, (7,) each."""
    x, y = (values - values.mean(0) for values in (data.predicted, data.measured))
    with np.errstate(invalid='ignore', divide='ignore'):
        slope = (x * y).sum(0) / (x * x).sum(0)
        correlation = (x * y).sum(0) / np.sqrt((x * x).sum(0) * (y * y).sum(0))
    return np.where(data.moves, slope, np.nan), np.where(data.moves, correlation, np.nan)


def _problems(data: _Data, check: DataCheck) -> Iterator[Notice]:
    """Yield the problems; the first rule that finds one hides those after it."""
    if data.constant.any():
        yield Notice('effort_constant', 'measured effort is constant '
                     f'({_numbers(data.constant, data.measured[0])} N m)',
                     names_of(data.constant), refuses=True,
                     remedy='record a robot or a simulator that measures effort')
    scale, lag = check.velocity_scale, check.lag
    if not np.isnan(scale) and not 0.8 < scale < 1.25:
        remedy = ('negate the velocities: their signs are reversed' if scale < 0.0 else
                  'convert velocities from deg/s to rad/s' if 0.8 < np.degrees(scale) < 1.25 else
                  f'check whether the period of the stamps is {1 / scale:.2g} times the true one, '
                  'or velocities are not in rad/s')
        yield Notice('velocity_scale', f'positions change by {scale:.3g} times the integral of '
                     'the velocities, instead of 1', refuses=True, remedy=remedy)
        return
    for rule in (_exchanged, _sign, _without_gravity, _scale, _hand_guided, _springs):
        kind, where, finding, remedy = rule(data, check)
        if where.any():
            yield Notice(kind, finding, names_of(where), refuses=kind != 'springs', remedy=remedy)
            break
    if lag is not None and abs(lag.value - USUAL_LAG) >= max(0.009, 3 * lag.uncertainty):
        yield Notice('velocity_lag', f'velocities lag positions by {1e3 * lag.value:.1f} ± '
                     f'{1e3 * lag.uncertainty:.1f} ms; Baxter has {1e3 * USUAL_LAG:.0f} ms, a '
                     'simulator none',
                     remedy='check the period of the stamps and the source of velocities')


def _exchanged(data: _Data, check: DataCheck) -> _Found:
    """Find efforts that fit the prediction of another joint, or two exchanged joints."""
    cost = _cost(data.measured[:, :, None] - data.predicted[:, None])  # [measured, predicted]
    orders = np.array(list(permutations(_SAME)))
    total = cost[_SAME, orders].sum(1) + _MOVED_COST * (orders != _SAME).sum(1)
    total[(data.constant & (orders != _SAME)).any(1)] = np.inf
    best, exchanged = orders[int(np.argmin(total))], 'efforts'
    bearing = np.nan_to_num(check.correlation[_BEARS_LOAD & data.moves])
    # Efforts with the shape of their own joint's prediction belong to it, whatever their gain.
    if (best == _SAME).all() and not (np.abs(bearing) > 0.7).all():
        best, exchanged = _exchanged_joints(data, float(np.trace(cost))), 'joints'
    where = best != _SAME
    fits = ', '.join(f'{JOINTS[i]} fits {JOINTS[best[i]]}' for i in np.flatnonzero(where))
    return ('joints_exchanged', where, f'{exchanged} of {", ".join(names_of(where))} look '
            f'exchanged ({fits})', 'give each value the name of its joint; the robot publishes '
            'e0 e1 s0 s1 w0 w1 w2')


def _exchanged_joints(data: _Data, cost: float) -> Any:
    """Return the order (7,) with two joints exchanged, if that explains the effort."""
    best, least = _SAME, cost - 4 * _MOVED_COST
    stride = max(len(data.q) // 400, 1)
    motion = np.stack([data.q, data.qd, data.qdd, data.measured])[:, ::stride]
    for pair in combinations(_SAME, 2):
        order = _SAME.copy()
        order[[*pair]] = pair[::-1]
        trial = _Data.of(data.settings, motion[..., order])
        found = float(_cost(trial.measured - trial.predicted).sum())
        if found < least:
            best, least = order, found
    return best


def _cost(errors: Array) -> Array:
    return np.log(errors.var(axis=0) + 1e-4)


def _sign(data: _Data, check: DataCheck) -> _Found:
    negative = data.complete & (check.correlation < -0.6) & (data.predicted.std(0) > 0.3)
    return ('effort_sign', negative, 'measured effort has the opposite sign of the prediction '
            f'(correlation {_numbers(negative, check.correlation)})',
            'negate the effort where it is published or converted')


def _without_gravity(data: _Data, check: DataCheck) -> _Found:
    gravity = check.gravity.median()
    removed = gravity < 0.4 and not check.inertial.median() < 0.4
    joints = check.gravity.known & _BEARS_LOAD & removed
    return ('no_gravity', joints, f'measured effort contains {gravity:.2f} of the gravity torque '
            f'({_numbers(joints, check.gravity.value)}), instead of 1',
            'record the effort with gravity; for a simulator without gravity use a copy of '
            'simulation.yaml with gravity [0.0, 0.0, 0.0]')


def _scale(data: _Data, check: DataCheck) -> _Found:
    bearing = _BEARS_LOAD & data.complete & (data.predicted.std(0) > 0.5)
    bearing &= np.abs(check.correlation) > 0.7
    overall = np.median(check.gain[bearing]) if bearing.any() else 1.0
    is_usual = (check.gain > 0.45) & (check.gain < 2.2) & (0.6 < overall < 1.7)
    odd = bearing & ~is_usual
    return ('effort_scale', odd, 'measured effort is the predicted effort times '
            f'{_numbers(odd, check.gain)}', 'check the unit of the effort; convert it to N m')


def _hand_guided(data: _Data, check: DataCheck) -> _Found:
    inertial = check.inertial.median()
    joints = check.inertial.known & _BEARS_LOAD & (inertial < 0.35)
    negative = joints & (check.coulomb < 0.0)
    friction = (f', and friction is negative ({_numbers(negative, check.coulomb)} N m)'
                if negative.any() else '')
    return ('moved_by_hand', joints, f'measured effort contains {inertial:.2f} of inertial and '
            f'Coriolis torque ({_numbers(joints, check.inertial.value)}), instead of 1{friction}; '
            'the motors did not make this motion', 'an arm moved by hand cannot be calibrated; '
            'record a motion made by the motors, such as that of calibrate --plan')


def _springs(data: _Data, check: DataCheck) -> _Found:
    value = check.spring.value[S1] if check.spring.known[S1] else np.nan
    share = f"measured effort of s1 contains {value:.2f} of the springs' torque, "
    if data.settings.model.effort_model.has_spring:
        return ('no_springs', (_SAME == S1) & (value < 0.4), share + 'instead of 1',
                'for a simulator, which has no springs, use simulation.yaml')
    return ('springs', (_SAME == S1) & (value > 0.6), share + 'which these settings omit',
            'for a real robot enable effort_model')


def event_notices(counts: Mapping[Any, int], recording: str = '') -> Iterator[Notice]:
    """Yield a notice for each event of a stream for which there is a remedy."""
    for event in Event:
        if event.remedy and counts.get(event):
            refuses = event is Event.IMPLAUSIBLE and counts[event] > _FEW * counts['taken']
            words = f"of {counts['received']} joint states are" if refuses else 'x'
            yield Notice(event.value, f'{counts[event]} {words} {event.value}', (), recording,
                         refuses, event.remedy)


def _numbers(where: Bools, values: Array) -> str:
    return ', '.join(f'{JOINTS[i]} {values[i]:.2f}' for i in np.flatnonzero(where))
