"""calibrate --plan: the exciting trajectory, run on the fake Baxter and written to files."""

import argparse

import numpy as np

from .experiment import BAG, record_bag
from .paths import new_folder
from .terminal import say, show_table
from ..model.joints import joint_names
from ..simulation.exciting_trajectory import LimitedMotion
from ..simulation.plan_file import write_plan, write_trajectory
from ..simulation.robot import FakeBaxter
from ..simulation.trajectories import JointTrajectory

PLAN, TRAJECTORY = 'plan.csv', 'trajectory.json'  # in the output folder
_RATE = 100.0  # of the recording [Hz]
_REST = 1.0  # [s] recorded after the end, until the arm is at rest


def plan(args: argparse.Namespace) -> int:
    """Print the exciting trajectory, record it on the fake Baxter, and write it to files."""
    folder = new_folder(args.output or 'baxter_plan')
    arm = args.arm or 'right'
    motion = LimitedMotion(arm, args.max_velocity or np.inf)
    _describe(arm, motion)
    robot = FakeBaxter(arm, 'exciting', seed=args.seed)
    robot.reference = JointTrajectory(lambda t: motion(t)[0])
    record_bag(folder / BAG, robot, motion.duration + _REST, _RATE, args.seed)
    write_plan(folder / PLAN, arm, motion)
    write_trajectory(folder / TRAJECTORY, arm, motion)
    say(f"for the SDK's joint_trajectory_file_playback.py: {folder / PLAN}",
        f'trajectory_msgs/JointTrajectory for FollowJointTrajectory: {folder / TRAJECTORY}',
        'Keep 1.2 m around the arm clear, and move both arms to the first waypoint by hand: '
        'the move to the first waypoint is not collision-checked.')
    return 0


def _describe(arm: str, motion: LimitedMotion) -> None:
    q, qd, qdd = motion(np.arange(0.0, motion.duration, 0.01))
    turns = (np.diff(np.sign(qd[1:]), axis=0) != 0).sum(axis=0)
    say(f'exciting trajectory, {motion.duration:.0f} s, from rest to rest')
    columns = {'from, rad': q.min(axis=0), 'to, rad': q.max(axis=0),
               'speed, rad/s': np.abs(qd).max(axis=0),
               'acceleration, rad/s²': np.abs(qdd).max(axis=0)}
    show_table(('joint', *columns, 'reversals'), [
        (joint, *(f'{column[i]:.2f}' for column in columns.values()), str(turns[i]))
        for i, joint in enumerate(joint_names(arm))])
