"""Measure speed and memory of the evaluation of a bag, relative to reading it."""

import argparse
from pathlib import Path
import resource
import tempfile
import time

from baxter_dynamics_ros.model.arm import BaxterArm
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.recordings.bags import BagRecording
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator
from baxter_dynamics_ros.recordings.writer import BagWriter
import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

TOPIC = '/robot/joint_states'
NAMES = ('head_nod head_pan left_e0 left_e1 left_s0 left_s1 left_w0 left_w1 left_w2 right_e0 '
         'right_e1 right_s0 right_s1 right_w0 right_w1 right_w2 torso_t0').split()
PERIOD = 0.01  # [s]
JITTER = 4e-5  # standard deviation of the robot's stamps [s]
STORAGES = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}


def write(path: Path, n: int):
    """Write a bag of n joint states of a robot whose right arm moves."""
    order = [NAMES.index(name) for name in joint_names('right')]
    arm, model = BaxterArm(), EffortModel()
    w = np.array([0.3, 0.25, 0.4, 0.35, 0.3, 0.45, 0.2]) * 2 * np.pi
    centre = np.array([0.2, -0.6, 0.3, 1.2, -0.4, 0.8, 0.5])
    rng = np.random.default_rng(0)
    with BagWriter(path) as bag:
        for start in range(0, n, 10000):
            t = PERIOD * np.arange(start, min(start + 10000, n))[:, None]
            t = t + rng.normal(0.0, JITTER, t.shape)
            q, qd, qdd = (centre + 0.3 * np.sin(w * t), 0.3 * w * np.cos(w * t),
                          -0.3 * w * w * np.sin(w * t))
            tau = arm.inverse_dynamics(q, qd, qdd)
            rows = np.zeros((3, len(t), len(NAMES)))
            rows[:, :, order] = q, qd, model.effort(tau, q, qd, qdd)
            for now, *row in zip(t[:, 0], *rows):
                bag.joint_state(TOPIC, 10 ** 18 + round(now * 1e9), NAMES, *row)


def copy(source: Path, path: Path, storage: str):
    """Copy a bag's joint states to a bag of another storage."""
    with Reader(source) as reader, Writer(
            path, version=9, storage_plugin=STORAGES[storage]) as writer:
        (connection,) = reader.connections
        copied = writer.add_connection(
            TOPIC, connection.msgtype, msgdef=connection.msgdef.data,
            rihs01=connection.digest)
        for _, received_ns, raw in reader.messages():
            writer.write(copied, received_ns, raw)


def read(path: Path) -> float:
    """Return the time to read and deserialise a bag [s]."""
    start = time.perf_counter()
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
    return time.perf_counter() - start


def evaluate(path: Path) -> float:
    """Return the time to evaluate a bag [s]."""
    start = time.perf_counter()
    with BagRecording(path, arm='right') as recording:
        Evaluator({}).evaluate(recording)
    return time.perf_counter() - start


def main():
    """Print both times, their ratio and the peak memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--messages', type=int, default=30000)
    parser.add_argument('--repeats', type=int, default=3)
    parser.add_argument('--storage', choices=STORAGES, default='mcap')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bag'
        write(path, options.messages)
        if options.storage != 'mcap':
            source, path = path, Path(folder) / options.storage
            copy(source, path, options.storage)
        pairs = [(read(path), evaluate(path)) for _ in range(options.repeats)]
    for name, times in zip(('read', 'evaluate'), zip(*pairs)):
        print(f'{name:10}{1e6 * min(times) / options.messages:8.1f} us a message')
    print(f'ratio     {np.median([b / a for a, b in pairs]):8.2f}')
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f'peak memory {peak:.0f} MB')


if __name__ == '__main__':
    main()
