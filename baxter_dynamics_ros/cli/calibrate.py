"""
Fit the effort model to recordings of one arm.

Fits bias, friction, spring, tilt and more, keeps the terms that improve the prediction of
recordings left out of the fit, and writes a parameter file for torque_predictor and evaluate,
with a report beside it.
"""

import argparse
from contextlib import ExitStack

from .options import add, add_recordings, number, output_path, read_inputs
from .terminal import progress, say, show_table
from .. import __version__
from ..calibration.calibration_results import Calibration
from ..calibration.terms import OPTIONAL, TERMS
from ..model import BaxterDynamicsError, joint_names, JOINTS

_FITTING = *OPTIONAL, 'only', 'params', 'topic', 'force'  # options that --plan does not use
_PLANNING = 'max_velocity', 'seed'  # options that only --plan uses
_RATE = 100.0  # of the recording of --plan [Hz]
_REST = 1.0  # [s] recorded after the end of the trajectory, until the arm is at rest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics calibrate``."""
    add_recordings(parser, nargs='*')
    parser.add_argument('-o', '--output', metavar='FILE',
                        help='parameter file (default: my_robot.yaml); the report gets the same '
                        'name with .html. With --plan: new folder (default: baxter_plan)')
    parser.add_argument('--inertial', action='store_true',
                        help='also fit the inertial parameters of the links, within physical '
                        'limits')
    parser.add_argument('--payload', action='store_true',
                        help='also fit the mass and the centre of mass of a payload')
    parser.add_argument('--only', nargs='+', default=(), metavar='TERM',
                        choices=(*TERMS, *OPTIONAL),
                        help='fit these terms only, whether or not they improve the prediction: '
                        + ', '.join((*TERMS, *OPTIONAL)))
    parser.add_argument('--plan', action='store_true',
                        help='write an exciting trajectory of one minute and run it on the fake '
                        'Baxter, instead of calibrating')
    parser.add_argument('--max-velocity', type=number(0.1, 10.0, 'rad/s'), metavar='RAD/S',
                        help='with --plan: maximum joint velocity, such as 0.4 for robots that '
                        'abort faster motion (default: 2.1, the original)')
    add(parser, '--seed', help='with --plan: seed of the sensor noise (default: %(default)s)')


def main(args: argparse.Namespace) -> int:
    """Fit the effort model, print the improvement, and write the parameter file and the report."""
    if args.plan == bool(args.bags):
        raise BaxterDynamicsError('--plan takes no recordings' if args.plan else
                                  'expected a recording, or --plan to make one')
    for name in _FITTING if args.plan else _PLANNING:
        if getattr(args, name):
            raise BaxterDynamicsError(f'--{name.replace("_", "-")} is '
                                      f'{"not used" if args.plan else "used only"} with --plan')
    if args.plan:
        return _plan(args)
    from ..calibration.calibrate_robot import calibrate
    from ..recordings.parameter_file import write_parameters
    from ..report.calibration_report import write_calibration
    inputs = [*args.bags, *args.params]
    path = output_path('--output', args.output or 'my_robot.yaml', ('.yaml', '.yml'), args.force,
                       inputs)
    report = output_path('--output', path.with_suffix('.html'), ('.html',), args.force, inputs)
    settings, recordings = read_inputs(args)
    with ExitStack() as stack, progress() as update:
        for recording in recordings:
            stack.enter_context(recording)
        result = calibrate(recordings, settings, args.inertial, args.payload, args.only,
                           lambda text: update(0.0, text))
    write_parameters(path, result.after, _comments(result, args.command_line))
    _print(result)
    say(f'parameters: {path}')
    write_calibration(report, result, args.command_line, path.name)
    say(f'report: {report}')
    return 0


def _comments(result: Calibration, command: str) -> list[str]:
    """Return the comment at the top of the parameter file."""
    rows = [f'{joint}  {before:6.3f}  {after:6.3f}' for joint, before, after in zip(
        JOINTS, result.total.before, result.total.after)]
    return [
        f'Calibration of the {result.before.arm} arm, by baxter_dynamics_ros {__version__}:',
        command,
        f'Fitted to {result.samples} samples, {result.total.duration:.0f} s. Other parameters '
        'have their defaults.', '',
        f'Residual RMS [N m] on {result.left_out}, before and after:', *rows,
        *([''] + [f'Warning: {notice}' for notice in result.notices] if result.notices else [])]


def _print(result: Calibration) -> None:
    for notice in result.notices:
        say(f'warning: {notice}')
    if result.lag is not None:
        say(f'velocity lag: {1e3 * result.lag.value:.1f} ms')
    say(f'residual RMS [N m] on {result.left_out}, after adding each term to the joints that it '
        'improves; outliers count less in the rows of terms')
    show_table(('term', *JOINTS), [
        ('before', *result.total.before),
        *(('+ ' + step.term, *(x if i in step.joints else '.' for i, x in enumerate(step.rms)))
          for step in result.steps[1:]),
        ('after', *result.total.after)], bold_last=True)


def _plan(args: argparse.Namespace) -> int:
    """Print the exciting trajectory, record it on the fake Baxter, and write it to files."""
    import numpy as np
    from .experiment import BAG, record_bag
    from ..simulation.exciting_trajectory import LimitedMotion, write_plan, write_trajectory
    from ..simulation.robot import FakeBaxter
    from ..simulation.trajectories import JointTrajectory
    folder = output_path('--output', args.output or 'baxter_plan', force=None)
    arm = args.arm or 'right'
    motion = LimitedMotion(arm, args.max_velocity or np.inf)
    q, qd, qdd = motion(np.arange(0.0, motion.duration, 0.01))
    say(f'exciting trajectory, {motion.duration:.0f} s, from rest to rest')
    show_table(
        ('joint', 'from, rad', 'to, rad', 'speed, rad/s', 'acceleration, rad/s²', 'reversals'),
        zip(joint_names(arm), q.min(axis=0), q.max(axis=0), np.abs(qd).max(axis=0),
            np.abs(qdd).max(axis=0), (np.diff(np.sign(qd[1:]), axis=0) != 0).sum(axis=0)), 2)
    robot = FakeBaxter(arm, 'exciting', seed=args.seed)
    robot.reference = JointTrajectory(lambda t: motion(t)[0])
    record_bag(folder / BAG, robot, motion.duration + _REST, _RATE, args.seed)
    plan, trajectory = folder / 'plan.csv', folder / 'trajectory.json'
    write_plan(plan, arm, motion)
    write_trajectory(trajectory, arm, motion)
    say(f"for the SDK's joint_trajectory_file_playback.py: {plan}",
        f'trajectory_msgs/JointTrajectory for FollowJointTrajectory: {trajectory}',
        'Keep 1.2 m around the arm clear, and move both arms to the first waypoint beforehand: '
        'the move to it is not collision-checked.')
    return 0
