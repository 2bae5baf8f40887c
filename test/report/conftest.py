"""Evaluations and calibrations with known numbers, and the reports on them."""

from dataclasses import replace

from baxter_dynamics_ros.calibration.calibration_results import (Calibration, Fitted, Judged,
                                                                 Selection)
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.recordings.advice import Advice, Assessment, Verdict
from baxter_dynamics_ros.recordings.data_check import Notice
from baxter_dynamics_ros.recordings.evaluation_results import (Band, ErrorStatistics, ESTIMATORS,
                                                               Evaluation, METHODS, TERMS)
from baxter_dynamics_ros.recordings.playback import Lag
import numpy as np
import pytest
from report.pages import HOSTILE

AMPLITUDE = np.array([5.0, 20.0, 3.0, 8.0, 0.5, 0.6, 0.1])  # of the measured effort [N m]
OFFSET = np.array([0.5, -0.25, 0.125, 0.01, -0.02, 0.03, 0.08])  # of the error [N m]
PERIOD = 0.08  # [s]
N = 250  # samples: 20 s
GAP = slice(100, 113)  # samples that are missing: 1 s

BEFORE = np.array([1.0, 2.0, 0.8, 0.5, 0.2, 0.4, 0.1])  # RMS before a calibration [N m]
ALL = tuple(range(7))


@pytest.fixture(scope='session')
def evaluate():
    """Return a function that makes what would be found about N samples, one an interval."""
    return _evaluate


@pytest.fixture(scope='session')
def too_short():
    """Return what is found about a recording on which nothing can be predicted."""
    none = {signal: Band(np.zeros((0, 7)), np.zeros((0, 7))) for signal in METHODS}
    return Evaluation('right', {}, {}, {}, None, 'too short', '/robot/joint_states', 0.0, 0.0,
                      {'received': 1}, (Notice('nothing', 'nothing could be predicted'),),
                      np.zeros(0), none)


@pytest.fixture(scope='session')
def calibration():
    """Return a calibration from two recordings, 30 s and 10 s long."""
    half = np.array([0.5, 1.1, 0.5, 0.5, 0.5, 0.5, 0.5])
    steps = [Selection('', (), BEFORE), Selection('bias', ALL, BEFORE * half),
             Selection('viscous', (), BEFORE * half),
             Selection('dahl', (0, 1), BEFORE * [0.4, 0.3, *half[2:]]),
             Selection('tilt', ALL, BEFORE * [0.5, 0.4, *half[2:]])]
    changes = {'effort_model.bias': (0.5, -0.25, 0.125, 0.0, 0.0, 0.0, 0.0625),
               'effort_model.dahl': (0.3, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0),
               'effort_model.dahl_length': 0.05, 'gravity': (0.171, -0.0856, -9.808)}
    parameters = [
        *(Fitted('bias', joint, '', 'N m', 0.0, value, 0.1)
          for joint, value in enumerate(changes['effort_model.bias'])),
        Fitted('dahl', 0, '', 'N m', 0.0, 0.3, 0.02),
        Fitted('dahl', 1, '', 'N m', 0.0, 1.5, 0.0071),
        Fitted('tilt', None, 'x', 'm/s^2', 0.0, 0.171, 0.0171),
        Fitted('tilt', None, 'y', 'm/s^2', 0.0, -0.0856, 0.0342)]
    judged = [Judged('varied', 30.0, BEFORE, *2 * [0.5 * BEFORE]), Judged(
        'laps', 10.0, BEFORE, *2 * [BEFORE * [0.25, 0.5, 1.5, 0.5, 0.5, 0.5, 0.5]])]
    before = PredictorSettings(arm='left')
    return Calibration(
        before=before, after=before.replace(changes), parameters=parameters, steps=steps,
        judged=judged, fold='recording',
        lag=Lag(0.0133, 3e-5, np.array([0.0133] * 5 + [0.02, np.nan])),
        contacts=[], notices=(Notice(
            'unidentifiable', 'e1: the motion does not determine stiffness', ('e1',)),),
        samples=4000, s1_range=(-1.1, 0.35))


@pytest.fixture(scope='session')
def calibration_page(calibration, tmp_path_factory):
    """Return the path of a report with everything, written over an old file."""
    from baxter_dynamics_ros.report.calibration_report import write_calibration
    path = tmp_path_factory.mktemp('calibration') / 'my robot.html'
    path.write_text('old')
    names = [HOSTILE, 'a_name_without_a_place_to_break_' * 5, *(f'run {i}' for i in range(28))]
    judged = [one._replace(name=name, duration=1.0)
              for name, one in zip(names, 15 * calibration.judged)]
    notices = [Notice('repeated_stamp', '3 x repeated_stamp: <look>', recording=name)
               for name in names[:20]]
    notices += [Notice('spring_shape', 's1 sweeps'), Notice('still', 'w2: never moves')]
    links = [Fitted('inertial', link, name, unit, before, before + 0.25, 0.05)
             for link in range(7)
             for name, unit, before in (('mass', 'kg', 4.0), ('moment x', 'kg m', 0.5),
                                        ('moment y', 'kg m', 0.0), ('moment z', 'kg m', -0.5))]
    write_calibration(path, replace(
        calibration, judged=judged, notices=tuple(notices),
        parameters=[*calibration.parameters, *links]), f'calibrate {HOSTILE}', 'my robot.yaml')
    return path


@pytest.fixture(scope='session')
def evaluation_folder(evaluate, too_short, tmp_path_factory):
    """Return the folder of a report on three recordings, written over old files."""
    from baxter_dynamics_ros.report import evaluation_report
    folder = tmp_path_factory.mktemp('evaluation')
    (folder / 'notes.txt').write_text('mine')
    (folder / 'report.html').write_text('old')
    first = evaluate(HOSTILE, warnings=['stamps <look> like times of arrival'])
    advice = Advice('calibrate', 'Calibrate:',
                    'baxter_dynamics calibrate "a&b" ' + 9 * 'a_long_path/')
    assessment = Assessment(Verdict('uncalibrated', 'Larger than <calibrated>.'), (advice,))
    with evaluation_report.styled(), pytest.MonkeyPatch.context() as patch:  # one figure suffices
        picture = evaluation_report.effort_picture('x', first, 0)
        patch.setattr(evaluation_report, 'effort_picture',
                      lambda name, *_: picture._replace(name=name))
        evaluation_report.write_evaluation(
            folder, [first, evaluate('no effort', effort=False), too_short], first, assessment,
            'evaluate "a&b" <c>', 'my.yaml')
    return folder


def _evaluate(name='run', effort=True, warnings=(), empty=GAP):
    time = (np.arange(N) + 0.5) * PERIOD
    measured = AMPLITUDE * np.sin(np.outer(time, np.linspace(1.0, 2.0, 7)))
    measured[:, 6] = 0.1  # so that it has no correlation
    error = OFFSET + 0.2 * np.sin(np.outer(time, np.linspace(5.0, 9.0, 7)))
    noise = np.random.default_rng(3).normal(0.0, 3.0, error.shape)
    errors = {'lagrange_euler': error, 'newton_euler': error + 0.002,
              'first_difference': error + noise, 'butterworth_live': 1.1 * error,
              'butterworth_aligned': error}
    signals = {'measured': measured, **{method: measured - errors[method] for method in METHODS},
               **{'error_' + name: values for name, values in errors.items()}}
    bands = {'deviation': Band(*2 * [np.full((N, 7), 0.25)])}
    for signal, values in signals.items():
        low, high = values - 0.01, values + 0.01
        low[empty] = high[empty] = np.nan
        bands[signal] = Band(low, high)
    filled = np.ones(N, bool)
    filled[empty] = False
    found = {name: _statistics(measured[filled], values[filled])
             for name, values in errors.items()}
    return Evaluation(
        'right', {method: found[method] for method in METHODS if effort},
        {estimator: found[estimator] for estimator in ESTIMATORS if effort},
        {term: AMPLITUDE / (i + 1) for i, term in enumerate(TERMS)}, None,
        name, '/robot/joint_states', N * PERIOD, 1 / PERIOD,
        {'received': N + 5, 'taken': N, 'predicted': N, 'not_this_arm': 5},
        tuple(Notice('test', text) for text in warnings), time,
        bands if effort else {name: bands[name] for name in (*METHODS, 'deviation')})


def _statistics(measured, error):
    with np.errstate(invalid='ignore', divide='ignore'):
        correlation = np.array([np.corrcoef(m, m - e)[0, 1]
                                for m, e in zip(measured.T, error.T)])
    correlation[measured.std(0) < 1e-12] = np.nan
    return ErrorStatistics(len(error), np.sqrt((error ** 2).mean(0)), np.abs(error).mean(0),
                           error.mean(0), correlation)
