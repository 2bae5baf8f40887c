"""The calibration report: one page that holds all there is to know of a calibration."""

from pathlib import Path
import shlex
from typing import Any

from .calibration_findings import findings
from .calibration_tables import (gain_table, links_table, parameters_table, recordings_table,
                                 spring_table, steps_table)
from .calibration_terms import MEANINGS, term_name
from .gain_figures import gain_picture, steps_picture
from .model_figures import (friction_picture, has_friction, masses_picture,
                            parameters_picture, spring_picture)
from .page import render
from .robot_findings import remarks
from .tables import Table
from .. import __version__
from ..calibration.calibration_results import Calibration
from ..files import write_file
from ..model.joints import JOINTS, N_JOINTS
from ..recordings.notices import Notice

WARNINGS_SHOWN = 8  # the others are folded
_ROWS_SHOWN = 20  # a longer table of recordings is folded


def write_calibration(path: str | Path, calibration: Calibration, command: str,
                      parameters: str | None = None) -> None:
    """
    Write the report, whole or not at all.

    Parameters
    ----------
    path : Path
        The .html file; replaced if it is there.
    calibration : Calibration
        What was found.
    command : str
        The command that asked for it.
    parameters : str, optional
        The parameter file's name; by default that of the report, with the ending .yaml.

    Raises
    ------
    BaxterDynamicsError
        If it cannot be written. Then what was there before is still there.

    """
    path = Path(path)
    parameters = parameters or path.with_suffix('.yaml').name
    page = render(
        'calibration.html.j2', calibration=calibration, findings=findings(calibration),
        remarks=remarks(calibration), warnings_first=_general_first(calibration.notices),
        warnings_shown=WARNINGS_SHOWN, rows_shown=_ROWS_SHOWN,
        meanings=[(term_name(step.term), MEANINGS.get(step.term, ''))
                  for step in calibration.steps[1:]],
        **_tables(calibration), **_pictures(calibration),
        command=command, parameters=parameters, file=shlex.quote(parameters),
        version=__version__)
    write_file(path, page)


def _tables(calibration: Calibration) -> dict[str, Table | None]:
    links = calibration.of_term('inertial')
    others = [one for one in calibration.parameters if one.term != 'inertial']
    return {
        'gain': gain_table(calibration),
        'steps': steps_table(calibration),
        'recordings': recordings_table(calibration),
        'fitted': parameters_table(others) if others else None,
        'links': links_table(links) if links else None,
        'spring': spring_table(calibration),
    }


def _pictures(calibration: Calibration) -> dict[str, Any]:
    models = [settings.model.effort_model for settings in (calibration.before, calibration.after)]
    rubs = [i for i in range(N_JOINTS) if any(has_friction(model, i) for model in models)]
    return {
        'gain_picture': gain_picture('gain', calibration),
        'steps_pictures': [steps_picture(f'steps_{joint}', calibration, i)
                           for i, joint in enumerate(JOINTS)],
        'parameters_picture': parameters_picture('parameters', calibration),
        'spring_picture': spring_picture('spring', calibration),
        'friction_pictures': [friction_picture(f'friction_{JOINTS[i]}', calibration, i)
                              for i in rubs],
        'masses_picture': masses_picture('masses', calibration),
        'dahl_length': models[1].dahl_length if models[1].has_dahl else None,
    }


def _general_first(notices: tuple[Notice, ...]) -> list[str]:
    """Return notices about all recordings before those about one."""
    return [str(notice) for notice in sorted(notices, key=lambda one: bool(one.recording))]
