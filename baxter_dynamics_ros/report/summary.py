"""An evaluation's numbers for other programs: summary.json and summary.csv."""

from collections.abc import Sequence
import csv
import io
import json
import math
from typing import Any

import numpy as np

from .. import __version__
from ..model.joints import JOINTS, N_JOINTS
from ..recordings.evaluation_results import (ErrorStatistics, ESTIMATORS, Evaluation, METHODS,
                                             Statistics, TERMS)

NOTHING = ErrorStatistics(0, *np.full((4, N_JOINTS), np.nan))  # of a recording without effort

_CSV_HEADER = ('recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
               'mean_abs [N m]', 'signed_mean [N m]', 'correlation')


def summary_json(evaluations: Sequence[Evaluation], total: Statistics, command: str,
                 parameters: str) -> str:
    """
    Return the statistics over all recordings and of each, with null for what is no number.

    Parameters
    ----------
    evaluations : sequence of Evaluation
        One a recording.
    total : Total
        Over all of them.
    command, parameters : str
        What they were made with.

    """
    return json.dumps({
        'version': __version__,
        'command': _text(command),
        'parameters': _text(parameters),
        'joints': list(JOINTS),
        'unit': 'N m',
        'arm': total.arm,
        **_statistics(total),
        'recordings': [{
            'name': _text(evaluation.name),
            'topic': _text(evaluation.topic),
            'arm': evaluation.arm,
            'duration': _number(evaluation.duration),
            'rate': _number(evaluation.rate),
            'counts': {name: int(count) for name, count in evaluation.counts.items()},
            'warnings': [_text(warning) for warning in evaluation.warnings],
            'notices': [{'kind': notice.kind, 'joints': list(notice.joints),
                         'text': _text(notice.text)} for notice in evaluation.notices],
            'contacts': [contact._asdict() for contact in evaluation.contacts],
            **_statistics(evaluation),
        } for evaluation in evaluations],
    }, indent=2, allow_nan=False) + '\n'


def summary_csv(evaluations: Sequence[Evaluation]) -> str:
    """Return a row per recording, method and joint; what is no number is left empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer)
    writer.writerow(_CSV_HEADER)
    for evaluation in evaluations:
        for method in METHODS:
            errors = evaluation.methods.get(method, NOTHING)
            for i, joint in enumerate(JOINTS):
                writer.writerow([
                    _cell(evaluation.name), _cell(evaluation.topic), evaluation.arm, method,
                    joint, errors.count, *(_number(column[i]) for column in errors[1:])])
    return buffer.getvalue()


def _statistics(of: Statistics) -> dict[str, Any]:
    errors = {method: _as_lists(of.methods.get(method, NOTHING)) for method in METHODS}
    return {
        **errors,
        'estimators': {estimator: _as_lists(of.estimators.get(estimator, NOTHING))
                       for estimator in ESTIMATORS},
        'shares': {term: [_number(value) for value in of.shares.get(term, NOTHING.rms)]
                   for term in TERMS},
    }


def _as_lists(errors: ErrorStatistics) -> dict[str, Any]:
    arrays = {name: [_number(value) for value in array]
              for name, array in errors._asdict().items() if name != 'count'}
    return {'count': int(errors.count), **arrays}


def _number(value: float) -> 'float | None':
    return float(value) if math.isfinite(value) else None


def _text(text: str) -> str:
    """Return text that UTF-8 can hold; file names may have what it cannot."""
    return text.encode('utf-8', 'replace').decode('utf-8')


def _cell(text: str) -> str:
    """Return text that no spreadsheet takes for a formula."""
    return "'" + text if text.startswith(('=', '+', '-', '@', '\t', '\r')) else text
