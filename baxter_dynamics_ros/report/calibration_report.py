"""The calibration report: one page."""

from pathlib import Path
import shlex

from . import calibration_figures, calibration_tables
from .calibration_findings import RULES
from .drawing import styled
from .findings import findings
from .page import render
from .term_names import MEANINGS, term_name
from ..calibration.calibration_results import Calibration
from ..files import write_file


def write_calibration(path: str | Path, calibration: Calibration, command: str,
                      parameters: str | None = None) -> None:
    """
    Write the report, whole or not at all.

    Parameters
    ----------
    path : Path
        The .html file; replaced if it exists.
    calibration : Calibration
        Result of the calibration.
    command : str
        Command line.
    parameters : str, optional
        Name of the parameter file; by default that of the report, with the suffix .yaml.

    Raises
    ------
    BaxterDynamicsError
        If it cannot be written. Then an existing file is unchanged.

    """
    path = Path(path)
    parameters = parameters or path.with_suffix('.yaml').name
    # Notices about all recordings before those about one.
    notices = sorted(calibration.notices, key=lambda notice: bool(notice.recording))
    with styled():
        page = render(
            'calibration.html.j2', calibration=calibration, warnings=list(map(str, notices)),
            findings=findings(RULES, calibration),
            meanings={term_name(step.term): MEANINGS.get(step.term, '')
                      for step in calibration.steps[1:]},
            figures=calibration_figures, tables=calibration_tables,
            command=command, parameters=parameters, file=shlex.quote(parameters))
    write_file(path, page)
