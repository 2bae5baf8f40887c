"""
Measure the error of the predicted effort in recordings.

Predicts the effort with the code of the node, compares it with the measured effort, and writes a
report: report.html, its figures, summary.csv and summary.json.
"""

import argparse
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
import shlex

from .options import add_recordings, NODE, output_path, read_inputs, resolved
from .terminal import progress, say, show_table
from ..model import BaxterDynamicsError, JOINTS
from ..recordings.advice import assess, Assessment
from ..recordings.evaluation_results import Evaluation, Statistics

_FOLDER = 'baxter_evaluation'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics evaluate``."""
    add_recordings(parser)
    parser.add_argument('-o', '--output', default=_FOLDER, metavar='DIR',
                        help='folder for the report (default: %(default)s)')
    parser.add_argument('--save-bag', metavar='OUT',
                        help='write the predicted effort, the residual with its deviation and the '
                        'external effort to a new bag')


def main(args: argparse.Namespace) -> int:
    """Evaluate recordings, print the errors of the prediction, and write the report."""
    from ..recordings.evaluate_recordings import Evaluator
    from ..recordings.bags import new_bag, save_predictions
    from ..report.evaluation_report import write_evaluation
    folder = output_path('--output', args.output, (), args.force, [*args.bags, *args.params])
    save_bag = resolved(args.save_bag) if args.save_bag else None
    if save_bag == folder:
        raise BaxterDynamicsError(f'--save-bag: {folder} is the folder of the report')
    settings, recordings = read_inputs(args)
    if save_bag is not None and len(recordings) > 1:
        raise BaxterDynamicsError(f'--save-bag: expected one recording, got {len(recordings)}')
    evaluator, evaluations = Evaluator(settings), []
    with new_bag(save_bag) if save_bag else nullcontext() as writer:
        for recording in recordings:
            with recording, progress(recording.count) as update:
                evaluations.append(evaluator.evaluate(
                    recording, lambda received: update(received, recording.name)))
                if writer is not None:
                    save_predictions(
                        recording, replace(settings, arm=recording.arm), writer, args.node)
        # Within, so that there is no new bag without a report.
        total = evaluator.total()
        place = [] if args.output == _FOLDER else ['-o', args.output]
        assessment = assess(total, evaluations, settings, _inputs(args),
                            shlex.join([*place, '--force']))
        _print(evaluations, total, assessment)
        write_evaluation(folder, evaluations, total, assessment, args.command_line,
                         ', '.join(Path(path).name for path in args.params)
                         or 'defaults of the package')
    if writer is not None:
        say(f'bag: {writer.path}')
    say(f'report: {folder / "report.html"}')
    return 0


def _inputs(args: argparse.Namespace) -> str:
    """Return the recordings and the options for reading them, as on a command line."""
    options = [('--arm', args.arm), ('--topic', args.topic),
               *(('--params', path) for path in args.params),
               ('--node', args.node if args.node != NODE else None)]
    words = [word for option, value in options if value for word in (option, value)]
    return shlex.join(map(str, (*args.bags, *words)))


def _print(evaluations: list[Evaluation], total: Statistics, assessment: Assessment) -> None:
    say(assessment.verdict.text)
    if assessment.advice:
        say('', 'What to do next:')
    for i, advice in enumerate(assessment.advice, 1):
        say(f'{i}. {advice.text}')
        if advice.command:
            say(f'       {advice.command}')
    say('')
    for evaluation in evaluations:
        for notice in evaluation.notices:
            if len(evaluations) > 1 or notice.finding not in assessment.verdict.text:
                say(f'warning: {evaluation.name}: {notice}')
    if (errors := total.methods.get('lagrange_euler')) is None:
        return
    say(f'{errors.count} predictions compared; e = measured - predicted effort '
        '(Lagrange-Euler) [N m]')
    columns = {'RMS': errors.rms, 'mean |e|': errors.mean_abs, 'signed mean': errors.signed_mean,
               'correlation': errors.correlation}
    if total.expected is not None:
        columns['expected\ndeviation'] = total.expected.deviation
        columns['within 1.96\ndeviations'] = total.expected.coverage
    show_table(('joint', *columns), zip(JOINTS, *columns.values()))
