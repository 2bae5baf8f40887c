"""The evaluation report: a page, its figures as files, and its numbers."""

from collections.abc import Sequence
from pathlib import Path
import re

from . import evaluation_tables
from .drawing import styled
from .evaluation_figures import COARSE, effort_picture, FINE, methods_of
from .evaluation_findings import RULES
from .findings import findings
from .page import render
from .summary import summary_csv, summary_json
from ..files import write_files
from ..model.joints import JOINTS
from ..recordings.advice import Assessment
from ..recordings.evaluation_results import Evaluation, Statistics


def write_evaluation(folder: str | Path, evaluations: Sequence[Evaluation],
                     total: Statistics, assessment: Assessment, command: str,
                     parameters: str) -> None:
    """
    Write summary.csv and summary.json; then draw and write figures/*.svg and report.html.

    Parameters
    ----------
    folder : Path
        Created if missing; other files in it stay.
    evaluations : sequence of Evaluation
        At least one, each of one recording.
    total : Statistics
        Statistics over all recordings.
    assessment : Assessment
        Verdict, and what to do next.
    command : str
        Command line.
    parameters : str
        Name of the parameter file, or 'defaults of the package'.

    Raises
    ------
    BaxterDynamicsError
        If a file cannot be written.

    """
    write_files(folder, {
        'summary.json': summary_json(evaluations, total, assessment, command, parameters),
        # The byte order mark tells spreadsheets that the file is UTF-8.
        'summary.csv': '\ufeff' + summary_csv(evaluations)})
    with styled():
        # The first recording, which is unfolded, is drawn more finely.
        pictures = [[
            effort_picture(f'{i:02d}_{_file_name(evaluation.name)}_effort_{joint}', evaluation, k,
                           FINE if i == 1 else COARSE)
            for k, joint in enumerate(JOINTS) if evaluation.shares]
            for i, evaluation in enumerate(evaluations, 1)]
    page = render(
        'evaluation.html.j2', evaluations=evaluations, pictures=pictures, total=total,
        assessment=assessment, findings=findings(RULES, total),
        notices=_notices(evaluations), several=len(evaluations) > 1,
        predictions=sum(one.counts.get('predicted', 0) for one in evaluations),
        tables=evaluation_tables, methods=methods_of(total), command=command,
        parameters=parameters)
    figures = {f'figures/{picture.name}.svg': picture.svg for picture in sum(pictures, [])}
    write_files(folder, {**figures, 'report.html': page})


def _notices(evaluations: Sequence[Evaluation]) -> list[str]:
    """Return the warnings of all recordings, with the recording's name if there are several."""
    return [f'{evaluation.name}: {notice}' if len(evaluations) > 1 else str(notice)
            for evaluation in evaluations for notice in evaluation.notices]


def _file_name(name: str) -> str:
    """Return a recording's name with the characters that are safe in files and addresses."""
    return re.sub(r'[^A-Za-z0-9]+', '_', name).strip('_')[:40] or 'recording'
