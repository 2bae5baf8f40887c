"""baxter_dynamics: the command and its subcommands."""

import argparse
from collections.abc import Sequence
import importlib
import io
import shlex
import sys
from types import ModuleType
from typing import TYPE_CHECKING

from . import doctor
from .. import __version__
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import SIDES

if TYPE_CHECKING:
    _Commands = argparse._SubParsersAction[argparse.ArgumentParser]  # it has no public name

TERMS = ('bias', 'spring', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness', 'tilt')
TRAJECTORIES = ('circle', 'switch', 'lift')
LANGUAGES = ('c', 'python', 'numba', 'matlab', 'casadi', 'sympy', 'latex')
QUANTITIES = ('M', 'C', 'G', 'Cqd', 'MCG', 'tau', 'qdd', 'regressor', 'gradient', 'christoffel')


def main(arguments: Sequence[str] | None = None) -> int:
    """
    Run a subcommand.

    Returns
    -------
    int
        Exit code: 0, or 1 with the reason on stderr.

    """
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser().parse_args(arguments)
    options.command_line = shlex.join(['baxter_dynamics', *arguments])
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='backslashreplace')  # file names may hold what is no text
    try:
        return options.run(options)
    except BaxterDynamicsError as error:
        print(f'baxter_dynamics {options.command}: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='baxter_dynamics',
        description="Lagrange-Euler dynamics of the Baxter robot's arms, beside ROS 2.")
    parser.add_argument('--version', action='version', version=__version__)
    commands = parser.add_subparsers(dest='command', required=True)
    _add_demo(commands)
    _add_watch(commands)
    _add_experiment(commands)
    _add_evaluate(commands)
    _add_calibrate(commands)
    _add_export(commands)
    checks = commands.add_parser('doctor', help=doctor.SUMMARY)
    doctor.add_arguments(checks)
    checks.set_defaults(run=doctor.main)
    return parser


def _add_demo(commands: '_Commands') -> None:
    demo = commands.add_parser(
        'demo', help='run the predictor on a fake Baxter, and show what it finds',
        description='Start a fake Baxter and the predictor as processes of their own, compare '
        'what is predicted with what is measured, call both services, and save a picture.')
    demo.add_argument('--duration', type=_seconds, default=20.0, metavar='SECONDS',
                      help='how long to look (default: %(default)s)')
    demo.add_argument('--output', default='baxter_dynamics_demo.png', metavar='FILE',
                      help='the picture; its ending says which kind (default: %(default)s)')
    demo.add_argument('--arm', choices=SIDES, default='right')
    demo.set_defaults(run=lambda options: _load('demo', 'demo').run(
        options.arm, options.duration, options.output))


def _add_watch(commands: '_Commands') -> None:
    watch = commands.add_parser(
        'watch', help='look at a running torque_predictor, live in the terminal',
        description='Show what a running torque_predictor says, live: measured and predicted '
        'effort, residual, external effort, contact, rates and diagnostics. Where the output is '
        'no terminal, a line a second instead. Ctrl-C or q ends it.')
    watch.add_argument('--node', default='/torque_predictor', metavar='NAME',
                       help="the predictor's name with its namespace (default: %(default)s)")
    watch.add_argument('--arm', choices=SIDES, help='show this one only (default: all there are)')
    watch.add_argument('--topic', default='/robot/joint_states', metavar='NAME',
                       help='the joint states (default: %(default)s)')
    watch.add_argument('--rate', type=_redraws, default=10.0, metavar='HZ',
                       help='pictures a second (default: %(default)g)')
    watch.add_argument('--duration', type=_look, metavar='SECONDS',
                       help='how long to look (default: until Ctrl-C); with --once, how long to '
                       'wait at most (default: 10)')
    watch.add_argument('--once', action='store_true',
                       help='wait for data, print one view and end; exit code 1 where none comes')
    watch.add_argument('--save', metavar='FILE.svg',
                       help='in the end, save what is shown as a picture')
    watch.set_defaults(run=lambda options: _load('watch', 'demo').run(
        options.node, options.arm, options.topic, options.rate, options.duration, options.once,
        options.save))


def _add_experiment(commands: '_Commands') -> None:
    experiment = commands.add_parser(
        'experiment', help="record one of the paper's trajectories on the fake Baxter, and judge",
        description="Run one of the paper's trajectories, 3(a) circle, 3(b) switch or 3(c) lift, "
        'on the fake Baxter, record it as a rosbag2, and evaluate it. No robot is commanded.')
    experiment.add_argument('trajectory', choices=TRAJECTORIES)
    experiment.add_argument('-o', '--output', metavar='DIR',
                            help='new folder for the bag and the report '
                            '(default: baxter_experiment_TRAJECTORY)')
    experiment.add_argument('--rate', type=float, choices=(50.0, 100.0), default=100.0,
                            help="joint states a second; the paper's is 50 (default: 100)")
    experiment.add_argument('--duration', type=_seconds, metavar='SECONDS',
                            help='default: whole periods of the trajectory, about a minute')
    experiment.add_argument('--arm', choices=SIDES, default='right')
    experiment.add_argument('--seed', type=_seed, default=0, metavar='N',
                            help='of the noise (default: %(default)s)')
    experiment.set_defaults(run=lambda options: _load('experiment', 'demo').run(
        options.trajectory, options.output or f'baxter_experiment_{options.trajectory}',
        options.rate, options.duration, options.arm, options.seed, options.command_line))


def _add_evaluate(commands: '_Commands') -> None:
    evaluate = commands.add_parser(
        'evaluate', help='judge how well the model predicts recordings, as a report',
        description='Predict the effort in recordings by the code of the node, compare it with '
        'the effort that was measured, and write a report: report.html, its figures, '
        'summary.csv and summary.json.')
    _add_input(evaluate)
    evaluate.add_argument('-o', '--output', default='baxter_evaluation', metavar='DIR',
                          help="the report's folder (default: %(default)s)")
    evaluate.add_argument('--save-bag', metavar='OUT',
                          help='write a new bag: what the recording holds, and beside it the '
                          'predicted effort and the residual')
    evaluate.set_defaults(run=lambda options: _load('evaluate', 'offline').run(
        options.bags, options.output, options.arm, options.topic, options.params,
        options.save_bag, options.command_line))


def _add_calibrate(commands: '_Commands') -> None:
    calibrate = commands.add_parser(
        'calibrate', help='fit the effort model to recordings of your own robot',
        description='Fit bias, friction, spring, tilt and more to recordings of one arm, keep '
        'what makes recordings that were left out easier to predict, and write a parameter file '
        'for torque_predictor and evaluate, with a report beside it.')
    _add_input(calibrate, at_least='*')
    calibrate.add_argument('-o', '--output', metavar='FILE',
                           help='the parameter file (default: my_robot.yaml), its report beside '
                           'it with the ending .html; with --plan a new folder (default: '
                           'baxter_plan)')
    calibrate.add_argument('--inertial', action='store_true',
                           help="fit the links' inertial parameters, too, as far as bodies can "
                           'have them')
    calibrate.add_argument('--payload', action='store_true',
                           help="fit the tool's mass and centre of mass, too")
    calibrate.add_argument('--only', nargs='+', default=(), metavar='TERM',
                           choices=(*TERMS, 'inertial', 'payload'),
                           help='fit these alone, whatever they buy: '
                           + ', '.join((*TERMS, 'inertial', 'payload')))
    calibrate.add_argument('--plan', action='store_true',
                           help='no calibration: print an exciting motion of one minute, write it '
                           'to a file, and run it on the fake Baxter')
    calibrate.add_argument('--seed', type=_seed, default=0, metavar='N',
                           help='with --plan: of the noise (default: %(default)s)')
    calibrate.set_defaults(run=_calibrate)


def _calibrate(options: argparse.Namespace) -> int:
    if options.plan:
        if options.bags:
            raise BaxterDynamicsError('--plan takes no recordings: it makes one')
        return _load('plan', 'demo').run_plan(
            options.output or 'baxter_plan', options.arm or 'right', options.seed)
    if not options.bags:
        raise BaxterDynamicsError('name at least one recording, or --plan for how to make one')
    return _load('calibrate', 'offline').run(
        options.bags, options.output or 'my_robot.yaml', options.arm, options.topic,
        options.params, options.inertial, options.payload, options.only, options.command_line)


def _add_export(commands: '_Commands') -> None:
    export = commands.add_parser(
        'export', help='write the closed form in other languages, as files that stand alone',
        description='Write the dynamics of the arm in another language, as files that stand alone '
        "and say what they take and give. The arm's numbers are data in them.")
    export.add_argument('language', nargs='?', choices=LANGUAGES,
                        help='what to write; casadi and sympy are Python files for them')
    export.add_argument('-o', '--output', metavar='PATH',
                        help='the folder, or the file where there is but one (default: '
                        'baxter_dynamics_LANGUAGE)')
    export.add_argument('--quantities', metavar='LIST',
                        help='some of ' + ','.join(QUANTITIES) + ': M, C and G of the model, MCG '
                        'the three at once; Cqd the torque C qd; tau inverse, qdd forward '
                        'dynamics; regressor Y of tau = Y phi; gradient of tau by q and by qd; '
                        'christoffel the symbols h of C_ik = sum_m h_ikm qd_m '
                        '(default: M,C,G,MCG,tau)')
    export.add_argument('--params', metavar='FILE',
                        help='a parameter file of torque_predictor, whose payload, links and '
                        'gravity to take')
    export.add_argument('--base-parameters', action='store_true',
                        help='write nothing: print the base parameters and what they mean')
    export.set_defaults(run=lambda options: _load('export', 'export').run(
        options.language, options.output, options.quantities, options.params,
        options.base_parameters, options.command_line))


def _add_input(parser: argparse.ArgumentParser, at_least: str = '+') -> None:
    parser.add_argument('bags', nargs=at_least, metavar='BAG',
                        help='a rosbag2 (MCAP or SQLite), a ROS 1 bag, or an .npz file')
    parser.add_argument('--arm', choices=SIDES,
                        help='which arm (default: the only one in the recording)')
    parser.add_argument('--topic', help='the joint states (default: /robot/joint_states)')
    parser.add_argument('--params', metavar='FILE',
                        help='a parameter file of torque_predictor, such as a calibration')


def _load(module: str, extra: str) -> ModuleType:
    """Return a module of this folder; the error names the extra that brings what it needs."""
    try:
        return importlib.import_module(f'.{module}', __package__)
    except ImportError as error:
        raise BaxterDynamicsError(
            f'{error}. Without ROS, install the {extra} extra: pip install ".[{extra}]"; on a '
            'ROS machine: pip install what is missing, and rosdep for the rest') from None


def _seconds(text: str) -> float:
    value = float(text)
    if not 2.0 <= value <= 3600.0:
        raise argparse.ArgumentTypeError(f'expected 2 to 3600 seconds, got {text}')
    return value


def _redraws(text: str) -> float:
    value = float(text)
    if not 0.2 <= value <= 30.0:
        raise argparse.ArgumentTypeError(f'expected 0.2 to 30 Hz, got {text}')
    return value


def _look(text: str) -> float:
    value = float(text)
    if not 0.5 <= value <= 86400.0:
        raise argparse.ArgumentTypeError(f'expected 0.5 to 86400 seconds, got {text}')
    return value


def _seed(text: str) -> int:
    value = int(text)
    if not 0 <= value < 2 ** 31:
        raise argparse.ArgumentTypeError(f'expected 0 to 2147483647, got {text}')
    return value


if __name__ == '__main__':
    sys.exit(main())
