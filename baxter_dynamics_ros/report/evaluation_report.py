"""The evaluation report: a page to look at, its figures as files, and its numbers."""

from collections.abc import Sequence
from pathlib import Path
import re
from typing import NamedTuple

from .drawing import Picture
from .figures import COARSE, effort_picture, estimator_picture, FINE, terms_picture
from .findings import findings, remarks
from .page import encoded, render
from .summary import summary_csv, summary_json
from .tables import (check_table, estimators_table, recordings_table, size_table, Table,
                     table_five, terms_table)
from .. import __version__
from ..files import write_files
from ..model.arrays import Array
from ..model.joints import JOINTS
from ..recordings.evaluation_results import Errors, Evaluation


class Total(NamedTuple):
    """What was found over all recordings together; where there is one, it serves itself."""

    arm: str
    methods: Errors  # as of Evaluation
    estimators: Errors
    shares: dict[str, Array]


class Section(NamedTuple):
    """One recording's part of the page."""

    evaluation: Evaluation
    effort_pictures: list[Picture]  # one a joint; none where nothing was predicted
    acceleration_pictures: list[Picture]  # one a joint; none without measured effort
    terms_picture: 'Picture | None'
    check: 'Table | None'
    size: Table
    table_five: Table
    terms: 'Table | None'
    accelerations: Table

    @property
    def pictures(self) -> list[Picture]:
        """Return all of them."""
        pictures = [*self.effort_pictures, *self.acceleration_pictures, self.terms_picture]
        return [picture for picture in pictures if picture is not None]


def write_evaluation(folder: str | Path, evaluations: Sequence[Evaluation],
                     total: Total | Evaluation, command: str, parameters: str) -> None:
    """
    Write report.html, summary.csv, summary.json and figures/*.svg.

    Parameters
    ----------
    folder : Path
        Made where it is missing; what else is in it stays.
    evaluations : sequence of Evaluation
        One a recording, at least one.
    total : Total
        Over all recordings; the single Evaluation where there is one.
    command : str
        The command that asked for it.
    parameters : str
        The parameter file's name, or 'defaults of the package'.

    Raises
    ------
    BaxterDynamicsError
        If something cannot be written. Then what was there before is still there.

    """
    sections = [_section(i, evaluation) for i, evaluation in enumerate(evaluations, 1)]
    addresses = [f'#recording-{i}' for i in range(1, len(sections) + 1)]
    page = render(
        'evaluation.html.j2', sections=sections, total=total, findings=findings(total),
        remarks=remarks(total),
        size=size_table(total, 'the whole recording' if len(sections) == 1 else 'all recordings'),
        recordings=recordings_table(evaluations, addresses),
        seconds=sum(evaluation.duration for evaluation in evaluations),
        predictions=sum(evaluation.counts.get('predicted', 0) for evaluation in evaluations),
        command=command, parameters=parameters, version=__version__)
    figures = {f'figures/{picture.name}.svg': picture.svg
               for section in sections for picture in section.pictures}
    numbers = summary_json(evaluations, total, command, parameters)
    write_files(folder, {
        **figures,
        'summary.json': encoded(numbers),
        # The mark tells spreadsheets that it is UTF-8.
        'summary.csv': b'\xef\xbb\xbf' + encoded(summary_csv(evaluations)),
        'report.html': page,
    })


def _section(number: int, evaluation: Evaluation) -> Section:
    """Draw one recording, the first one more finely: its figures are seen at once."""
    intervals = FINE if number == 1 else COARSE
    start = f'{number:02d}_{_file_name(evaluation.name)}'
    return Section(
        evaluation,
        [effort_picture(f'{start}_effort_{joint}', evaluation, i, intervals)
         for i, joint in enumerate(JOINTS) if evaluation.shares],
        [estimator_picture(f'{start}_acceleration_{joint}', evaluation, i, intervals)
         for i, joint in enumerate(JOINTS) if evaluation.estimators],
        terms_picture(f'{start}_terms', evaluation.shares) if evaluation.shares else None,
        check_table(evaluation.check) if evaluation.check else None,
        size_table(evaluation, 'this recording'), table_five(evaluation, 'this recording'),
        terms_table(evaluation.shares) if evaluation.shares else None,
        estimators_table(evaluation))


def _file_name(name: str) -> str:
    """Return a recording's name without what a file name or an address may not have."""
    return re.sub(r'[^A-Za-z0-9]+', '_', name).strip('_')[:40] or 'recording'
