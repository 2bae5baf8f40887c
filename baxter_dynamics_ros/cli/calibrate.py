"""calibrate: fit the effort model to recordings of one's own robot."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from .outputs import output_file
from .. import __version__
from ..calibration.calibrate_robot import calibrate
from ..calibration.calibration_results import Calibration
from ..model.joints import JOINTS
from ..recordings.parameter_file import read_parameters, write_parameters
from ..recordings.reader import open_recordings
from ..report.calibration_report import write_calibration


def run(bags: Sequence[str], output: str, arm: 'str | None', topic: 'str | None',
        params: 'str | None', inertial: bool, payload: bool, only: Sequence[str],
        command: str) -> int:
    """
    Fit, print what it bought, and write the parameter file and the report beside it.

    Parameters
    ----------
    bags : sequence of str
        Bags and .npz files of one arm.
    output : str
        The parameter file; the report gets its name with the ending .html.
    arm, topic : str or None
        Which arm and topic; None for the only ones.
    params : str or None
        A parameter file to begin with; None for the defaults of the package.
    inertial, payload : bool
        Whether to fit the links' inertial parameters, and what the hand carries.
    only : sequence of str
        The terms to fit, whatever they buy; none for all that pay.
    command : str
        The command line, for the report and the head of the file.

    Returns
    -------
    int
        Exit code 0.

    Raises
    ------
    BaxterDynamicsError
        If something cannot be read, used or written.

    """
    console = Console()
    path = output_file('--output', output, ('.yaml', '.yml'))
    report = output_file('--output', path.with_suffix('.html'), ('.html',))
    values = read_parameters(params) if params else {}
    if arm and values.get('arm', arm) != arm:
        console.print(f"warning: the parameters are of the {values['arm']} arm: friction, bias "
                      'and tilt belong to one arm', soft_wrap=True, highlight=False)
    recordings = open_recordings([Path(bag).expanduser() for bag in bags], topic,
                                 arm or values.get('arm'))
    with ExitStack() as stack:
        for recording in recordings:
            stack.enter_context(recording)
        with console.status('') as status:
            result = calibrate(recordings, values, inertial, payload, only, status.update)
    comments = _comments(result, command)
    write_calibration(report, result, command, path.name)
    write_parameters(path, result.values, comments)
    _print(console, result)
    console.print(f'parameters: {path}', soft_wrap=True, highlight=False)
    console.print(f'report: {report}', soft_wrap=True, highlight=False)
    return 0


def _comments(result: Calibration, command: str) -> list[str]:
    """Return what a reader of the parameter file should know."""
    rows = [f'{joint}  {before:6.3f}  {after:6.3f}' for joint, before, after in zip(
        JOINTS, result.rms_before, result.rms_after)]
    kind = 'parts of the recording' if result.by_time else 'recordings'
    return [
        f'Calibration of the {result.arm} arm, by baxter_dynamics_ros {__version__}:', command,
        f'Fitted to {result.samples} samples, {result.duration:.0f} s. What is not here has its '
        'default.', '',
        f'Residual RMS [N m] on {kind} left out of the fit, before and after:', *rows,
        *([''] + [f'Warning: {warning}' for warning in result.warnings] if result.warnings
          else [])]


def _print(console: Console, result: Calibration) -> None:
    for warning in result.warnings:
        console.print(f'warning: {warning}', soft_wrap=True, highlight=False)
    if result.lag is not None:
        console.print(f'velocity lag: {1e3 * result.lag.value:.1f} ms', highlight=False)
    kind = 'parts of the recording' if result.by_time else 'recordings'
    console.print(f'residual RMS [N m] on {kind} left out of the fit; what each term bought '
                  'there, and where it was kept', soft_wrap=True, highlight=False)
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column('with', no_wrap=True)
    for joint in JOINTS:
        table.add_column(joint, justify='right')
    table.add_row('before', *(f'{x:.3f}' for x in result.rms_before))
    for step in result.steps[1:]:
        table.add_row('+ ' + step.term, *(f'{x:.3f}' if i in step.joints else '.'
                                          for i, x in enumerate(step.rms)))
    table.add_row('after', *(f'{x:.3f}' for x in result.rms_after), style='bold')
    console.print(table)
