"""
Explanation of the residual of the last ten seconds, with a test of significance.

Linear models compete: a payload at the hand, an offset of a joint, friction of the joints, a
tilted base. The evidence of a model follows from Gaussian priors of its values and from noise with
the expected deviation. Model errors repeat in the same posture, so samples count as independent
only when the arm has moved.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from .predictor import Prediction
from ..model.arm import BaxterArm
from ..model.arrays import Array, Bools
from ..model.base_parameters import fixed_to_link
from ..model.effort import EffortModel
from ..model.joints import JOINTS, N_JOINTS, POSITION_LOWER, POSITION_UPPER
from ..model.paper_tables import GRAVITY

WINDOW = 10.0  # duration of the residuals explained together [s]
# Bounds of the residual's standard deviation: uncalibrated without s1's offset, and ideal [N m].
UNCALIBRATED = np.array([1.1, 2.0, 1.5, 1.1, 0.4, 0.6, 0.3])
SMALLEST = 0.05 * UNCALIBRATED

_PERIOD = 0.1  # between two samples [s]
_LEAST = 20  # samples needed
_MOVED = 0.25  # change of a joint after which a sample counts as independent [rad]
_ODDS = 5.0  # logarithm of the odds against a model without the term
_SIGNIFICANT = 3.3  # standard deviations
_SHARE = 0.7  # of the squared residual that an explanation must account for
_STOP = 0.05  # distance from a joint's limit at which it may be at its stop [rad]
_REACH = 0.3  # largest coordinate of a payload's centre in the hand frame [m]
_CENTER = 0.1  # standard deviation of the prior of each coordinate [m]
_KINDS = {'payload': range(4), 'tilt': range(4, 6), 'friction': range(6, 13)}
_OFFSET = 13  # column of the offset of s0
# Standard deviations of the priors: first moment [kg m] and mass [kg], horizontal gravity
# [m/s^2], friction and offset [N m].
_PRIOR = np.repeat([0.05, 2.0, 0.5, 3.0, 30.0], [3, 1, 2, N_JOINTS, N_JOINTS])


class Explanation(NamedTuple):
    """Statement about the residual."""

    kind: str  # payload, offset, friction, tilt, joint_stop, none or unexplained
    joint: 'str | None'
    values: tuple[float, ...]  # mass [kg]; torque [N m]; tilt [deg]
    deviations: tuple[float, ...]  # their standard deviations
    text: str  # one sentence


class PayloadEstimate(NamedTuple):
    """Body at the hand, in addition to the payload of the model."""

    mass: float  # [kg]
    center_of_mass: Array  # (3,) in the hand frame [m]
    mass_deviation: float
    center_deviation: Array  # (3,)


class Explained(NamedTuple):
    """Result of one explanation."""

    sentence: Explanation
    payload: 'PayloadEstimate | None' = None  # only if observable and significant


_TOO_FEW = Explained(Explanation('none', None, (), (), 'too few residuals yet'))
_WITHIN = Explained(Explanation('none', None, (), (), 'residual is within the expected deviation'))
_UNEXPLAINED = Explained(Explanation('unexplained', None, (), (), 'residual is not explained'))


class _Sample(NamedTuple):
    stamp_ns: int
    contact: bool
    q: Array  # (7,) [rad]
    residual: Array  # (7,) [N m]
    deviation: Array  # (7,) expected [N m]
    columns: Array  # (7, 20) residual for a unit of each value


class _Fit(NamedTuple):
    columns: list[int]
    evidence: float  # logarithm, up to a constant
    square: float  # remaining weighted square of the residual
    values: Array
    covariance: Array


class ResidualExplainer:
    """
    Explains the residuals of the last ten seconds.

    Samples with contact are used only if there are too few without: a heavy payload is reported
    as contact until the model includes it.

    Parameters
    ----------
    arm : BaxterArm
        Rigid-body model.
    effort_model : EffortModel
        Effort model; its deviation is the expected size of the residual.

    """

    def __init__(self, arm: BaxterArm, effort_model: EffortModel) -> None:
        self._samples: deque[_Sample] = deque()
        self.configure(arm, effort_model)

    def configure(self, arm: BaxterArm, effort_model: EffortModel) -> None:
        """Change the model and forget the residuals of the old one."""
        self._arm, self._effort_model = arm, effort_model
        units = np.zeros((4, 4, 4))  # first moments x, y, z [kg m] and mass [kg]
        for i, unit in enumerate(units):
            unit[i, 3] = unit[3, i] = 1.0
        self._units = fixed_to_link(arm.parameters, N_JOINTS - 1, units).T
        self._horizontal = [
            BaxterArm(payload=arm.payload, gravity=axis, mount=arm.mount,
                      parameters=arm.parameters) for axis in np.eye(3)[:2]]
        self.reset()

    def reset(self) -> None:
        """Forget all residuals."""
        self._samples.clear()

    def add(self, prediction: Prediction, contact: 'bool | None' = None) -> None:
        """Add a prediction with its residual; about ten per second are used."""
        stamp, samples = prediction.stamp_ns, self._samples
        if samples and stamp < samples[-1].stamp_ns:
            samples.clear()
        if prediction.residual is None or (
                samples and stamp - samples[-1].stamp_ns < _PERIOD * 1e9):
            return
        q, qd, qdd, model = prediction.q, prediction.qd, prediction.qdd, self._effort_model
        regressor = self._arm.regressor(q, qd, qdd)
        torques = [*(regressor @ self._units[:regressor.shape[1]]).T,
                   *(arm.gravity(q) for arm in self._horizontal),
                   *np.diag(np.tanh(qd / model.coulomb_velocity)), *np.eye(N_JOINTS)]
        expected = prediction.deviation
        deviation = np.clip(np.where(expected > 0.0, expected, np.inf), SMALLEST, UNCALIBRATED)
        samples.append(_Sample(stamp, bool(contact), q, prediction.residual, deviation,
                               model.coupled(np.array(torques)).T))
        while stamp - samples[0].stamp_ns > WINDOW * 1e9:
            samples.popleft()

    def explain(self) -> Explained:
        """Return what explains the residuals of the last ten seconds."""
        samples = [sample for sample in self._samples if not sample.contact]
        if len(samples) < _LEAST:
            samples = list(self._samples)
        if len(samples) < _LEAST:
            return _TOO_FEW
        return _joint_stop(samples[-_LEAST // 2:]) or self._compare(_Problem(samples))

    def _compare(self, problem: '_Problem') -> Explained:
        """Add the terms with the most evidence, one after the other."""
        terms = problem.terms()
        names: list[str] = []
        best = problem.fit([])
        while len(names) < 3:
            fits = {name: problem.fit(best.columns + columns) for name, columns in terms.items()
                    if name not in names}
            name = max(fits, key=lambda each: fits[each].evidence)
            if fits[name].evidence < best.evidence + _ODDS:
                break
            names.append(name)
            best = fits[name]
        if not names:
            return _UNEXPLAINED if problem.is_significant(problem.square) else _WITHIN
        best = problem.fit(best.columns, _prior_of(best))
        if problem.is_significant(best.square):
            if best.square > (1.0 - _SHARE) * problem.square:
                return _UNEXPLAINED
            misfit = best.square / (N_JOINTS * problem.independent)
            best = best._replace(covariance=best.covariance * misfit)
        others = [problem.fit([column for other in names if other != name
                               for column in terms[other]]).evidence for name in names]
        main = names[int(np.argmin(others))]
        payload = self._payload(best) if main == 'payload' else None
        if main == 'payload' and payload is None:
            return _UNEXPLAINED
        return Explained(self._sentence(main, best, payload), payload)

    def _payload(self, fit: _Fit) -> 'PayloadEstimate | None':
        at = [fit.columns.index(column) for column in range(4)]
        *moment, mass = fit.values[at]
        covariance = fit.covariance[np.ix_(at, at)]
        deviation = float(np.sqrt(covariance[3, 3]))
        center = np.array(moment) / mass
        if abs(mass) < _SIGNIFICANT * deviation or mass < -self._arm.payload.mass:
            return None
        gradient = np.column_stack([np.eye(3), -center]) / mass
        spread = np.sqrt(np.diag(gradient @ covariance @ gradient.T))
        if (np.abs(center) > _REACH + 2.0 * spread).any():
            return None
        return PayloadEstimate(float(mass), center, deviation, spread)

    def _sentence(self, name: str, fit: _Fit, payload: 'PayloadEstimate | None') -> Explanation:
        if payload is not None:
            mass, sd = payload.mass, payload.mass_deviation
            what = '' if mass > 0.0 else 'a payload lighter by '
            return Explanation('payload', None, (mass,), (sd,), f'residual is what {what}'
                               f'{abs(mass):.2f} ± {sd:.2f} kg at the hand would cause')
        kind, _, joint = name.partition(' ')
        columns = [i for i, column in enumerate(fit.columns) if column in _columns(name)]
        values, deviations = fit.values[columns], np.sqrt(np.diag(fit.covariance))[columns]
        if kind == 'tilt':
            angle, sd = np.degrees(np.array([np.linalg.norm(values), deviations.max()])
                                   / np.abs(GRAVITY[2])).tolist()
            return Explanation(kind, None, (angle,), (sd,),
                               f'gravity appears tilted by {angle:.1f} ± {sd:.1f} degrees')
        most = int(np.argmax(np.abs(values) / deviations))
        value, sd = float(values[most]), float(deviations[most])
        size = f'{value:.2f} ± {sd:.2f} N m'
        if kind == 'friction':
            joint = JOINTS[fit.columns[columns[most]] - _KINDS['friction'].start]
            text = (f'residual of {joint} follows the sign of velocity ({size}): friction is not '
                    'calibrated')
        else:
            zero = "the spring's zero" if joint == 's1' else 'its zero'
            text = f'constant offset of {size} at {joint}: {zero} is not calibrated'
        return Explanation(kind, joint, (value,), (sd,), text)


class _Problem:
    """Weighted linear regression of the residuals on the columns of all terms."""

    def __init__(self, samples: list[_Sample]) -> None:
        self.independent = _independent(np.array([sample.q for sample in samples]))
        deviation = np.array([sample.deviation for sample in samples])
        scale = np.sqrt(self.independent / len(samples)) / deviation
        x = scale[..., None] * np.array([sample.columns for sample in samples])
        y = scale * np.array([sample.residual for sample in samples])
        self._matrix = np.einsum('nij,nik->jk', x, x)
        self._vector = np.einsum('nij,ni->j', x, y)
        self.square = float((y * y).sum())
        sliding = np.array([np.diag(sample.columns[:, 6:13]) for sample in samples])
        self._reverses: Bools = ((sliding > 0.5).mean(0) > 0.1) & ((sliding < -0.5).mean(0) > 0.1)

    def terms(self) -> dict[str, list[int]]:
        """Return the terms that the motion can show: name -> columns."""
        result = {kind: _columns(kind) for kind in ('payload', 'tilt')}
        friction = [column for column, shown in zip(_columns('friction'), self._reverses) if shown]
        if friction:
            result['friction'] = friction
        return result | {f'offset {joint}': _columns(f'offset {joint}') for joint in JOINTS}

    def fit(self, columns: list[int], prior: Array = _PRIOR) -> _Fit:
        """Return the most probable values of some columns."""
        precision = 1.0 / prior[columns] ** 2
        total = self._matrix[np.ix_(columns, columns)] + np.diag(precision)
        covariance = np.linalg.inv(total)
        values = covariance @ self._vector[columns]
        square = self.square - float(self._vector[columns] @ values)
        occam = np.linalg.slogdet(total)[1] - np.log(precision).sum()
        return _Fit(columns, -0.5 * (square + float(occam)), square, values, covariance)

    def is_significant(self, square: float) -> bool:
        """Return whether a weighted square exceeds what 99 % of free motion shows."""
        n = N_JOINTS * self.independent
        return square > n * (1.0 - 2.0 / (9.0 * n) + 2.33 * np.sqrt(2.0 / (9.0 * n))) ** 3


def _prior_of(fit: _Fit) -> Array:
    """Return the prior with first moments that fit the mass that was found."""
    prior = _PRIOR.copy()
    mass = dict(zip(fit.columns, fit.values)).get(3, 0.0)
    prior[:3] = np.minimum(prior[:3], _CENTER * max(abs(mass), _CENTER))
    return prior


def _columns(name: str) -> list[int]:
    kind, _, joint = name.partition(' ')
    return [_OFFSET + JOINTS.index(joint)] if joint else list(_KINDS[kind])


def _independent(q: Array) -> int:
    """Return the number of samples that count as independent."""
    count, last = 1, q[0]
    for row in q:
        if np.abs(row - last).max() > _MOVED:
            count, last = count + 1, row
    return count


def _joint_stop(samples: list[_Sample]) -> 'Explained | None':
    """Return the joint that presses on its stop, if one does."""
    q, residual, deviation = np.mean([sample[2:5] for sample in samples], axis=0)
    # The motor presses towards the stop, beyond what the model needs.
    pressing = np.where(q > POSITION_UPPER - _STOP, residual, 0.0) - np.where(
        q < POSITION_LOWER + _STOP, residual, 0.0)
    joint = int(np.argmax(pressing / deviation))
    torque, sd = float(pressing[joint]), float(deviation[joint])
    if torque < _SIGNIFICANT * sd:
        return None
    text = (f'{JOINTS[joint]} is at its joint stop and presses on it with {torque:.1f} ± {sd:.1f} '
            'N m')
    return Explained(Explanation('joint_stop', JOINTS[joint], (torque,), (sd,), text))
