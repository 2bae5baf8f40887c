"""evaluate: how well the model predicts recordings, as a report to look at."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from .outputs import output_folder
from .progress import watched
from ..estimation.predictor import Prediction
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import BASE_FRAME, joint_names, JOINTS
from ..recordings.evaluate_recordings import Evaluator
from ..recordings.evaluation_results import Evaluation
from ..recordings.parameter_file import NODE, read_parameters
from ..recordings.playback import Block
from ..recordings.reader import open_recordings
from ..recordings.writer import BagWriter
from ..report.evaluation_report import Total, write_evaluation

# Where --save-bag puts what the node would publish.
PREDICTED_EFFORT = f'/{NODE}/predicted_effort'
EFFORT_RESIDUAL = f'/{NODE}/effort_residual'


def run(bags: Sequence[str | Path], output: str | Path, arm: 'str | None', topic: 'str | None',
        params: 'str | None', save_bag: 'str | None', command: str) -> int:
    """
    Evaluate recordings, print how well they are predicted, and write the report.

    Parameters
    ----------
    bags : sequence of str
        Bags and .npz files.
    output : str
        The report's folder.
    arm, topic : str or None
        Which arm and topic; None for the only ones.
    params : str or None
        A parameter file, such as a calibration's; None for the defaults of the package.
    save_bag : str or None
        A new bag for what was predicted, beside what the recording holds.
    command : str
        The command line, for the report.

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
    folder = output_folder('--output', output)
    if save_bag and Path(save_bag).expanduser().resolve() == folder:
        raise BaxterDynamicsError(f'--save-bag: {folder} is where the report goes')
    values = read_parameters(params) if params else {}
    if arm and values.get('arm', arm) != arm:
        console.print(f"warning: the parameters are of the {values['arm']} arm: friction, bias "
                      'and tilt belong to one arm', soft_wrap=True, highlight=False)
    recordings = open_recordings([Path(bag).expanduser() for bag in bags], topic,
                                 arm or values.get('arm'))
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(map(str, bags))}: no recordings')
    if save_bag and len(recordings) > 1:
        raise BaxterDynamicsError(
            f'--save-bag: one recording at a time, not {len(recordings)}')
    evaluator, evaluations = Evaluator(values), []
    with ExitStack() as stack:
        writer = None
        if save_bag:
            writer = stack.enter_context(BagWriter(
                Path(save_bag).expanduser(), reserved=(PREDICTED_EFFORT, EFFORT_RESIDUAL)))
        for recording in recordings:
            with recording, watched(recording, console, writer) as played:
                sink = None if writer is None else _sink(writer, recording.arm)
                evaluations.append(evaluator.evaluate(played, sink))
        # Within, so that there is no new bag without a report.
        total: Total | Evaluation = evaluations[0]
        if len(evaluations) > 1:
            total = Total(', '.join(sorted({e.arm for e in evaluations})), *evaluator.totals())
        write_evaluation(folder, evaluations, total, command,
                         Path(params).name if params else 'defaults of the package')
    _print(console, evaluations, total)
    if writer is not None:
        for topic_, reason in writer.skipped.items():
            console.print(f'not copied: {topic_}: {reason}', soft_wrap=True, highlight=False)
        console.print(f'bag: {writer.path}', soft_wrap=True, highlight=False)
    console.print(f'report: {folder / "report.html"}', soft_wrap=True, highlight=False)
    return 0


def _sink(writer: BagWriter, arm: str) -> Callable[[Block, Prediction], None]:
    """Return a function that writes predictions as the node publishes them."""
    names = joint_names(arm)

    def write(block: Block, prediction: Prediction) -> None:
        residuals = prediction.residual
        assert residuals is not None  # in a block it is NaN instead
        for received, stamp, q, qd, effort, residual in zip(
                block.received_ns.tolist(), prediction.stamp_ns.tolist(), prediction.q,
                prediction.qd, prediction.effort, residuals):
            writer.joint_state(PREDICTED_EFFORT, stamp, names, q, qd, effort, received,
                               BASE_FRAME)
            if residual[0] == residual[0]:  # NaN where no effort was measured
                writer.joint_state(EFFORT_RESIDUAL, stamp, names, q, qd, residual, received,
                                   BASE_FRAME)
    return write


def _print(console: Console, evaluations: list[Evaluation], total: Total | Evaluation) -> None:
    for evaluation in evaluations:
        for warning in evaluation.warnings:
            console.print(f'warning: {evaluation.name}: {warning}', soft_wrap=True,
                          highlight=False)
    if not total.methods:
        console.print('no valid effort: nothing to compare with', soft_wrap=True)
        return
    errors = total.methods['lagrange_euler']
    console.print(f'{errors.count} predictions compared; e = measured - predicted effort '
                  '(Lagrange-Euler) [N m]', soft_wrap=True, highlight=False)
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column('joint')
    columns = {'RMS': errors.rms, 'mean |e|': errors.mean_abs, 'signed mean': errors.signed_mean,
               'correlation': errors.correlation}
    for title in columns:
        table.add_column(title, justify='right')
    for i, joint in enumerate(JOINTS):
        table.add_row(joint, *(f'{column[i]:.3f}' for column in columns.values()))
    console.print(table)
