"""Calibration of a robot from recordings."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np

from .body_terms import REACH
from .calibration_results import Calibration
from .checks import check_data, distinct, long_enough, one_arm, refuse, warnings
from .fit import best_fit, choose, Fit
from .fit_data import Motion, observe, residual, rms
from .noise import robust_weights
from .normal import pose
from .term import Term
from .terms import all_terms, OPTIONAL
from ..estimation.settings import BaseSettings, EffortModelSettings, PredictorSettings
from ..model.exceptions import ArgumentError
from ..model.joints import JOINTS, S1
from ..recordings.contact_intervals import Contact, contact_rows, find_contacts, MOST
from ..recordings.notices import Notice
from ..recordings.recording import Recording
from ..recordings.velocity_lag import Lag

PARTS = 5  # number of folds of a single recording
SWEEP = 0.85  # share of the spring's range that s1 must sweep for its shape to be fitted
_LAG_OFF = 0.001  # minimum difference for which the measured velocity lag is adopted [s]
_SIGMAS = 3.0  # ... and minimum number of standard errors


def calibrate(recordings: Sequence[Recording], settings: PredictorSettings | None = None,
              inertial: bool = False, payload: bool = False, only: Collection[str] = (),
              progress: Callable[[str], None] = lambda text: None) -> Calibration:
    """
    Fit the effort model, and optionally links and payload, to recordings of one arm.

    Parameters
    ----------
    recordings : list of Recording
        Recordings of one arm; each must be readable more than once.
    settings : PredictorSettings, optional
        Initial settings, such as an earlier calibration; the defaults if omitted.
    inertial, payload : bool
        Whether to fit the inertial parameters of the links, and the payload.
    only : collection of str
        Names of the terms to fit unconditionally. By default every term is fitted that improves
        the cross-validated residual.
    progress : callable, optional
        Called with a description of each stage.

    Raises
    ------
    CalibrationError
        If the recordings cannot be used, with the reason.
    ArgumentError
        If the settings have no effort model to fit, or a term does not exist.

    """
    settings = _starting_point(settings or PredictorSettings(), one_arm(recordings))
    asked = {name for name, wish in zip(OPTIONAL, (inertial, payload)) if wish}
    motions, notices = distinct(_observed(recordings, settings, progress))
    refuse(motions)
    check = check_data(long_enough(motions), settings)
    lag = None if check is None else check.lag
    if check is not None:
        notices += check.problems
    if lag is not None and _is_off(lag, settings.acceleration.velocity_lag):
        settings = replace(settings, acceleration=replace(
            settings.acceleration, velocity_lag=round(max(lag.value, 0.0), 4)))
        motions, _ = distinct(_observed(recordings, settings, progress))  # new delay
    notices += warnings(motions)
    motions = long_enough(motions)
    by_time = len(motions) == 1
    if by_time:
        motions = _split(motions[0])
        notices.append(Notice('by_time', f'one recording: judged on each of {PARTS} parts of it, '
                              'fitted to the others. A motion that repeats lap after lap makes '
                              'this look better than it is: record another'))
    sweep = _sweep(motions)
    terms = _terms(settings, sweep, only, asked, notices)
    progress('fitting')
    # Without the tilt, links or payload would absorb it.
    wanted = {'bias', *only, *asked, *(['tilt'] if asked else [])}
    choice = choose(pose(settings, terms, motions), wanted)  # finds contact and outliers
    contacts = [contact for motion in motions for contact in find_contacts(
        motion.time, residual(motion, choice.settings), motion.q, motion.name)]
    free = _without(contacts, motions, notices)
    weights = robust_weights([residual(motion, choice.settings) for motion in free])
    problem = pose(settings, terms, [
        replace(motion, weight=weight) for motion, weight in zip(free, weights)])
    choice = choose(problem, wanted)
    progress('judging on what was left out')
    fit, last = best_fit(problem, choice.steps)
    notices += _doubts(fit, choice.unidentifiable, [
        step.term for step in choice.steps[last + 1:] if step.joints])
    judged = [one if len(part) == len(motion) else replace(
                  one, with_contact=rms(residual(motion, problem.updated(b))))
              for one, part, motion, b in zip(fit.judged, free, motions, fit.left_out)]
    return Calibration(
        arm=settings.arm, before=settings, after=fit.settings, parameters=fit.parameters,
        steps=choice.steps[:last + 1], judged=judged, by_time=by_time, lag=lag, check=check,
        contacts=[] if free is motions else contacts, notices=tuple(notices),
        samples=sum(map(len, free)), duration=sum(motion.duration for motion in free),
        s1_range=sweep)


def _starting_point(given: PredictorSettings, arm: str) -> PredictorSettings:
    """Return the settings with the tilt of the base expressed in gravity."""
    if not given.effort_model.enabled:
        raise ArgumentError('effort_model.enabled', 'false, as beside a simulator: there is no '
                            'effort model to fit; begin with other parameters')
    if not given.align:
        raise ArgumentError('align', 'false: a fit needs effort and acceleration of one instant')
    return replace(given, arm=arm, gravity=tuple(given.model.arm.gravity_vector.tolist()),
                   base=BaseSettings())


def _observed(recordings: Iterable[Recording], settings: PredictorSettings,
              progress: Callable[[str], None]) -> list[Motion]:
    motions = []
    for recording in recordings:
        progress(f'reading {recording.name}')
        motions.append(observe(recording, settings))
    return motions


def _is_off(lag: Lag, setting: float) -> bool:
    """Return whether the measured lag differs significantly from the setting [s]."""
    return abs(lag.value - setting) > max(_LAG_OFF, _SIGMAS * lag.uncertainty)


def _split(motion: Motion) -> list[Motion]:
    edges = np.linspace(0, len(motion), PARTS + 1).astype(int)
    return [motion.take(slice(*pair), f'{motion.name}, part {k + 1}')
            for k, pair in enumerate(zip(edges, edges[1:]))]


def _sweep(motions: list[Motion]) -> tuple[float, float]:
    """Return the range of s1 without outliers [rad]."""
    s1 = np.concatenate([motion.q[:, S1] for motion in motions])
    return tuple(np.quantile(s1, [0.002, 0.998]).tolist())


def sweeps(low: float, high: float, model: EffortModelSettings) -> bool:
    """Return whether the range of s1 [rad] covers enough of the spring's range."""
    lower, upper = model.spring_range
    low, high = np.clip([low, high], lower, upper)
    return bool(high - low >= SWEEP * (upper - lower))


def _terms(settings: PredictorSettings, sweep: tuple[float, float], only: Collection[str],
           asked: Collection[str], notices: list[Notice]) -> list[Term]:
    """Return the terms to fit; add a notice if the shape of the spring is not fitted."""
    shape = sweeps(*sweep, settings.effort_model)
    if not shape and (not only or 'spring' in only) and settings.model.effort_model.has_spring:
        lower, upper = settings.effort_model.spring_range
        low, high = np.clip(sweep, lower, upper)
        notices.append(Notice(
            'spring_shape', f"s1 sweeps {low:.2f} to {high:.2f} of the spring's {lower:g} to "
            f'{upper:g} rad: its shape is kept, only gain and offset can be fitted', ('s1',)))
    terms = all_terms(settings, shape, constant=shape and 'spring' in only and 'bias' not in only)
    names = {term.name for term in terms}
    for name in only:
        if name not in names:
            raise ArgumentError('only', f'no term {name}; there are {", ".join(sorted(names))}')
    wanted = {*(only or names - {*OPTIONAL}), *asked}
    return [term for term in terms if term.name in wanted]


def _without(contacts: list[Contact], motions: list[Motion],
             notices: list[Notice]) -> list[Motion]:
    """Return the motions without contact, or unchanged if too much looks like contact."""
    if not contacts:
        return motions
    free = []
    for motion in motions:
        own = [contact for contact in contacts if contact.recording == motion.name]
        free.append(motion.take(~contact_rows(motion.time, own)) if own else motion)
    left = sum(map(len, free)) / sum(map(len, motions))
    joints = tuple(sorted({contact.joint for contact in contacts}, key=JOINTS.index))
    if left < 1.0 - MOST or not all(motion.duration > 0.0 for motion in free):
        notices.append(Notice(
            'large_residual', f'the residual at {", ".join(joints)} is too large for the model '
            f'during {100 * (1 - left):.0f} % of the time: too much to be left out as contact. '
            'Does the hand carry a load (--payload)?', joints))
        return motions
    notices.append(Notice('contact', 'contact is left out of the fit: '
                          + '; '.join(map(str, contacts)), joints))
    return free


def _doubts(fit: Fit, unidentifiable: dict[int, list[str]],
            given_up: list[str]) -> Iterable[Notice]:
    """Yield notices about what could not be fitted, and terms that did not predict better."""
    for joint, names in unidentifiable.items():
        yield Notice('unidentifiable', f'{JOINTS[joint]}: the motion does not show '
                     f'{", ".join(names)}: as before', (JOINTS[joint],))
    if given_up:
        yield Notice('given_up', f'with {", ".join(given_up)} what was left out is predicted '
                     'worse than without: the result is the step before')
    if any(one.term == 'payload' and one.component.startswith('center')
           and abs(one.value) >= REACH for one in fit.parameters):
        yield Notice('payload_center', 'payload: the motion does not show its centre of mass: '
                     "don't use it, record a wider motion (--plan shows one)")
