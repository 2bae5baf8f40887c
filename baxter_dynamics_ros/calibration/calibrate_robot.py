"""From recordings to the settings of one's own robot."""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

import numpy as np

from .body_terms import REACH
from .calibration_results import Calibration
from .checks import long_enough, one_arm, refuse, warnings
from .fit import Fit
from .fit_data import Motion, observe
from .lag import velocity_lag
from .term import Term
from .terms import all_terms, OPTIONAL
from ..estimation.settings import PredictorSettings
from ..model.exceptions import ArgumentError
from ..model.joints import S1
from ..recordings.playback import Recording

PARTS = 5  # into which a single recording is split
_LAG_OFF = 0.001  # a velocity lag that differs by more [s] is taken over
_SWEEP = 0.85  # share of the spring's range that s1 must sweep for its shape to be fitted


def calibrate(recordings: Sequence[Recording], values: dict[str, Any] | None = None,
              inertial: bool = False, payload: bool = False, only: Collection[str] = (),
              progress: Callable[[str], None] | None = None) -> Calibration:
    """
    Fit the effort model, and what else is asked for, to recordings of one arm.

    Parameters
    ----------
    recordings : list of Recording
        Each can be read more than once.
    values : dict, optional
        Settings to begin with: the package's defaults, or an earlier calibration.
    inertial, payload : bool
        Whether to fit the links' inertial parameters, and what the hand carries.
    only : collection of str
        Names of the terms to fit, whatever they buy; by default all, where they pay.
    progress : callable, optional
        Called with what is being done, in words.

    Raises
    ------
    CalibrationError
        If the recordings cannot be used, with the reason.
    ArgumentError
        If a setting is refused, or there is no such term.

    """
    say = progress or (lambda text: None)
    arm = one_arm(recordings)
    given = PredictorSettings({**(values or {}), 'arm': arm})
    # The base's tilt that is given becomes part of gravity, which is fitted.
    values = {**given.values, 'gravity': tuple(given.arm.gravity_vector.tolist()),
              'base.roll': 0.0, 'base.pitch': 0.0}
    if not values['effort_model.enabled']:
        raise ArgumentError('effort_model.enabled', 'false, as beside a simulator: there is no '
                            'effort model to fit; begin with other parameters')
    if not values['align']:
        raise ArgumentError('align', 'false: a fit needs effort and acceleration of one instant')
    if only:  # beside what is asked for by name
        only = (*only, *(['inertial'] if inertial else []), *(['payload'] if payload else []))
    motions = _observed(recordings, values, say)
    refuse(motions)
    lag = velocity_lag(long_enough(motions))
    if lag is not None and abs(lag.value - values['acceleration.velocity_lag']) > _LAG_OFF:
        values['acceleration.velocity_lag'] = round(max(lag.value, 0.0), 4)
        motions = _observed(recordings, values, say)  # with the filter's delay as it should be
    notes = list(warnings(motions))
    motions = long_enough(motions)
    by_time = len(motions) == 1
    if by_time:
        motions = _split(motions[0])
        notes.append(
            f'one recording: judged on each of {PARTS} parts of it, fitted to the others. A '
            'motion that repeats lap after lap makes this look better than it is: record another')
    terms = _terms(PredictorSettings(values), motions, only, {
        'inertial': inertial, 'payload': payload}, notes)
    say('fitting')
    wanted = {'bias', *only, *OPTIONAL}
    if inertial or payload:
        wanted.add('tilt')  # whose part the bodies would take otherwise
    fit = Fit(values, terms, wanted, motions)
    notes += [f'{joint}: the motion does not show {", ".join(names)}: as before'
              for joint, names in fit.lost.items()]
    parameters = fit.fitted()
    if any(row.name.startswith('payload center') and abs(row.after) >= REACH
           for row in parameters):
        notes.append("payload: the motion does not show its centre of mass: don't use it, record "
                     'a wider motion (--plan shows one)')
    say('judging on what was left out')
    return Calibration(
        arm=arm, before=values, values=fit.values, parameters=parameters, steps=fit.steps,
        judged=fit.judged(), by_time=by_time, lag=lag, warnings=tuple(notes),
        samples=sum(map(len, motions)), duration=sum(motion.duration for motion in motions),
        s1_range=_sweep(motions))


def _observed(recordings: Iterable[Recording], values: dict[str, Any],
              say: Callable[[str], None]) -> list[Motion]:
    motions = []
    for recording in recordings:
        say(f'reading {recording.name}')
        motions.append(observe(recording, values))
    return motions


def _terms(settings: PredictorSettings, motions: list[Motion], only: Collection[str],
           asked: dict[str, bool], notes: list[str]) -> list[Term]:
    """Return the terms to fit; note what is left out."""
    lower, upper = settings.effort_model.spring_range
    low, high = np.clip(_sweep(motions), lower, upper)
    shape = high - low >= _SWEEP * (upper - lower)
    if not shape and (not only or 'spring' in only) and settings.effort_model.has_spring:
        notes.append(f"s1 sweeps {low:.2f} to {high:.2f} of the spring's {lower:g} to {upper:g} "
                     'rad: its shape is kept, only gain and offset can be fitted')
    terms = all_terms(settings, shape, constant=shape and 'spring' in only and 'bias' not in only)
    names = {term.name for term in terms}
    for name in only:
        if name not in names:
            raise ArgumentError('only', f'no term {name}; there are {", ".join(sorted(names))}')
    return [term for term in terms
            if (term.name in only if only else asked.get(term.name, True))]


def _sweep(motions: list[Motion]) -> tuple[float, float]:
    """Return between which angles s1 is nearly all the time [rad]."""
    s1 = np.concatenate([motion.q[:, S1] for motion in motions])
    return tuple(np.quantile(s1, [0.002, 0.998]).tolist())


def _split(motion: Motion) -> list[Motion]:
    edges = np.linspace(0, len(motion), PARTS + 1).astype(int)
    return [motion.rows(*pair).renamed(f'{motion.name}, part {k + 1}')
            for k, pair in enumerate(zip(edges, edges[1:]))]
