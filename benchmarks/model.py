"""
Compare the speed of BaxterArm, compiled and in Python, with Pinocchio in one table.

All engines have the same parameters and must agree within 1e-9 before they are timed. Their runs
alternate, so that a busy machine slows all of them. Run: python benchmarks/model.py [--quick]
"""

import argparse
from collections.abc import Callable
from functools import partial
import gc
from itertools import product
import os
import platform
from statistics import median
from time import perf_counter

os.environ.update(dict.fromkeys(('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS'), '1'))

from baxter_dynamics_ros import BaxterArm  # noqa: E402, I100
from baxter_dynamics_ros.model import joints, lagrange_euler  # noqa: E402
from baxter_dynamics_ros.model.paper_tables import GRAVITY  # noqa: E402
from baxter_dynamics_ros.newton_euler import build_model  # noqa: E402
import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

BASE = 'Pinocchio'
TITLES = {'tau': 'tau, one state', 'terms': 'M, C, G, one state', 'forward': 'qdd, one state',
          'batch': 'tau, {:,} states'}


def main():
    """Print the table, if all engines agree with the equations of the paper."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--quick', action='store_true', help='check that everything runs')
    quick = parser.parse_args().quick
    n, rounds, batch_rounds, loop = (2000, 3, 3, 5) if quick else (100_000, 100, 15, 100)
    arms = {engine: BaxterArm(engine=engine) for engine in ('compiled', 'python')}
    engines = {f'BaxterArm, {engine}': {
        'tau': arm.inverse_dynamics, 'terms': lambda q, qd, qdd, arm=arm: arm.terms(q, qd),
        'forward': arm.forward_dynamics, 'batch': arm.inverse_dynamics}
        for engine, arm in arms.items()}
    engines[BASE] = pinocchio(arms['python'])
    checked = states(20)
    tau = lagrange_euler.inverse_dynamics(arms['python'].parameters, *checked, GRAVITY)
    for (engine, calls), kind in product(engines.items(), TITLES):
        if not difference(kind, calls[kind], *checked, tau) <= 1e-9:
            raise SystemExit(f'{engine} {kind} differs')
    print(f'Python {platform.python_version()}, NumPy {np.__version__}. Medians of alternating '
          'runs.\nOne state: time over that of Pinocchio; batches: rate over that of '
          'rneaInParallel on one thread.\n')
    print(f'| {"":22} | {"engine":19} | us a state | ratio |\n|---|---|--:|--:|')
    for kind in TITLES:
        calls = {engine: of[kind] for engine, of in engines.items()}
        if kind == 'batch':
            table(kind, calls, [states(n)], batch_rounds, n)
        else:
            table(kind, calls, list(zip(*states(loop))), rounds, 1)


def states(n: int) -> tuple:
    """Return n states q, qd, qdd, each (n, 7), within the arm's limits; the same every time."""
    rng = np.random.default_rng(20)
    return (rng.uniform(joints.POSITION_LOWER, joints.POSITION_UPPER, (n, 7)),
            rng.uniform(-1.0, 1.0, (n, 7)) * joints.VELOCITY_LIMIT,
            rng.uniform(-5.0, 5.0, (n, 7)))  # [rad/s^2]


def pinocchio(arm: BaxterArm) -> dict:
    """Return the calls of Pinocchio with the same parameters, by the keys of TITLES."""
    model = build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount)
    data, pool, results = model.createData(), pin.ModelPool(model, 1), {}

    def terms(q, qd, qdd):
        return (pin.crba(model, data, q), pin.computeCoriolisMatrix(model, data, q, qd),
                pin.computeGeneralizedGravity(model, data, q))

    def batch(q, qd, qdd):
        tau = results.setdefault(len(q), np.empty(q.shape))
        pin.rneaInParallel(1, pool, q.T, qd.T, qdd.T, tau.T)
        return tau

    return {'tau': partial(pin.rnea, model, data), 'terms': terms,
            'forward': partial(pin.aba, model, data), 'batch': batch}


def difference(kind: str, call: Callable, q, qd, qdd, tau) -> float:
    """Return how far torques of a call are from the equations of the paper, at most [N m]."""
    if kind == 'batch':
        return np.abs(call(q, qd, qdd) - tau).max()
    worst = []
    for state, torque in zip(zip(q, qd, qdd), tau):
        if kind == 'tau':
            error = call(*state) - torque
        elif kind == 'forward':
            error = BaxterArm().mass_matrix(state[0]) @ (call(*state[:2], torque) - state[2])
        else:
            mass, coriolis, gravity = call(*state)
            mass = np.triu(mass) + np.triu(mass, 1).T  # crba computes the upper triangle
            error = mass @ state[2] + coriolis @ state[1] + gravity - torque
        worst.append(np.abs(error).max())
    return np.max(worst)


def table(kind: str, calls: dict, arguments: list, rounds: int, n: int):
    """Time the calls of all engines in alternating runs and print their rows."""
    times = {engine: [] for engine in calls}
    gc.disable()
    for turn in range(-1, rounds):  # the first warms up
        for engine, call in calls.items():
            start = perf_counter()
            for state in arguments:
                call(*state)
            if turn >= 0:
                times[engine].append((perf_counter() - start) / len(arguments) / n)
    gc.enable()
    for engine, each in times.items():
        over = median(np.divide(each, times[BASE]))
        print(f'| {TITLES[kind].format(n):22} | {engine:19} | {median(each) * 1e6:10.3f} | '
              f'{over if n == 1 else 1 / over:5.2f} |')


if __name__ == '__main__':
    main()
