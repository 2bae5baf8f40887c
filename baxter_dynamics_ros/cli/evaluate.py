"""evaluate: how well the model predicts recordings, as a report to look at."""

import argparse
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from .inputs import read_inputs
from .options import add_force, add_recordings
from .outputs import output_folder
from .progress import watched
from ..estimation.settings import PredictorSettings
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS
from ..recordings.evaluate_recordings import Evaluator
from ..recordings.evaluation_results import Evaluation
from ..recordings.writer import BagWriter, save_predictions
from ..report.evaluation_report import Total, write_evaluation

DESCRIPTION = (
    'Predict the effort in recordings with the code of the node, compare it with the measured '
    'effort, and write a report: report.html, its figures, summary.csv and summary.json.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics evaluate``."""
    add_recordings(parser)
    parser.add_argument('-o', '--output', default='baxter_evaluation', metavar='DIR',
                        help='folder for the report (default: %(default)s)')
    parser.add_argument('--save-bag', metavar='OUT',
                        help='write the predicted effort, the residual and the external effort '
                        'to a new bag')
    add_force(parser)


def main(args: argparse.Namespace) -> int:
    """Evaluate recordings, print the errors of the prediction, and write the report."""
    console = Console()
    folder = output_folder('--output', args.output, args.force, [*args.bags, *args.params])
    if args.save_bag and Path(args.save_bag).expanduser().resolve() == folder:
        raise BaxterDynamicsError(f'--save-bag: {folder} is where the report goes')
    values, recordings = read_inputs(args, console)
    if args.save_bag and len(recordings) > 1:
        raise BaxterDynamicsError(
            f'--save-bag: one recording at a time, not {len(recordings)}')
    evaluator, evaluations = Evaluator(values), []
    with ExitStack() as stack:
        writer = None
        if args.save_bag:
            writer = stack.enter_context(BagWriter(Path(args.save_bag).expanduser()))
        for recording in recordings:
            with recording, watched(recording, console) as played:
                evaluation = evaluator.evaluate(played)
                evaluations.append(replace(
                    evaluation, warnings=(*recording.remarks, *evaluation.warnings)))
                if writer is not None:
                    settings = PredictorSettings({**values, 'arm': recording.arm})
                    save_predictions(recording, settings, writer, args.node)
        # Within, so that there is no new bag without a report.
        total: Total | Evaluation = evaluations[0]
        if len(evaluations) > 1:
            total = Total(', '.join(sorted({e.arm for e in evaluations})), *evaluator.totals())
        _print(console, evaluations, total)
        write_evaluation(folder, evaluations, total, args.command_line,
                         ', '.join(Path(path).name for path in args.params)
                         or 'defaults of the package')
    if writer is not None:
        console.print(f'bag: {writer.path}', soft_wrap=True, highlight=False)
    console.print(f'report: {folder / "report.html"}', soft_wrap=True, highlight=False)
    return 0


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
