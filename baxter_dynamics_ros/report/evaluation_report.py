"""The evaluation report: a page with figures and tables, the figures as files, and its numbers."""

from collections.abc import Mapping, Sequence
import csv
import io
import json
import math
from pathlib import Path
import re
from typing import Any

import numpy as np

from .drawing import (draw_band, draw_expected, frame, legend, MEASURED, MODEL, panels, Picture,
                      styled, svg, zero_line)
from .page import Column, compared, findings, joint_columns, listed, render, Table, torque
from .. import __version__
from ..files import write_files
from ..model import BAND, JOINTS, N_JOINTS
from ..model.paper_tables import TABLE_V, TABLE_V_SUM
from ..recordings.advice import Assessment
from ..recordings.data_check import DataCheck
from ..recordings.evaluation_results import (ErrorStatistics, ESTIMATORS, Evaluation, METHODS,
                                             Statistics, TERMS)

NOTHING = ErrorStatistics(0, *np.full((4, N_JOINTS), np.nan))  # of a recording without effort
ESTIMATOR_NAMES = {'first_difference': 'first difference', 'butterworth_live': 'live',
                   'butterworth_aligned': 'aligned'}


def write_evaluation(folder: str | Path, evaluations: Sequence[Evaluation],
                     total: Statistics, assessment: Assessment, command: str,
                     parameters: str) -> None:
    """
    Write summary.csv and summary.json; then draw and write figures/*.svg and report.html.

    The folder is created if missing, and other files in it stay. There is at least one evaluation;
    the total is over all of them. Raise BaxterDynamicsError if a file cannot be written.
    """
    write_files(folder, {
        'summary.json': summary_json(evaluations, total, assessment, command, parameters),
        # The byte order mark tells spreadsheets that the file is UTF-8.
        'summary.csv': '\ufeff' + summary_csv(evaluations)})
    with styled():
        pictures = [[effort_picture(f'{i:02d}_{_file_name(one.name)}_effort_{joint}', one, k)
                     for k, joint in enumerate(JOINTS) if one.shares]
                    for i, one in enumerate(evaluations, 1)]
    several = len(evaluations) > 1
    # RMS, mean |e| and signed mean of each method [N m].
    errors = [total.methods.get(method, NOTHING)[1:4] for method in METHODS]
    page = render(
        'evaluation.html.j2', evaluations=evaluations, pictures=pictures, total=total,
        assessment=assessment, several=several,
        findings=findings(RULES, total) if total.methods else {},
        notices=[f'{one.name}: {notice}' if several else str(notice)
                 for one in evaluations for notice in one.notices],
        predictions=sum(one.counts.get('predicted', 0) for one in evaluations),
        apart=float(np.ptp(errors, axis=0).max()), size_table=size_table,
        recordings_table=recordings_table, check_table=check_table, table_five=table_five,
        terms_table=terms_table, estimators_table=estimators_table,
        command=command, parameters=parameters)
    figures = {f'figures/{picture.name}.svg': picture.svg for picture in sum(pictures, [])}
    write_files(folder, {**figures, 'report.html': page})


def effort_picture(name: str, evaluation: Evaluation, joint: int) -> Picture:
    """Draw measured and predicted effort, and the error; the prediction alone without effort."""
    time, bands = evaluation.time, evaluation.bands
    errors = evaluation.methods.get('lagrange_euler')
    figure, axes = panels((1.75, 1.05) if errors else (1.75,), JOINTS[joint])
    what = 'predicted'
    if errors:
        rms = f'RMS {errors.rms[joint]:.3f} N m'
        what = f'measured and predicted, and their difference, {rms}'
        draw_band(axes[0], time, bands['measured'], joint, 'measured', MEASURED, 1.8)
        draw_band(axes[1], time, bands['error_lagrange_euler'], joint, 'Lagrange-Euler', MODEL)
        draw_expected(axes[1], time, bands['deviation'].high[:, joint])
        zero_line(axes[1])
        axes[1].set_title(f'measured − predicted, {rms}', loc='left', pad=4)
        frame(axes[1], 'error [N m]')
    draw_band(axes[0], time, bands['lagrange_euler'], joint, 'Lagrange-Euler', MODEL)
    frame(axes[0], 'effort [N m]')
    axes[-1].set_xlim(0.0, time[-1] + time[0])  # middles of the last and the first interval
    axes[-1].set_xlabel('time [s]', labelpad=2)
    legend(figure)
    return Picture(name, f'Effort at {JOINTS[joint]} over time: {what}', svg(figure))


def size_table(of: Statistics) -> Table:
    """Return size of the error, expected size, and correlation."""
    errors = of.methods['lagrange_euler']
    columns = [Column('RMS', errors.rms, whole=errors.rms.max()),
               Column('mean |e|', errors.mean_abs), Column('correlation', errors.correlation)]
    if of.expected is not None:
        columns += [Column('expected deviation', of.expected.deviation),
                    Column('within ±1.96 deviations [%]', 100.0 * of.expected.coverage, digits=0)]
    return Table('Error e = measured − predicted effort [N m]', columns)


def table_five(of: Statistics) -> Table:
    """Return the paper's Table V for these recordings, beside the paper's columns."""
    mean = of.methods['lagrange_euler'].signed_mean
    columns = [Column('e', np.append(np.abs(mean), mean.sum()), 'here', 4)]
    columns += [Column(label, np.append(TABLE_V[method][i], TABLE_V_SUM[method][i]),
                       f'paper, set {i + 1}', 4) for i in range(3)
                for method, label in (('lagrange_euler', 'L-E'), ('newton_euler', 'RN-E'))]
    return Table('|signed mean| of e [N m]; last row: sum of the signed means', columns,
                 rows=[*JOINTS, 'sum'], foot=True)


def terms_table(of: Statistics) -> Table:
    """Return the RMS of each term of the predicted effort."""
    return Table('RMS of each term [N m]; bars compare the terms of a joint', compared({
        'Coriolis' if term == 'coriolis' else term: rms for term, rms in of.shares.items()}))


def estimators_table(of: Statistics) -> Table:
    """Return the RMS error with each acceleration estimator."""
    return Table('RMS of e [N m] by acceleration; bars compare the values of a joint', compared({
        ESTIMATOR_NAMES[name]: errors.rms for name, errors in of.estimators.items()}))


def check_table(check: DataCheck) -> Table:
    """Return the gains of measured on predicted effort, and their correlation."""
    columns = {'gain': check.gain, 'correlation': check.correlation}
    for name, gain in (('M q̈ + C q̇', check.inertial), ('G', check.gravity),
                       ('the spring', check.spring)):
        columns[f'on {name}'] = np.where(gain.known, gain.value, np.nan)
    return Table('Measured over predicted effort without friction and bias: gain, correlation, '
                 'and gain on single terms; – where the motion does not determine it',
                 [Column(label, values, digits=2) for label, values in columns.items()])


def recordings_table(evaluations: Sequence[Evaluation]) -> Table:
    """Return the RMS error of each recording."""
    time = np.array([one.duration for one in evaluations])
    rms = [one.methods.get('lagrange_euler', NOTHING).rms for one in evaluations]
    return Table('RMS of e per recording [N m]; bars compare the recordings',
                 [Column('time [s]', time, digits=1), *joint_columns(rms)], 'recording',
                 [one.name for one in evaluations], address='#recording-')


def _offset(of: Statistics) -> 'str | None':
    errors = of.methods['lagrange_euler']
    mostly = errors.signed_mean ** 2 > 0.5 * errors.rms ** 2
    if of.expected is not None:
        mostly &= np.abs(errors.signed_mean) > BAND * of.expected.deviation
    if not mostly.any():
        return None
    offsets = [f'{joint} ({torque(value)})' for joint, value in zip(JOINTS, errors.signed_mean)]
    return ('More than half of the mean square error is a constant offset at '
            f'{listed(mostly, offsets)}. Possible causes: a bias of the measured effort, a load '
            'that is not modelled, a tilted base.')


def _beyond_the_terms(of: Statistics) -> 'str | None':
    beyond = of.methods['lagrange_euler'].rms > np.max([*of.shares.values()], axis=0)
    return (f'The error is larger than every term of the model at {listed(beyond)}.'
            if beyond.any() else None)


RULES = {'Offset': _offset, 'Not in the model': _beyond_the_terms}


def _file_name(name: str) -> str:
    """Return a recording's name with the characters that are safe in files and addresses."""
    return re.sub(r'[^A-Za-z0-9]+', '_', name).strip('_')[:40] or 'recording'


def summary_json(evaluations: Sequence[Evaluation], total: Statistics,
                 assessment: Assessment, command: str, parameters: str) -> str:
    """Return the statistics over all recordings and of each; null where there is no number."""
    return json.dumps(_plain({
        'version': __version__, 'command': command, 'parameters': parameters, 'joints': JOINTS,
        'unit': 'N m', 'arm': total.arm, **assessment._asdict(), **_statistics(total),
        'recordings': [{
            **{name: getattr(evaluation, name) for name in (
                'name', 'topic', 'arm', 'duration', 'rate', 'counts')},
            'warnings': [str(notice) for notice in evaluation.notices],
            'contacts': evaluation.contacts,
            'notices': [{'kind': notice.kind, 'joints': notice.joints, 'text': str(notice)}
                        for notice in evaluation.notices],
            **_statistics(evaluation),
        } for evaluation in evaluations],
    }), indent=2, allow_nan=False) + '\n'


def summary_csv(evaluations: Sequence[Evaluation]) -> str:
    """Return a row per recording, method and joint; cells without a number are empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer)
    writer.writerow(('recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
                     'mean_abs [N m]', 'signed_mean [N m]', 'correlation'))
    for evaluation in evaluations:
        for method in METHODS:
            count, *columns = _plain(evaluation.methods.get(method, NOTHING)).values()
            writer.writerows(
                (_cell(evaluation.name), _cell(evaluation.topic), evaluation.arm, method, joint,
                 count, *row) for joint, *row in zip(JOINTS, *columns))
    return buffer.getvalue()


def _cell(text: str) -> str:
    """Return text that no spreadsheet takes for a formula."""
    return "'" + text if text.startswith(('=', '+', '-', '@', '\t', '\r')) else text


def _statistics(of: Statistics) -> dict[str, Any]:
    return {**{method: of.methods.get(method, NOTHING) for method in METHODS},
            'estimators': {name: of.estimators.get(name, NOTHING) for name in ESTIMATORS},
            'expected': of.expected,
            'shares': {term: of.shares.get(term, NOTHING.rms) for term in TERMS}}


def _plain(value: Any) -> Any:
    """Return data as JSON has it: objects, lists, and null for NaN."""
    if hasattr(value, '_asdict'):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
