"""Verdict on a residual, against that of other Baxters, and what to do next."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
import sys
from typing import NamedTuple

import numpy as np

from .data_check import Notice
from .evaluation_results import Evaluation, Statistics
from ..estimation.explanation import Explained
from ..estimation.settings import PredictorSettings
from ..model import EffortModel, JOINTS, N_JOINTS, names_of

# Largest RMS residual of a calibrated Baxter on left-out recordings [N m].
CALIBRATED = np.array([0.5, 1.0, 0.5, 0.35, 0.15, 0.25, 0.1])

_COVERED = 0.85  # share of residuals within 1.96 deviations below which a joint exceeds them
_DURATION = 10.0  # minimum duration of the recordings of a calibration [s]
_FREQUENT = 1 / 3  # share of the explanations that makes one worth acting on

_FITTED = {'tilt': 'a tilted base', 'friction': 'friction'}  # explanations a calibration removes


class Verdict(NamedTuple):
    """Assessment of the residual of one recording or several."""

    kind: str  # 'calibrated', 'uncalibrated', 'larger', 'wrong_data' or 'no_effort'
    text: str  # one sentence
    joints: tuple[str, ...] = ()  # joints concerned


class Advice(NamedTuple):
    """Something to do next."""

    kind: str  # calibrate, payload or zero; or a problem found by the data check
    text: str  # one sentence
    command: str = ''


class Assessment(NamedTuple):
    """Verdict, and what to do next, the most important first."""

    verdict: Verdict
    advice: tuple[Advice, ...] = ()


def assess(total: Statistics, evaluations: Sequence[Evaluation], settings: PredictorSettings,
           recordings: str, output: str = '--force') -> Assessment:
    """
    Assess the residual of the Lagrange-Euler effort over all recordings and in each.

    The recordings are named with their options, as on the command line; ``output`` has the
    options with which another evaluation replaces this report.
    """
    problems = [notice for evaluation in evaluations for notice in evaluation.notices
                if notice.refuses or notice.kind == 'springs']
    evaluate = f'baxter_dynamics evaluate {recordings} {output}'
    if problems:
        verdict = Verdict('wrong_data', 'The data do not match the model of these settings: '
                          f'{problems[0].finding}.', problems[0].joints)
        return Assessment(verdict, tuple(_corrections(problems, evaluations[0].arm, evaluate)))
    if 'lagrange_euler' not in total.methods:
        return Assessment(Verdict('no_effort', 'No prediction could be compared with a measured '
                                  'effort: the warnings give the reason.'))
    verdict = _judge(total, settings)
    return Assessment(verdict, tuple(_improvements(verdict, evaluations, recordings, evaluate)))


def _judge(total: Statistics, settings: PredictorSettings) -> Verdict:
    coverage = np.ones(N_JOINTS) if total.expected is None else total.expected.coverage
    beyond = coverage < _COVERED
    if beyond.any():
        shares = ', '.join(f'{100 * coverage[i]:.0f} % at {JOINTS[i]}'
                           for i in np.flatnonzero(beyond))
        return Verdict('larger', f'The residual is larger than expected: only {shares} lie '
                       'within 1.96 expected deviations, instead of 95 %.', names_of(beyond))
    larger = total.methods['lagrange_euler'].rms > 1.2 * CALIBRATED
    if not larger.any():
        return Verdict('calibrated', 'The residual is as small as that of a calibrated Baxter.')
    if not np.array_equal(settings.effort_model.deviation, EffortModel.deviation):
        return Verdict('calibrated', 'The residual is within its expected deviation.')
    return Verdict('uncalibrated', 'The residual is that of a Baxter before calibration: larger '
                   'than after calibration at '
                   f'{"every joint" if larger.all() else ", ".join(names_of(larger))}.',
                   names_of(larger))


def _corrections(problems: list[Notice], arm: str, evaluate: str) -> Iterator[Advice]:
    files = [_config(f'{side}_arm.yaml') for side in dict.fromkeys(('right', arm))]
    after_remedy = {'no_springs': f'{evaluate} --params {_config("simulation.yaml")}',
                    'springs': ' --params '.join([evaluate, *files]),
                    'moved_by_hand': f'baxter_dynamics calibrate --plan --arm {arm}'}
    for kind, remedy in {problem.kind: problem.remedy for problem in problems}.items():
        yield Advice(kind, f'{remedy[0].upper()}{remedy[1:]}.', after_remedy.get(kind, ''))


def _improvements(verdict: Verdict, evaluations: Sequence[Evaluation], recordings: str,
                  evaluate: str) -> Iterator[Advice]:
    found = _frequent(evaluations)
    if 'offset' in found:
        joints = {one.joint for one in found['offset']}
        yield Advice(
            'zero', 'Much of the residual is a constant offset of '
            f'{", ".join(joint for joint in JOINTS if joint in joints)}. With the robot '
            'connected, zero it:', 'ros2 service call /torque_predictor/zero std_srvs/srv/Trigger')
    if 'payload' in found:
        mass = float(np.median([one.payload.mass for one in found['payload'] if one.payload]))
        file = '' if 'electric_gripper' in recordings else _config('electric_gripper.yaml')
        yield Advice(
            'payload', f'The residual is consistent with {mass:.2f} kg more at the hand. Set '
            'payload.mass and payload.center_of_mass of the whole payload' + (
                '; for the electric gripper with standard fingers, 0.36 kg, there is a file:'
                if file else '.'), f'{evaluate} --params {file}' if file else '')
    if verdict.kind != 'calibrated':
        output = 'my_robot_new.yaml' if 'my_robot.yaml' in recordings else 'my_robot.yaml'
        causes = ' and '.join(text for kind, text in _FITTED.items() if kind in found)
        is_usable = sum(one.duration for one in evaluations) >= _DURATION and any(
            one.check is None or np.isfinite(one.check.gain).any() for one in evaluations)
        yield Advice(
            'calibrate', (f'Much of the residual is due to {causes}. ' if causes else '')
            + 'Calibrate with at least ten seconds, preferably a minute, of motion of all joints '
            '(calibrate --plan writes one):', f'baxter_dynamics calibrate {recordings}'
            f'{" --payload" if "payload" in found else ""} -o {output}' if is_usable else
            f'baxter_dynamics calibrate --plan --arm {evaluations[0].arm}')


def _frequent(evaluations: Sequence[Evaluation]) -> dict[str, list[Explained]]:
    """Return the explanations by kind, of the kinds that hold for much of the time."""
    every = [one for evaluation in evaluations for one in evaluation.explained]
    return {kind: [one for one in every if one.kind == kind]
            for kind, n in Counter(one.kind for one in every).items()
            if n >= _FREQUENT * len(every)}


def _config(name: str) -> str:
    """Return the path of a parameter file of this package, installed or in the repository."""
    folders = [Path(__file__).parents[2] / 'config',
               Path(sys.prefix) / 'share' / 'baxter_dynamics_ros' / 'config']
    return next((str(folder / name) for folder in folders if (folder / name).is_file()),
                f'config/{name}')
