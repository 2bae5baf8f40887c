"""The report's tables, as data: the paper's Table V, sizes of errors, terms, accelerations."""

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from .figures import STROKES, TERM_NAMES
from .page import number
from .summary import NOTHING
from ..model.arrays import Array
from ..model.joints import JOINTS
from ..model.paper_tables import TABLE_V, TABLE_V_SUM
from ..recordings.data_check import DataCheck
from ..recordings.evaluation_results import ESTIMATORS, Evaluation, METHODS, Statistics

# Widths of the rows' names, by kind, in the font's size; the page's styles have the same.
_HEADS = {'corner': 3.6, 'terms': 11.0, 'names': 12.0}
_SHORT = {'lagrange_euler': 'L-E', 'newton_euler': 'N-E'}


class Column(NamedTuple):
    """Numbers below one another."""

    label: str
    values: Array | Sequence[str]  # (n,); str are shown as they are
    group: str = ''  # heading that it shares with its neighbours
    digits: int = 3
    whole: 'Array | None' = None  # (n,), the values whose bar is as long as the cell
    foot: 'float | None' = None  # below the line

    def text(self, index: int) -> str:
        """Return what a cell shows."""
        value = self.values[index]
        return value if isinstance(value, str) else number(value, self.digits)


class Table(NamedTuple):
    """What a page shows as a table."""

    caption: str
    corner: str  # what the rows are
    rows: tuple[Any, ...]  # of str, or of (str, address within the page)
    columns: tuple[Column, ...]
    foot: str = ''  # name of the last row

    @property
    def groups(self) -> list[tuple[str, int]]:
        """Return (heading, number of columns) of neighbours; empty where there is no heading."""
        if not any(column.group for column in self.columns):
            return []
        return [(group, len(list(columns)))
                for group, columns in groupby(self.columns, key=lambda column: column.group)]

    @property
    def kind(self) -> str:
        """Return what the rows' names are like: 'corner', short; 'terms'; or 'names', long."""
        if not isinstance(self.rows[0], str):
            return 'names'
        longest = max(map(len, self.rows))
        return 'corner' if longest <= 5 else 'terms' if longest <= 18 else 'names'

    @property
    def width(self) -> float:
        """Return the width below which numbers would touch, in the font's size."""
        longest = max(len(text) for column in self.columns for text in (
            *column.label.split(), *map(column.text, range(len(self.rows))),
            number(column.foot or 0.0, column.digits)))
        return round(_HEADS[self.kind] + len(self.columns) * (0.6 * longest + 0.7), 1)

    def starts_group(self, index: int) -> bool:
        """Return whether a column is the first below its heading."""
        group = self.columns[index].group
        return bool(group) and (index == 0 or self.columns[index - 1].group != group)


def size_table(of: Statistics, where: str) -> Table:
    """Return RMS, mean |e| and correlation of both methods."""
    columns = []
    for statistic, group in (('rms', 'RMS'), ('mean_abs', 'mean |e|'),
                             ('correlation', 'correlation')):
        for method in METHODS:
            values = getattr(of.methods.get(method, NOTHING), statistic)
            whole = np.full(len(JOINTS), _greatest(values)) if statistic == 'rms' else None
            columns.append(Column(_SHORT[method], values, group, whole=whole))
    return Table(f'Size of the error, measured − predicted effort [N m], {where}', 'joint',
                 JOINTS, tuple(columns))


def table_five(of: Statistics, where: str) -> Table:
    """Return the paper's Table V for this, beside the paper's own columns."""
    columns = []
    for method in METHODS:
        signed_mean = of.methods.get(method, NOTHING).signed_mean
        columns.append(Column(_SHORT[method], np.abs(signed_mean), where, 4,
                              foot=float(signed_mean.sum())))
    for i in range(3):
        for method, label in zip(METHODS, ('L-E', 'RN-E')):
            columns.append(Column(label, np.array(TABLE_V[method][i]), f'paper, set {i + 1}', 4,
                                  foot=TABLE_V_SUM[method][i]))
    return Table('|signed mean| of the error [N m]; in the last row the sum of the signed means',
                 'joint', JOINTS, tuple(columns), 'sum')


def terms_table(shares: dict[str, Array]) -> Table:
    """Return what the predicted effort is made of."""
    greatest = np.array(list(shares.values())).max(axis=0)  # (7,)
    return Table('RMS of each term [N m]; the bars compare the terms of a joint', 'joint', JOINTS,
                 tuple(Column(name, shares[term], whole=greatest)
                       for term, name in TERM_NAMES.items()))


def estimators_table(of: Statistics) -> Table:
    """Return the RMS error with each way of finding the acceleration."""
    rms = {estimator: of.estimators[estimator].rms for estimator in ESTIMATORS
           if estimator in of.estimators}
    greatest = np.array(list(rms.values())).max(axis=0, initial=0.0)  # (7,)
    return Table('RMS of the error [N m] of Lagrange-Euler; the bars compare those of a joint',
                 'joint', JOINTS, tuple(Column(STROKES[estimator].label, values, whole=greatest)
                                        for estimator, values in rms.items()))


def check_table(check: DataCheck) -> Table:
    """Return the gains of the measured effort, and its correlation with the prediction."""
    columns = {'gain': check.gain, 'correlation': check.correlation,
               'on M q̈ + C q̇': np.where(check.inertial.known, check.inertial.value, np.nan),
               'on G': np.where(check.gravity.known, check.gravity.value, np.nan),
               'on the spring': np.where(check.spring.known, check.spring.value, np.nan)}
    return Table('Measured effort over predicted effort without friction and bias: gain, '
                 'correlation, and gain on single terms; – where the motion does not show it',
                 'joint', JOINTS,
                 tuple(Column(label, values, digits=2) for label, values in columns.items()))


def recordings_table(evaluations: Sequence[Evaluation], addresses: Iterable[str]) -> Table:
    """Return the RMS error of each recording, Lagrange-Euler."""
    rms = np.array([evaluation.methods.get('lagrange_euler', NOTHING).rms
                    for evaluation in evaluations])  # (n, 7)
    length = Column('time [s]', np.array([e.duration for e in evaluations]), digits=1)
    return Table(
        'RMS of the error per recording [N m], Lagrange-Euler; the bars compare the recordings',
        'recording', tuple(zip((e.name for e in evaluations), addresses)),
        (length, *(Column(joint, column, whole=np.full(len(rms), _greatest(column)))
                   for joint, column in zip(JOINTS, rms.T))))


def _greatest(values: Array) -> float:
    return float(np.fmax.reduce(values))
