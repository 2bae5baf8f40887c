"""Tables of an evaluation: errors, the paper's Table V, terms, accelerations, data check."""

from collections.abc import Sequence

import numpy as np

from .evaluation_figures import methods_of
from .summary import NOTHING
from .table import Column, Table
from ..model.arrays import Array
from ..model.joints import JOINTS
from ..model.paper_tables import TABLE_V, TABLE_V_SUM
from ..recordings.data_check import DataCheck, Gain
from ..recordings.evaluation_results import Evaluation, Statistics, TERMS

TERM_NAMES = {term: term for term in TERMS} | {'coriolis': 'Coriolis'}
ESTIMATOR_NAMES = {'first_difference': 'first difference', 'butterworth_live': 'live',
                   'butterworth_aligned': 'aligned'}
_SHORT = {'lagrange_euler': 'L-E', 'newton_euler': 'N-E'}
_STATISTICS = {'rms': 'RMS', 'mean_abs': 'mean |e|', 'correlation': 'correlation'}


def size_table(of: Statistics) -> Table:
    """Return size of the error, expected size, and correlation."""
    methods, columns = methods_of(of), []
    for statistic, label in _STATISTICS.items():
        for method, errors in methods.items():
            values = getattr(errors, statistic)
            whole = float(np.fmax.reduce(values)) if statistic == 'rms' else None
            columns.append(Column(_SHORT[method], values, label, whole=whole)
                           if len(methods) > 1 else Column(label, values, whole=whole))
    if of.expected is not None:
        columns += [Column('expected deviation', of.expected.deviation),
                    Column('within ±1.96 of it [%]', 100.0 * of.expected.coverage, digits=0)]
    return Table('Error e = measured − predicted effort [N m]', 'joint', JOINTS, columns)


def table_five(of: Statistics) -> Table:
    """Return the paper's Table V for these recordings, beside the paper's columns."""
    methods = methods_of(of)
    columns = [Column(_SHORT[method] if len(methods) > 1 else 'e', np.abs(errors.signed_mean),
                      'here', 4, foot=float(errors.signed_mean.sum()))
               for method, errors in methods.items()]
    columns += [Column(label, np.array(TABLE_V[method][i]), f'paper, set {i + 1}', 4,
                       foot=TABLE_V_SUM[method][i])
                for i in range(3) for method, label in zip(_SHORT, ('L-E', 'RN-E'))]
    return Table('|signed mean| of e [N m]; last row: sum of the signed means', 'joint', JOINTS,
                 columns, 'sum')


def terms_table(shares: dict[str, Array]) -> Table:
    """Return the RMS of each term of the predicted effort."""
    greatest = np.array(list(shares.values())).max(axis=0)  # (7,)
    return Table('RMS of each term [N m]; bars compare the terms of a joint', 'joint', JOINTS,
                 [Column(name, shares[term], whole=greatest)
                  for term, name in TERM_NAMES.items()])


def estimators_table(of: Statistics) -> Table:
    """Return the RMS error with each acceleration estimator."""
    rms = {name: errors.rms for name, errors in of.estimators.items()}
    greatest = np.array(list(rms.values())).max(axis=0)  # (7,)
    return Table('RMS of e [N m] by acceleration; bars compare those of a joint', 'joint', JOINTS,
                 [Column(ESTIMATOR_NAMES[name], values, whole=greatest)
                  for name, values in rms.items()])


def check_table(check: DataCheck) -> Table:
    """Return the gains of measured on predicted effort, and their correlation."""
    def known(gain: Gain) -> Array:
        return np.where(gain.known, gain.value, np.nan)

    columns = {'gain': check.gain, 'correlation': check.correlation,
               'on M q̈ + C q̇': known(check.inertial), 'on G': known(check.gravity),
               'on the spring': known(check.spring)}
    return Table('Measured over predicted effort without friction and bias: gain, correlation, '
                 'and gain on single terms; – where the motion does not show it', 'joint', JOINTS,
                 [Column(label, values, digits=2) for label, values in columns.items()])


def recordings_table(evaluations: Sequence[Evaluation]) -> Table:
    """Return the RMS error of each recording."""
    rms = np.array([evaluation.methods.get('lagrange_euler', NOTHING).rms
                    for evaluation in evaluations])  # (n, 7)
    return Table(
        'RMS of e per recording [N m]; bars compare the recordings', 'recording',
        [(evaluation.name, f'#recording-{i}') for i, evaluation in enumerate(evaluations, 1)],
        [Column('time [s]', np.array([e.duration for e in evaluations]), digits=1),
         *(Column(joint, column, whole=float(np.fmax.reduce(column)))
           for joint, column in zip(JOINTS, rms.T))])
