"""Numbers of an evaluation for other programs: summary.json and summary.csv."""

from collections.abc import Mapping, Sequence
import csv
import io
import json
import math
from typing import Any

import numpy as np

from .. import __version__
from ..model.joints import JOINTS, N_JOINTS
from ..recordings.advice import Assessment
from ..recordings.evaluation_results import (ErrorStatistics, ESTIMATORS, Evaluation, METHODS,
                                             Statistics, TERMS)

NOTHING = ErrorStatistics(0, *np.full((4, N_JOINTS), np.nan))  # of a recording without effort

_CSV_HEADER = ('recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
               'mean_abs [N m]', 'signed_mean [N m]', 'correlation')


def summary_json(evaluations: Sequence[Evaluation], total: Statistics,
                 assessment: Assessment, command: str, parameters: str) -> str:
    """Return the statistics over all recordings and of each; null where there is no number."""
    return json.dumps(_plain({
        'version': __version__, 'command': command, 'parameters': parameters, 'joints': JOINTS,
        'unit': 'N m', 'arm': total.arm, **assessment._asdict(), **_statistics(total),
        'recordings': [{
            **{name: getattr(evaluation, name) for name in (
                'name', 'topic', 'arm', 'duration', 'rate', 'counts', 'warnings', 'contacts')},
            'notices': [{'kind': notice.kind, 'joints': notice.joints, 'text': notice.text}
                        for notice in evaluation.notices],
            **_statistics(evaluation),
        } for evaluation in evaluations],
    }), indent=2, allow_nan=False) + '\n'


def summary_csv(evaluations: Sequence[Evaluation]) -> str:
    """Return a row per recording, method and joint; cells without a number are empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer)
    writer.writerow(_CSV_HEADER)
    for evaluation in evaluations:
        for method in METHODS:
            count, *columns = _plain(evaluation.methods.get(method, NOTHING)).values()
            writer.writerows(
                (evaluation.name, evaluation.topic, evaluation.arm, method, joint, count, *row)
                for joint, *row in zip(JOINTS, *columns))
    return buffer.getvalue()


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
