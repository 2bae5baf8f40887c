"""
Compare the speed of BaxterArm, compiled and in Python, with Pinocchio and MuJoCo in one table.

All engines have the same parameters and must agree within 1e-9 before they are timed. Their runs
alternate, so that a busy machine slows all of them. Run: python benchmarks/model.py [--quick]
"""

import argparse
from functools import partial
import gc
import os
from pathlib import Path
import subprocess
import sys
from time import perf_counter

os.environ.update(dict.fromkeys(('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS'), '1'))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

from baxter_dynamics_ros import BaxterArm  # noqa: E402, I100
from baxter_dynamics_ros.model import joints, lagrange_euler  # noqa: E402
from baxter_dynamics_ros.model.paper_tables import GRAVITY  # noqa: E402
from baxter_dynamics_ros.newton_euler import build_model  # noqa: E402
import mujoco  # noqa: E402
from mujoco_model import mjcf  # noqa: E402
import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

BASE = 'Pinocchio'
TITLES = {'tau': 'tau, one state', 'terms': 'M, C, G, one state', 'forward': 'qdd, one state',
          'batch': 'tau, {:,} states', 'import': 'import, new process'}
MODULES = {'Python alone': 'sys', 'NumPy alone': 'numpy', 'this package': 'baxter_dynamics_ros',
           BASE: 'pinocchio', 'MuJoCo': 'mujoco'}


def main():
    """Print the table, if all engines agree with the equations of the paper."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--quick', action='store_true', help='check that everything runs')
    quick = parser.parse_args().quick
    n, rounds, long_rounds, loop = (2000, 3, 3, 5) if quick else (100_000, 100, 15, 100)
    arm = BaxterArm(engine='python')
    model = build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount)
    engines = {f'BaxterArm, {each.engine}': {
        'tau': each.inverse_dynamics, 'terms': each.terms, 'forward': each.forward_dynamics,
        'batch': each.inverse_dynamics} for each in (BaxterArm(engine='compiled'), arm)}
    engines |= {BASE: pinocchio(model), 'MuJoCo': mujoco_calls(arm), f'{BASE}, 2 threads': {
        'batch': partial(in_parallel, pin.ModelPool(model, 2))}}
    checked = states(20)
    tau = lagrange_euler.inverse_dynamics(arm.parameters, *checked, GRAVITY)
    for engine, calls in engines.items():
        for kind, call in calls.items():
            for state in [(*checked, tau)] if kind == 'batch' else zip(*checked, tau):
                if not difference(kind, call, *state) <= 1e-9:
                    raise SystemExit(f'{engine} {kind} differs')
    for engine, module in MODULES.items():
        engines.setdefault(engine, {})['import'] = partial(
            subprocess.run, [sys.executable, '-c', f'import {module}'], check=True)
    print(f'Python {sys.version.split()[0]}, NumPy {np.__version__}. Medians of alternating '
          f'runs.\nThe ratio is the time over that of {BASE}, whose batch is rneaInParallel.\n')
    print(f'| {"":22} | {"engine":20} |    us each |  ratio |\n|---|---|--:|--:|')
    one = list(zip(*states(loop)))
    runs = {'tau': (one, rounds, 1), 'terms': ([state[:2] for state in one], rounds, 1),
            'forward': (one, rounds, 1), 'batch': ([states(n)], long_rounds, n),
            'import': ([()], long_rounds, 1)}
    for kind, title in TITLES.items():
        calls = {engine: of[kind] for engine, of in engines.items() if kind in of}
        table(title.format(n), calls, *runs[kind])


def states(n: int) -> tuple:
    """Return n states q, qd, qdd, each (n, 7), within the arm's limits; the same every time."""
    rng = np.random.default_rng(20)
    return (rng.uniform(joints.POSITION_LOWER, joints.POSITION_UPPER, (n, 7)),
            rng.uniform(-1.0, 1.0, (n, 7)) * joints.VELOCITY_LIMIT,
            rng.uniform(-5.0, 5.0, (n, 7)))  # [rad/s^2]


def pinocchio(model: pin.Model) -> dict:
    """Return the calls of Pinocchio by the keys of TITLES."""
    data = model.createData()

    def terms(q, qd):
        return (pin.crba(model, data, q), pin.computeCoriolisMatrix(model, data, q, qd),
                pin.computeGeneralizedGravity(model, data, q))

    return {'tau': partial(pin.rnea, model, data), 'terms': terms,
            'forward': partial(pin.aba, model, data),
            'batch': partial(in_parallel, pin.ModelPool(model, 1))}


def in_parallel(pool: pin.ModelPool, q, qd, qdd) -> np.ndarray:
    """Return Pinocchio's tau (n, 7) of a batch, with a thread for each model of the pool."""
    tau = np.empty(q.shape)
    pin.rneaInParallel(pool.size(), pool, q.T, qd.T, qdd.T, tau.T)
    return tau


def mujoco_calls(arm: BaxterArm) -> dict:
    """Return the calls of MuJoCo, which has no C and no batches."""
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)

    def tau(q, qd, qdd):
        data.qpos, data.qvel, data.qacc = q, qd, qdd
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse

    def forward(q, qd, tau):
        data.qpos, data.qvel, data.qfrc_applied = q, qd, tau
        mujoco.mj_forward(model, data)
        return data.qacc

    return {'tau': tau, 'forward': forward}


def difference(kind: str, call, q, qd, qdd, tau) -> float:
    """Return how far torques of a call are from the equations of the paper, at most [N m]."""
    if kind == 'forward':
        error = BaxterArm().mass_matrix(q) @ (call(q, qd, tau) - qdd)
    elif kind == 'terms':
        mass, coriolis, gravity = call(q, qd)
        mass = np.triu(mass) + np.triu(mass, 1).T  # crba computes the upper triangle
        error = mass @ qdd + coriolis @ qd + gravity - tau
    else:
        error = call(q, qd, qdd) - tau
    return np.abs(error).max()


def table(title: str, calls: dict, arguments: list, rounds: int, n: int):
    """Time the calls of all engines in alternating runs and print their rows."""
    times = {engine: [] for engine in calls}
    gc.disable()
    for _ in range(rounds + 1):  # the first warms up
        for engine, call in calls.items():
            start = perf_counter()
            for state in arguments:
                call(*state)
            times[engine].append((perf_counter() - start) / len(arguments) / n)
    gc.enable()
    for engine, each in times.items():
        print(f'| {title:22} | {engine:20} | {np.median(each[1:]) * 1e6:10.3f} | '
              f'{np.median(np.divide(each, times[BASE])[1:]):6.3f} |')


if __name__ == '__main__':
    main()
