"""evaluate: how well the model predicts recordings, as a report to look at."""

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from .console import show_table
from .options import add_recordings
from .outputs import output_folder
from .printing import say
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


DESCRIPTION = (
    'Predict the effort in recordings with the code of the node, compare it with the measured '
    'effort, and write a report: report.html, its figures, summary.csv and summary.json.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics evaluate``."""
    add_recordings(parser)
    parser.add_argument('-o', '--output', default='baxter_evaluation', metavar='DIR',
                        help='folder for the report (default: %(default)s)')
    parser.add_argument('--save-bag', metavar='OUT',
                        help='write a new bag with the contents of the recording, the predicted '
                        'effort and the residual')


def main(args: argparse.Namespace) -> int:
    """Evaluate recordings, print the errors of the prediction, and write the report."""
    folder = output_folder('--output', args.output)
    if args.save_bag and Path(args.save_bag).expanduser().resolve() == folder:
        raise BaxterDynamicsError(f'--save-bag: {folder} is where the report goes')
    values = read_parameters(args.params) if args.params else {}
    if args.arm and values.get('arm', args.arm) != args.arm:
        say(f"warning: the parameters are of the {values['arm']} arm: friction, bias "
            'and tilt belong to one arm')
    recordings = open_recordings([Path(bag).expanduser() for bag in args.bags], args.topic,
                                 args.arm or values.get('arm'))
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(args.bags)}: no recordings')
    if args.save_bag and len(recordings) > 1:
        raise BaxterDynamicsError(
            f'--save-bag: one recording at a time, not {len(recordings)}')
    evaluator, evaluations = Evaluator(values), []
    with ExitStack() as stack:
        writer = None
        if args.save_bag:
            writer = stack.enter_context(BagWriter(
                Path(args.save_bag).expanduser(), reserved=(PREDICTED_EFFORT, EFFORT_RESIDUAL)))
        for recording in recordings:
            with recording, watched(recording, writer) as played:
                sink = None if writer is None else _sink(writer, recording.arm)
                evaluations.append(evaluator.evaluate(played, sink))
        # Within, so that there is no new bag without a report.
        total: Total | Evaluation = evaluations[0]
        if len(evaluations) > 1:
            total = Total(', '.join(sorted({e.arm for e in evaluations})), *evaluator.totals())
        write_evaluation(folder, evaluations, total, args.command_line,
                         Path(args.params).name if args.params else 'defaults of the package')
    _print(evaluations, total)
    if writer is not None:
        for topic_, reason in writer.skipped.items():
            say(f'not copied: {topic_}: {reason}')
        say(f'bag: {writer.path}')
    say(f'report: {folder / "report.html"}')
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


def _print(evaluations: list[Evaluation], total: Total | Evaluation) -> None:
    for evaluation in evaluations:
        for warning in evaluation.warnings:
            say(f'warning: {evaluation.name}: {warning}')
    if not total.methods:
        say('no valid effort: nothing to compare the prediction with')
        return
    errors = total.methods['lagrange_euler']
    say(f'{errors.count} predictions compared; e = measured - predicted effort '
        '(Lagrange-Euler) [N m]')
    columns = {'RMS': errors.rms, 'mean |e|': errors.mean_abs, 'signed mean': errors.signed_mean,
               'correlation': errors.correlation}
    show_table(('joint', *columns), [
        (joint, *(f'{column[i]:.3f}' for column in columns.values()))
        for i, joint in enumerate(JOINTS)])
