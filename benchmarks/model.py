"""
Compare the speed of BaxterArm, compiled and in Python, with Pinocchio and MuJoCo in one table.

All engines have the same parameters and must agree within 1e-9 before they are timed. Their runs
alternate, so that a busy machine slows all of them. Run: python benchmarks/model.py [--quick]
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
import gc
import os
from pathlib import Path
import platform
from statistics import median
import subprocess
import sys
from time import perf_counter
from typing import NamedTuple

os.environ.update(dict.fromkeys(('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS'), '1'))

from baxter_dynamics_ros import BaxterArm  # noqa: E402, I100
from baxter_dynamics_ros.model import joints, lagrange_euler  # noqa: E402
import numpy as np  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

TOLERANCE = 1e-9  # largest difference; accelerations are compared by their torques [N m]
BASE = 'Pinocchio'
TITLES = {'tau': 'tau, one state', 'terms': 'M, C, G, one state', 'forward': 'qdd, one state',
          'batch': 'tau, {:,} states', 'threads': 'tau, {:,} states, two threads'}
IMPORT = """
import time, numpy
start = time.perf_counter()
from baxter_dynamics_ros import BaxterArm
BaxterArm().inverse_dynamics(*numpy.zeros((3, 7)))
print(time.perf_counter() - start)
"""


class Call(NamedTuple):
    """One call of one engine."""

    kind: str  # of TITLES
    engine: str
    run: Callable  # function of states (7,) or (n, 7)
    result: Callable  # maps the return value to the compared arrays


def main() -> int:
    """Print the table; return 1 if a call does not agree."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--quick', action='store_true', help='check that everything runs')
    quick = parser.parse_args().quick
    n, rounds, batch_rounds, loop = (2000, 3, 3, 5) if quick else (100_000, 100, 15, 100)
    arms = {engine: BaxterArm(engine=engine) for engine in ('compiled', 'python')}
    calls = [*(call for name, arm in arms.items() for call in ours(f'BaxterArm, {name}', arm)),
             *pinocchio(arms['python']), *mujoco(arms['python'])]
    rejected = [call for call in calls if not difference(call, arms['python']) <= TOLERANCE]
    for call in rejected:
        print(f'{call.engine} {call.kind}: differs, not timed')
    calls = [call for call in calls if call not in rejected]
    print(f'{processor()}, Python {platform.python_version()}, NumPy {np.__version__}. Medians of '
          'alternating runs.\nOne state: time over that of Pinocchio; batches: rate over that of '
          'rneaInParallel on one thread.\n')
    print(f'| {"":30} | {"engine":19} | us a state | ratio |\n|---|---|--:|--:|')
    single = [call for call in calls if call.kind in ('tau', 'terms', 'forward')]
    many = [call for call in calls if call not in single]
    table(single, list(zip(*states(loop))), rounds, 1)
    table(many, [states(n)], batch_rounds, n)
    starts = [float(subprocess.run([sys.executable, '-c', IMPORT], check=True, text=True,
                                   capture_output=True).stdout) for _ in range(2 if quick else 7)]
    print(f'\nImport and first call beyond NumPy: {median(starts):.3f} s')
    return bool(rejected)


def states(n: int) -> tuple:
    """Return n states q, qd, qdd, each (n, 7), within the arm's limits; the same every time."""
    rng = np.random.default_rng(20)
    return (rng.uniform(joints.POSITION_LOWER, joints.POSITION_UPPER, (n, 7)),
            rng.uniform(-1.0, 1.0, (n, 7)) * joints.VELOCITY_LIMIT,
            rng.uniform(-5.0, 5.0, (n, 7)))  # [rad/s^2]


def ours(name: str, arm: BaxterArm) -> list:
    """Return the calls of BaxterArm."""
    calls = [Call('tau', name, arm.inverse_dynamics, np.array),
             Call('terms', name, lambda q, qd, qdd: arm.terms(q, qd), summed),
             Call('forward', name, arm.forward_dynamics, np.array),
             Call('batch', name, arm.inverse_dynamics, np.array)]
    if arm.engine == 'compiled':
        pool = ThreadPoolExecutor(2)

        def threads(*arrays):
            half = len(arrays[0]) // 2
            parts = [pool.submit(arm.inverse_dynamics, *(x[part] for x in arrays))
                     for part in (slice(half), slice(half, None))]
            return [part.result() for part in parts]
        calls.append(Call('threads', name, threads, np.concatenate))
    return calls


def pinocchio(arm: BaxterArm) -> list:
    """Return the calls of Pinocchio with the same parameters; none if it is not installed."""
    try:
        import pinocchio as pin
    except ImportError as error:
        print(f'Pinocchio is not installed: {error}')
        return []
    from baxter_dynamics_ros.newton_euler import build_model
    model = build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount)
    data = model.createData()

    def terms(q, qd, qdd):
        return (pin.crba(model, data, q), pin.computeCoriolisMatrix(model, data, q, qd),
                pin.computeGeneralizedGravity(model, data, q))

    calls = [Call('tau', BASE, partial(pin.rnea, model, data), np.array),
             Call('terms', BASE, terms, summed),
             Call('forward', BASE, partial(pin.aba, model, data), np.array)]
    if hasattr(pin, 'rneaInParallel'):
        pool, results = pin.ModelPool(model, 1), {}

        def batch(q, qd, qdd):
            tau = results.setdefault(len(q), np.empty(q.shape))
            pin.rneaInParallel(1, pool, q.T, qd.T, qdd.T, tau.T)
            return tau
        calls.append(Call('batch', BASE, batch, np.array))
    return calls


def mujoco(arm: BaxterArm) -> list:
    """Return the calls of MuJoCo with the same parameters; none if it is not installed."""
    try:
        import mujoco as mj
        from mujoco_model import mjcf
    except ImportError as error:
        print(f'MuJoCo is not installed: {error}')
        return []
    model = mj.MjModel.from_xml_string(mjcf(arm))
    data = mj.MjData(model)
    position, velocity, acceleration = data.qpos, data.qvel, data.qacc
    applied, inverse = data.qfrc_applied, data.qfrc_inverse

    def tau(q, qd, qdd):
        position[:], velocity[:], acceleration[:] = q, qd, qdd
        mj.mj_inverse(model, data)
        return inverse

    def forward(q, qd, torque):
        position[:], velocity[:], applied[:] = q, qd, torque
        mj.mj_forward(model, data)
        return acceleration

    return [Call('tau', 'MuJoCo', tau, np.array), Call('forward', 'MuJoCo', forward, np.array)]


def summed(terms: tuple) -> tuple:
    """Return M, completed from the upper triangle that crba computes, C and G."""
    mass, coriolis, gravity = terms
    return np.triu(mass) + np.triu(mass, 1).T, np.array(coriolis), np.array(gravity)


def difference(call: Call, arm: BaxterArm) -> float:
    """Return the largest difference between a call and the equations of the paper [N m]."""
    q, qd, qdd = states(20)
    tau = lagrange_euler.inverse_dynamics(arm.parameters, q, qd, qdd, arm.gravity_vector)
    if call.kind in ('batch', 'threads'):
        return np.abs(call.result(call.run(q, qd, qdd)) - tau).max()
    worst = []
    for state, torque in zip(zip(q, qd, qdd), tau):
        if call.kind == 'tau':
            worst.append(np.abs(call.result(call.run(*state)) - torque).max())
        elif call.kind == 'forward':
            error = call.result(call.run(*state[:2], torque)) - state[2]
            worst.append(np.abs(arm.mass_matrix(state[0]) @ error).max())
        else:
            mass, coriolis, gravity = call.result(call.run(*state))
            worst.append(np.abs(mass @ state[2] + coriolis @ state[1] + gravity - torque).max())
    return np.max(worst)


def table(calls: list, arguments: list, rounds: int, n: int) -> None:
    """Time calls in alternating runs and print their rows."""
    times = {call: [] for call in calls}
    gc.disable()
    for turn in range(-1, rounds):  # the first warms up
        for call in calls:
            start = perf_counter()
            for state in arguments:
                call.run(*state)
            if turn >= 0:
                times[call].append((perf_counter() - start) / len(arguments) / n)
    gc.enable()
    for kind, title in TITLES.items():
        bases = [t for call, t in times.items()
                 if (call.kind, call.engine) == (kind.replace('threads', 'batch'), BASE)]
        for call, each in times.items():
            if call.kind == kind:
                ratio = ''
                if bases:
                    over = median(np.divide(each, bases[0]))
                    ratio = f'{over:.2f}' if n == 1 else f'{1 / over:.1f}'
                print(f'| {title.format(n):30} | {call.engine:19} | {median(each) * 1e6:10.3f} | '
                      f'{ratio:>5} |')


def processor() -> str:
    """Return the name of the processor."""
    cpuinfo = Path('/proc/cpuinfo')  # of Linux
    lines = cpuinfo.read_text(encoding='utf-8').splitlines() if cpuinfo.exists() else []
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor()


if __name__ == '__main__':
    sys.exit(main())
