"""Search for the exciting trajectory: workspace limits and identifiability of parameters."""

from baxter_dynamics_ros.model.arm import BaxterArm
from baxter_dynamics_ros.model.arrays import Array
from baxter_dynamics_ros.model.base_parameters import fixed_to_link
from baxter_dynamics_ros.model.effort import EffortModel, Presliding
from baxter_dynamics_ros.model.joints import (JOINTS, mount, N_JOINTS, POSITION_LOWER,
                                              POSITION_UPPER, S1, VELOCITY_LIMIT)
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.simulation.exciting_trajectory import DURATION, motion, Series
import numpy as np

# Joint limits of the motion.
LOWER, UPPER = POSITION_LOWER + 0.1, POSITION_UPPER - 0.1  # [rad]
SPEED = 0.6 * VELOCITY_LIMIT  # [rad/s]
ACCELERATION = 6.0  # [rad/s^2]
S1_SWEEP = (-1.8, 0.94)  # range of s1, within the spring range of -1.9 to 1.0 [rad]

# Workspace limits in the robot's base frame [m].
TABLE = -0.35  # minimum height
MIDDLE = 0.05  # minimum distance from the plane between the arms
FRONT, OUTSIDE = 0.27, 0.40  # x in front of the torso, y beside it, for forearm and hand
HEAD, HEAD_DISTANCE = 0.05, 0.3  # x of the head, minimum distance from it
SHOULDER_DISTANCE = 0.25  # minimum distance of wrist, hand and tool from the shoulder
TOOL = 0.15  # length of a tool

_STEP = 4  # samples between two rows of a design matrix in the search
_MARGIN = 0.02  # [m] that the search keeps beyond the clearances

_TIME = np.arange(0.0, DURATION + 0.025, 0.05)  # sample times [s]
_ARM = BaxterArm(mount=mount('right'), engine='python')


def clearance(q: Array) -> Array:
    """
    Return the clearance of the right arm at q (n, 7) from the workspace limits, (n,) [m].

    It is negative outside the limits. The points checked are elbow, middle of the forearm, wrist,
    middle of wrist and hand, hand, and tip of the tool. The torso is modelled as a box, the head
    as a column, the shoulder as a ball, each enlarged by the link radius of 0.06 m. No other
    collisions are checked.
    """
    frames = [_ARM.mount @ transform(_ARM.parameters, 0, link, q) for link in (1, 3, 5, 7)]
    shoulder, elbow, wrist, hand = (frame[:, :3, 3] for frame in frames)
    tool = hand + TOOL * frames[-1][:, :3, 2]
    fore = np.stack([(elbow + wrist) / 2, wrist, (wrist + hand) / 2, hand, tool], axis=1)
    x, y, z = np.moveaxis(np.concatenate([elbow[:, None], fore], axis=1), -1, 0)
    from_shoulder = np.linalg.norm(fore[:, 1:] - shoulder[:, None], axis=-1)
    return np.min([
        (-y - MIDDLE).min(axis=1),
        (z - TABLE).min(axis=1),
        (np.hypot(x - HEAD, y) - HEAD_DISTANCE).min(axis=1),
        np.maximum(x - FRONT, -y - OUTSIDE)[:, 1:].min(axis=1),
        (from_shoulder - SHOULDER_DISTANCE).min(axis=1)], axis=0)


def design(q: Array, qd: Array, qdd: Array, presliding: Array) -> dict[str, Array]:
    """
    Return the derivative (n, 7) of the effort by each calibration parameter along a motion (n, 7).

    Names are such as 'dahl_s0', 'gravity_x' or 'payload_mass'. At s1 the spring terms replace the
    stiffness, which is nearly collinear with them.
    """
    columns = {}
    one_joint = {'bias': np.ones_like(q), 'coulomb': np.tanh(qd / EffortModel.coulomb_velocity),
                 'viscous': qd, 'dahl': presliding, 'added_inertia': qdd, 'stiffness': q,
                 **{f'spring_{f.__name__}{n}': f(n * q) for f in (np.sin, np.cos)
                    for n in (1, 2)}}
    for name, effort in one_joint.items():
        for i, joint in enumerate(JOINTS):
            if (name != 'stiffness' or i != S1) and ('spring' not in name or i == S1):
                columns[f'{name}_{joint}'] = effort * (np.arange(N_JOINTS) == i)
    for i, axis in enumerate('xy'):  # of the base; effort is linear in gravity
        columns[f'gravity_{axis}'] = BaxterArm(gravity=np.eye(3)[i], mount=_ARM.mount).gravity(q)
    regressor = _ARM.regressor(q, qd, qdd)
    for i, name in enumerate(('moment_x', 'moment_y', 'moment_z', 'mass')):  # of the payload
        inertia = np.zeros((4, 4))  # effort is linear in it
        inertia[i, 3] = inertia[3, i] = 1.0
        load = fixed_to_link(_ARM.parameters, N_JOINTS - 1, inertia)
        columns[f'payload_{name}'] = regressor @ load[:regressor.shape[-1]]
    return columns


def presliding(q: Array) -> Array:
    """Return Dahl's state along densely sampled positions q (n, 7) [rad]."""
    state = Presliding(EffortModel.dahl_length)
    return np.array([state.update(row) for row in q])


def judge(columns: dict[str, Array]) -> tuple[float, dict[str, float]]:
    """
    Return measures of how well the parameters can be distinguished.

    The condition number of the design matrix, its columns scaled to length 1, and by name the
    share of a column, 0 to 1, that is independent of all other columns.
    """
    matrix = np.stack([column.ravel() for column in columns.values()], axis=-1)
    triangle = np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0), mode='r')
    own = 1.0 / np.linalg.norm(np.linalg.inv(triangle), axis=1)
    return np.linalg.cond(triangle), dict(zip(columns, own))


def search(seed: int = 2, evaluations: int = 10_000) -> Series:
    """
    Return a trajectory within the limits that identifies all parameters well.

    A (1+1) evolution strategy: a random change is kept if it lowers the condition number divided
    by the geometric mean of the independent shares. Rounding differs between machines, so the same
    seed may lead to another, equally good trajectory. An evaluation takes 25 ms.
    """
    random = np.random.default_rng(seed)
    best = _within_limits(_guess(random))
    cost, width = _cost(best), 1.0
    for _ in range(evaluations):
        candidate = _within_limits(_changed(best, random, width))
        new_cost = _cost(candidate)
        if new_cost < cost:
            best, cost, width = candidate, new_cost, min(1.3 * width, 1.5)
        else:
            width = max(0.98 * width, 0.03)
    return best


def _cost(series: Series) -> float:
    q, qd, qdd = motion(series, _TIME)
    short = np.maximum(_MARGIN - clearance(q[::2]), 0.0)  # [m]
    sweep = np.abs(np.array([q[:, S1].min(), q[:, S1].max()]) - S1_SWEEP).max()  # [rad]
    if short.any() or sweep > 0.01:
        return 1e6 * (1.0 + 10.0 * short.mean() + short.max() + sweep)
    rows = slice(None, None, _STEP)
    condition, own = judge(design(q[rows], qd[rows], qdd[rows], presliding(q)[rows]))
    return condition / np.exp(np.mean(np.log(list(own.values()))))


def _guess(random: np.random.Generator) -> Series:
    """Return slow swings with opposite s1 and e1, so that the hand stays in front."""
    center = np.array([0.0, -0.4, 0.2, 1.3, 0.0, 0.3, 0.0])
    harmonic = np.array([[2, 5, 9, 14, 20], [3, 6, 10, 15, 21], [2, 4, 8, 13, 19],
                         [3, 7, 11, 16, 22], [2, 6, 11, 17, 25], [4, 7, 12, 19, 27],
                         [3, 8, 13, 21, 28]])
    amplitude = np.outer([0.5, 1.2, 0.7, 0.8, 1.0, 0.8, 1.5], [1.0, 0.4, 0.3, 0.15, 0.1])
    phase = random.uniform(0.0, 2 * np.pi, harmonic.shape)
    phase[JOINTS.index('s1'), 0], phase[JOINTS.index('e1'), 0] = 0.0, np.pi
    return Series(center, harmonic, amplitude * np.sin(phase), amplitude * np.cos(phase))


def _changed(series: Series, random: np.random.Generator, width: float) -> Series:
    center, harmonic, sine, cosine = (array.copy() for array in series)
    scale = np.array([0.3, 0.3, 0.4, 0.4, 0.6, 0.5, 0.8])[:, None] / (1 + harmonic / 6) * width
    center += (random.random(N_JOINTS) < 0.35) * random.normal(0.0, 0.15 * width, N_JOINTS)
    chosen = random.random(sine.shape) < 0.2
    sine += chosen * scale * random.standard_normal(sine.shape)
    cosine += chosen * scale * random.standard_normal(cosine.shape)
    step = (random.random(harmonic.shape) < 0.03) * random.integers(-2, 3, harmonic.shape)
    return Series(center, np.clip(harmonic + step, 1, 30), sine, cosine)


def _within_limits(series: Series) -> Series:
    """Return the series, scaled and shifted so that each joint stays within its limits."""
    center, harmonic, sine, cosine = series
    q, qd, qdd = motion(series, _TIME)
    up, down = (q - center).max(axis=0), (center - q).max(axis=0)
    scale = np.minimum.reduce([np.ones(N_JOINTS), 0.97 * SPEED / np.abs(qd).max(axis=0),
                               0.95 * ACCELERATION / np.abs(qdd).max(axis=0),
                               0.99 * (UPPER - LOWER) / (up + down)])
    scale[S1] = min((S1_SWEEP[1] - S1_SWEEP[0]) / (up + down)[S1],
                    0.97 * SPEED[S1] / np.abs(qd[:, S1]).max())
    center = np.clip(center, LOWER + 0.003 + scale * down, UPPER - 0.003 - scale * up)
    center[S1] = S1_SWEEP[1] - scale[S1] * up[S1]
    return Series(center, harmonic, scale[:, None] * sine, scale[:, None] * cosine)
