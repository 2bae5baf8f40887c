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
from ..model import Array, BaxterArm, EffortModel, JOINTS, N_JOINTS
from ..model.arm import with_gravity
from ..model.base_parameters import fixed_to_link
from ..model.joints import stops
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
_REACH = 0.3  # largest coordinate of a payload's centre in the hand frame [m]
_CENTER = 0.1  # standard deviation of the prior of each coordinate [m]
_FRICTION = range(6, 13)  # columns
# Columns of each term: first moment [kg m] and mass [kg] of a payload, horizontal gravity [m/s^2],
# friction of the joints and offsets [N m].
_TERMS = {'payload': [0, 1, 2, 3], 'tilt': [4, 5], 'friction': [*_FRICTION],
          **{f'offset {joint}': [13 + i] for i, joint in enumerate(JOINTS)}}
_PRIOR = np.repeat([0.05, 2.0, 0.5, 3.0, 30.0], [3, 1, 2, N_JOINTS, N_JOINTS])  # deviations


class PayloadEstimate(NamedTuple):
    """Body at the hand, in addition to the payload of the model."""

    mass: float  # [kg]
    center_of_mass: Array  # (3,) in the hand frame [m]
    mass_deviation: float
    center_deviation: Array  # (3,)


class Explained(NamedTuple):
    """Statement about the residual."""

    kind: str  # payload, offset, friction, tilt, joint_stop, none or unexplained
    text: str  # one sentence
    joint: 'str | None' = None
    value: 'float | None' = None  # mass [kg], torque [N m] or tilt [deg]
    deviation: 'float | None' = None  # standard deviation of the value
    payload: 'PayloadEstimate | None' = None  # only if observable and significant


_TOO_FEW = Explained('none', 'too few residuals in the last ten seconds')
_WITHIN = Explained('none', 'residual is within the expected deviation')
_UNEXPLAINED = Explained('unexplained', 'residual is not explained')


class _ExplainedSample(NamedTuple):
    stamp_ns: int
    contact: bool
    q: Array  # (7,) [rad]
    residual: Array  # (7,) [N m]
    deviation: Array  # (7,) expected [N m]
    columns: Array  # (7, 20) residual for a unit of each value


class ResidualExplainer:
    """
    Explains the residuals of the last ten seconds.

    Samples with contact are used only if there are too few without: a heavy payload is reported
    as contact until the model includes it.
    """

    def __init__(self, arm: BaxterArm, effort_model: EffortModel) -> None:
        self._samples: deque[_ExplainedSample] = deque()
        self.configure(arm, effort_model)

    def configure(self, arm: BaxterArm, effort_model: EffortModel) -> None:
        """Change the model and forget the residuals of the old one."""
        self._arm, self._effort_model = arm, effort_model
        units = np.zeros((4, 4, 4))  # first moments x, y, z [kg m] and mass [kg]
        for i, unit in enumerate(units):
            unit[i, 3] = unit[3, i] = 1.0
        self._units = fixed_to_link(arm.parameters, N_JOINTS - 1, units).T
        self._horizontal = [with_gravity(arm, axis) for axis in np.eye(3)[:2]]
        self.reset()

    def reset(self) -> None:
        """Forget all residuals."""
        self._samples.clear()

    def add(self, prediction: Prediction, contact: 'bool | None' = None) -> None:
        """Add a prediction; about ten per second are used, if they have a residual."""
        stamp, samples = prediction.stamp_ns, self._samples
        if samples and stamp < samples[-1].stamp_ns:
            samples.clear()
        if samples and stamp - samples[-1].stamp_ns < _PERIOD * 1e9:
            return
        while samples and stamp - samples[0].stamp_ns > WINDOW * 1e9:
            samples.popleft()
        if prediction.residual is None:
            return
        q, qd, qdd, model = prediction.q, prediction.qd, prediction.qdd, self._effort_model
        regressor = self._arm.regressor(q, qd, qdd)
        torques = [*(regressor @ self._units[:regressor.shape[1]]).T,
                   *(arm.gravity(q) for arm in self._horizontal),
                   *np.diag(np.tanh(qd / model.coulomb_velocity)), *np.eye(N_JOINTS)]
        expected = prediction.deviation
        deviation = np.clip(np.where(expected > 0.0, expected, np.inf), SMALLEST, UNCALIBRATED)
        samples.append(_ExplainedSample(stamp, bool(contact), q, prediction.residual, deviation,
                                        model.coupled(np.array(torques)).T))

    def explain(self) -> Explained:
        """Return an explanation of the residuals of the last ten seconds."""
        samples = [sample for sample in self._samples if not sample.contact]
        if len(samples) < _LEAST:
            samples = list(self._samples)
        if len(samples) < _LEAST:
            return _TOO_FEW
        found = (_joint_stop(samples[-_LEAST // 2:])
                 or _compare(_Regression(samples), self._arm.payload.mass))
        left_out = ' (contact left out)' * (len(samples) < len(self._samples))
        return found._replace(text=found.text + left_out)


class _Fit(NamedTuple):
    columns: list[int]
    evidence: float  # logarithm, up to a constant
    square: float  # remaining weighted square of the residual
    values: Array  # (20,), zero except in the columns
    covariance: Array  # (20, 20)


class _Regression:
    """Weighted linear regression of the residuals on the columns of all terms."""

    def __init__(self, samples: list[_ExplainedSample]) -> None:
        self.independent, last = 1, samples[0].q  # number of samples that count
        for sample in samples:
            if np.abs(sample.q - last).max() > _MOVED:
                self.independent, last = self.independent + 1, sample.q
        deviation = np.array([sample.deviation for sample in samples])
        columns = np.array([sample.columns for sample in samples])
        scale = np.sqrt(self.independent / len(samples)) / deviation
        x = scale[..., None] * columns
        y = scale * np.array([sample.residual for sample in samples])
        self._matrix = np.einsum('nij,nik->jk', x, x)
        self._vector = np.einsum('nij,ni->j', x, y)
        self.square = float((y * y).sum())
        sliding = np.diagonal(columns[..., _FRICTION], axis1=1, axis2=2)
        reverses = ((sliding > 0.5).mean(0) > 0.1) & ((sliding < -0.5).mean(0) > 0.1)
        # The terms that the motion can show: friction is shown by joints that reverse.
        self.terms = {**_TERMS, 'friction': [_FRICTION[i] for i in np.flatnonzero(reverses)]}
        if not reverses.any():
            del self.terms['friction']

    def fit(self, columns: list[int], prior: Array = _PRIOR) -> _Fit:
        """Return the most probable values of some columns."""
        precision, part = 1.0 / prior[columns] ** 2, np.ix_(columns, columns)
        total = self._matrix[part] + np.diag(precision)
        values, covariance = np.zeros(_PRIOR.shape), np.zeros(self._matrix.shape)
        covariance[part] = np.linalg.inv(total)
        values[columns] = covariance[part] @ self._vector[columns]
        square = self.square - float(self._vector @ values)
        occam = float(np.linalg.slogdet(total)[1] - np.log(precision).sum())
        return _Fit(columns, -0.5 * (square + occam), square, values, covariance)

    def is_significant(self, square: float) -> bool:
        """Return whether a weighted square exceeds that of 99 % of free motion."""
        n = N_JOINTS * self.independent
        return square > n * (1.0 - 2.0 / (9.0 * n) + 2.33 * np.sqrt(2.0 / (9.0 * n))) ** 3


def _compare(problem: _Regression, payload_mass: float) -> Explained:
    """Add the terms with the most evidence, one after the other; return the one needed most."""
    names: list[str] = []
    best = problem.fit([])
    while len(names) < 3:
        fits = {name: problem.fit(best.columns + columns)
                for name, columns in problem.terms.items() if name not in names}
        name = max(fits, key=lambda each: fits[each].evidence)
        if fits[name].evidence < best.evidence + _ODDS:
            break
        names.append(name)
        best = fits[name]
    if not names:
        return _UNEXPLAINED if problem.is_significant(problem.square) else _WITHIN
    prior = _PRIOR.copy()  # with first moments that fit the mass that was found
    prior[:3] = np.minimum(prior[:3], _CENTER * max(abs(best.values[3]), _CENTER))
    best = problem.fit(best.columns, prior)
    if problem.is_significant(best.square):
        if best.square > (1.0 - _SHARE) * problem.square:
            return _UNEXPLAINED
        misfit = best.square / (N_JOINTS * problem.independent)
        best = best._replace(covariance=best.covariance * misfit)
    others = [problem.fit([column for other in names if other != name
                           for column in problem.terms[other]]).evidence for name in names]
    main = names[int(np.argmin(others))]
    if main == 'payload':
        return _payload(best, payload_mass)
    return _statement(main, best, problem.terms[main])


def _payload(fit: _Fit, payload_mass: float) -> Explained:
    """Return the payload of a fit if it is significant and possible beside the model's [kg]."""
    mass, covariance = float(fit.values[3]), fit.covariance[:4, :4]
    sd = float(np.sqrt(covariance[3, 3]))
    center = fit.values[:3] / mass
    if abs(mass) < _SIGNIFICANT * sd or mass < -payload_mass:
        return _UNEXPLAINED
    gradient = np.column_stack([np.eye(3), -center]) / mass
    spread = np.sqrt(np.diag(gradient @ covariance @ gradient.T))
    if (np.abs(center) > _REACH + 2.0 * spread).any():
        return _UNEXPLAINED
    change = '' if mass > 0.0 else 'a payload lighter by '
    text = f'residual is consistent with {change}{abs(mass):.2f} ± {sd:.2f} kg at the hand'
    return Explained('payload', text, None, mass, sd, PayloadEstimate(mass, center, sd, spread))


def _statement(name: str, fit: _Fit, columns: list[int]) -> Explained:
    kind, _, joint = name.partition(' ')
    values, deviations = fit.values[columns], np.sqrt(np.diag(fit.covariance))[columns]
    if kind == 'tilt':
        angle, sd = np.degrees(np.array([np.linalg.norm(values), deviations.max()])
                               / np.abs(GRAVITY[2])).tolist()
        text = f'gravity appears tilted by {angle:.1f} ± {sd:.1f} degrees'
        return Explained(kind, text, None, angle, sd)
    most = int(np.argmax(np.abs(values) / deviations))
    value, sd = float(values[most]), float(deviations[most])
    size = f'{value:.2f} ± {sd:.2f} N m'
    if kind == 'friction':
        joint = JOINTS[columns[most] - _FRICTION.start]
        text = (f'residual of {joint} follows the sign of velocity ({size}): friction is not '
                'calibrated')
    else:
        zero = "the spring's zero" if joint == 's1' else 'its zero'
        text = f'constant offset of {size} at {joint}: {zero} is not calibrated'
    return Explained(kind, text, joint, value, sd)


def _joint_stop(samples: list[_ExplainedSample]) -> 'Explained | None':
    """Return the joint that presses on its stop, if one does."""
    q, residual, deviation = np.mean([sample[2:5] for sample in samples], axis=0)
    pressing = stops(q) * residual  # the motor presses towards the stop
    i = int(np.argmax(pressing / deviation))
    joint, torque, sd = JOINTS[i], float(pressing[i]), float(deviation[i])
    if torque < _SIGNIFICANT * sd:
        return None
    text = f'{joint} is at its joint stop and presses on it with {torque:.1f} ± {sd:.1f} N m'
    return Explained('joint_stop', text, joint, torque, sd)
