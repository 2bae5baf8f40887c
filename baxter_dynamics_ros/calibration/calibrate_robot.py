"""Calibration of a robot from recordings."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from .calibration_results import Calibration, Fitted, Selection
from .fit import best_fit, choose
from .fit_data import (CalibrationError, check_data, distinct, long_enough, Motion, observe,
                       residual, warnings)
from .joint_terms import Term
from .least_squares import Problem
from .terms import all_terms, OPTIONAL, REACH
from ..estimation.settings import BaseSettings, PredictorSettings
from ..model import ArgumentError, Array, EffortModel, JOINTS, rms, S1
from ..recordings.data_check import Notice
from ..recordings.playback import Contact, contact_rows, find_contacts, Lag, MOST_CONTACT
from ..recordings.recording import Recording

_PARTS = 5  # number of folds of a single recording
_SWEEP = 0.85  # share of the spring's range that s1 must sweep for its shape to be fitted
_LAG_OFF = 0.001  # minimum difference for which the measured velocity lag is adopted [s]
_SIGMAS = 3.0  # ... and minimum number of standard errors
_TAIL = 4.0  # degrees of freedom of the residuals' t distribution
_BY_TIME = Notice('by_time', f'one recording: each of its {_PARTS} parts is predicted by a fit to '
                  'the others. A repeated motion makes the result look better than it is: record '
                  'a different motion')


def calibrate(recordings: Sequence[Recording], settings: PredictorSettings | None = None,
              inertial: bool = False, payload: bool = False, only: Collection[str] = (),
              progress: Callable[[str], None] = lambda text: None) -> Calibration:
    """
    Fit the effort model, and optionally links and payload, to recordings of one arm.

    By default every term is fitted that improves the cross-validated residual. Raise
    CalibrationError if the recordings, ArgumentError if the other arguments cannot be used.
    """
    settings = _starting_point(settings or PredictorSettings(), recordings)
    settings, motions, lag, notices = _measured(recordings, settings, progress)
    fold = 'recording'
    if len(motions) == 1:
        fold, motions = 'part', _parts(motions[0])
        notices.append(_BY_TIME)
    s1 = np.concatenate([motion.q[:, S1] for motion in motions])
    low, high = np.quantile(s1, [0.002, 0.998]).tolist()  # without outliers
    asked = {name for name, wish in zip(OPTIONAL, (inertial, payload)) if wish}
    terms, spring = _terms(settings, (low, high), only, asked)
    progress('fitting')
    # Without the tilt, links or payload would absorb it.
    wanted = {'bias', *only, *asked, *(['tilt'] if asked else [])}
    *_, preliminary = choose(Problem(settings, terms, motions), wanted)
    free, contacts, contact = _without_contact(motions, preliminary, fold, wanted)
    problem = Problem(settings, terms, free, _robust(free, preliminary))
    steps, unidentifiable, _ = choose(problem, wanted)
    progress('cross-validating')
    fit, given_up = best_fit(problem, steps[-1:] if only else steps)
    parameters = fit.parameters
    judged = [one if part is motion else one._replace(
                  with_contact=rms(residual(motion, problem.updated(b))))
              for one, part, motion, b in zip(fit.judged, free, motions, fit.left_out)]
    return Calibration(
        settings, fit.settings, parameters, steps[:len(steps) - len(given_up)], judged, fold, lag,
        contacts, (*notices, *spring, *contact, *unidentifiable, *_doubts(parameters, given_up)),
        samples=sum(map(len, free)), s1_range=(low, high))


def _starting_point(given: PredictorSettings,
                    recordings: Sequence[Recording]) -> PredictorSettings:
    """Return the settings of the recorded arm, the tilt of the base expressed in gravity."""
    if not recordings:
        raise CalibrationError('no recordings')
    arm, *others = {recording.arm for recording in recordings}
    if others:
        raise CalibrationError(
            'the recordings are of both arms: calibrate one arm at a time (--arm)')
    if not given.effort_model.enabled:
        raise ArgumentError('effort_model.enabled', 'false, as for a simulator: there is no '
                            'effort model to fit; start from other parameters')
    if not given.align:
        raise ArgumentError('align', 'false: a fit needs effort at the instant of acceleration')
    return replace(given, arm=arm, gravity=tuple(given.model.arm.gravity_vector.tolist()),
                   base=BaseSettings())


def _measured(
        recordings: Sequence[Recording], settings: PredictorSettings,
        progress: Callable[[str], None]
) -> tuple[PredictorSettings, list[Motion], 'Lag | None', list[Notice]]:
    """Return settings with the measured velocity lag, motions, that lag, and notices."""
    def read() -> tuple[list[Motion], list[Notice]]:
        motions = []
        for recording in recordings:
            progress(f'reading {recording.name}')
            motions.append(observe(recording, settings))
        return distinct(motions)

    motions, notices = read()
    check = check_data(motions, settings)
    lag = check.lag
    if lag is not None and abs(lag.value - settings.acceleration.velocity_lag) > max(
            _LAG_OFF, _SIGMAS * lag.uncertainty):
        settings = settings.replace({'acceleration.velocity_lag': round(max(lag.value, 0.0), 4)})
        motions, _ = read()  # with the new delay
    return settings, long_enough(motions), lag, [*notices, *check.problems, *warnings(motions)]


def _parts(motion: Motion) -> list[Motion]:
    """Return the parts of a single motion that are left out in turn."""
    edges = np.linspace(0, len(motion), _PARTS + 1).astype(int)
    return [replace(motion.take(slice(*pair)), name=f'{motion.name}, part {k + 1}')
            for k, pair in enumerate(zip(edges, edges[1:]))]


def sweep(s1_range: tuple[float, float], model: EffortModel) -> tuple[float, float, bool]:
    """Return the range of s1 within its spring's [rad], and whether it covers enough of that."""
    lower, upper = model.spring_range
    low, high = np.clip(s1_range, lower, upper).tolist()
    return low, high, high - low >= _SWEEP * (upper - lower)


def _terms(settings: PredictorSettings, s1_range: tuple[float, float], only: Collection[str],
           asked: Collection[str]) -> tuple[list[Term], list[Notice]]:
    """Return the terms to fit, and a notice if the shape of the spring is not fitted."""
    low, high, shape = sweep(s1_range, settings.effort_model)
    notices = []
    if not shape and (not only or 'spring' in only) and settings.model.effort_model.has_spring:
        lower, upper = settings.effort_model.spring_range
        notices.append(Notice(
            'spring_shape', f"s1 sweeps {low:.2f} to {high:.2f} of the spring's {lower:g} to "
            f'{upper:g} rad: its shape is kept, only gain and offset are fitted', ('s1',)))
    terms = all_terms(settings, shape, constant=shape and 'spring' in only and 'bias' not in only)
    names = {term.name for term in terms}
    for name in only:
        if name not in names:
            raise ArgumentError('only', f'no term {name}; there are {", ".join(sorted(names))}')
    wanted = {*(only or names - {*OPTIONAL}), *asked}
    return [term for term in terms if term.name in wanted], notices


def _without_contact(motions: list[Motion], settings: PredictorSettings, fold: str,
                     wanted: Collection[str]) -> tuple[list[Motion], list[Contact], list[Notice]]:
    """Return motions without contact, the contacts unless they are too many, and a notice."""
    found = [find_contacts(motion.time, residual(motion, settings), motion.q,
                           motion.name if fold == 'recording' else '') for motion in motions]
    contacts = sum(found, [])
    if not contacts:
        return motions, [], []
    free = [motion.take(~contact_rows(motion.time, own)) if own else motion
            for motion, own in zip(motions, found)]
    left = sum(map(len, free)) / sum(map(len, motions))
    joints = tuple(sorted({contact.joint for contact in contacts}, key=JOINTS.index))
    if left < 1.0 - MOST_CONTACT or not all(motion.duration > 0.0 for motion in free):
        return motions, [], [Notice(
            'large_residual', f'the residual at {", ".join(joints)} is too large for the model '
            f'during {100 * (1 - left):.0f} % of the time: too much to be left out as contact'
            + ('' if 'payload' in wanted else '. Does the hand carry a load (--payload)?'),
            joints)]
    return free, contacts, [Notice('contact', 'contact is left out of the fit: '
                                   + '; '.join(map(str, contacts)), joints)]


def _robust(motions: list[Motion], settings: PredictorSettings) -> list[Array]:
    """
    Return weights of the residuals (n, 7) of the motions, so that a short touch hardly matters.

    They are those of a t distribution: one half at two deviations.
    """
    residuals = [residual(motion, settings) for motion in motions]
    scale = np.maximum(1.4826 * np.median(np.abs(np.concatenate(residuals)), axis=0), 1e-9)
    return [1.0 / (1.0 + (left / scale) ** 2 / _TAIL) for left in residuals]


def _doubts(parameters: list[Fitted], given_up: Sequence[Selection]) -> Iterator[Notice]:
    """Yield notices about terms that did not predict better, and a payload out of reach."""
    terms = ', '.join(step.term for step in given_up if step.joints)
    if terms:
        yield Notice('given_up', f'left-out data are predicted worse with {terms} than without: '
                     'the result is that of the step before')
    if any(one.term == 'payload' and one.component.startswith('center')
           and abs(one.value) >= REACH for one in parameters):
        yield Notice('payload_center', 'payload: the motion does not determine its centre of '
                     'mass: do not use it, record a wider motion (--plan writes one)')
