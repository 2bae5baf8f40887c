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
    Write summary.csv and summary.json; then draw and write figures/*.svg and report.html.

    Parameters
    ----------
    folder : Path
        Created if missing; other files in it stay.
    evaluations : sequence of Evaluation
        At least one, each of one recording.
    total : Total or Evaluation
        Over all recordings; the Evaluation itself if there is one.
    command : str
        Command line that made them.
    parameters : str
        Name of the parameter file, or 'defaults of the package'.

    Raises
    ------
    BaxterDynamicsError
        If a file cannot be written.

    """
    write_files(folder, {
        'summary.json': encoded(summary_json(evaluations, total, command, parameters)),
        # The byte order mark tells spreadsheets that the file is UTF-8.
        'summary.csv': b'\xef\xbb\xbf' + encoded(summary_csv(evaluations))})
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
    write_files(folder, {**figures, 'report.html': page})


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
