"""What the tests share: random states, cases, reference engines, recordings, commands."""

from collections import defaultdict
from contextlib import contextmanager
import ctypes
import os
from pathlib import Path
import signal
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.estimation.settings import PredictorSettings, SETTINGS
from baxter_dynamics_ros.model import joints
import numpy as np
from perfect_robot import measured, sum_of_sines
from pinocchio_engine import PinocchioEngine
import pytest

pytest.register_assert_rewrite('arrivals', 'played', 'recordings.joint_states')

REPOSITORY = Path(__file__).resolve().parents[1]
SHARED = REPOSITORY.parent / 'shared'

# Lets the nodes of the tests find each other at once. Kilted has Fast DDS 3.
PROFILES = 'FASTDDS' if os.environ.get('ROS_DISTRO') == 'kilted' else 'FASTRTPS'
os.environ.setdefault(f'{PROFILES}_DEFAULT_PROFILES_FILE',
                      str(REPOSITORY / 'test' / 'nodes' / 'discovery.xml'))

_TILT = np.array([[1.0, 0.0, 0.0, 0.0],  # 0.7 rad about the base's x axis
                  [0.0, np.cos(0.7), -np.sin(0.7), 0.0],
                  [0.0, np.sin(0.7), np.cos(0.7), 0.0],
                  [0.0, 0.0, 0.0, 1.0]])

# What a BaxterArm can be made with, each time all that could hide a wrong frame or sign.
CASES = {
    'empty_hand': {},
    'loaded_tilted_mounted': {
        'payload': Payload(mass=1.2, center_of_mass=(0.03, -0.02, 0.11),
                           inertia=(3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4)),
        'gravity': (1.3, -2.1, -9.4),
        'mount': _TILT @ mount('left'),
    },
}


def pytest_configure(config):
    """Let pytest-xdist take files as they come, not those of few tests, the long ones, last."""
    config.option.loadscopereorder = False


def pytest_collection_modifyitems(items):
    """Begin with the files of this folder, which build and check everything and take long."""
    items.sort(key=lambda item: item.path.parent != Path(__file__).parent)


@pytest.fixture
def rng():
    """Return a random generator that starts every test alike."""
    return np.random.default_rng(20)


@pytest.fixture
def random_states(rng):
    """Return a function that draws n states q, qd, qdd, each (n, 7), within the limits."""
    def draw(n, speed=joints.VELOCITY_LIMIT, acceleration=5.0):
        return (rng.uniform(joints.POSITION_LOWER, joints.POSITION_UPPER, (n, joints.N_JOINTS)),
                rng.uniform(-1.0, 1.0, (n, joints.N_JOINTS)) * speed,
                rng.uniform(-1.0, 1.0, (n, joints.N_JOINTS)) * acceleration)
    return draw


@pytest.fixture(params=CASES.values(), ids=CASES.keys())
def arm(request):
    """Return the arm of each case in turn."""
    return BaxterArm(**request.param)


@pytest.fixture(scope='session')
def pin():
    """Return the module pinocchio."""
    return pytest.importorskip('pinocchio', reason='the reference engine is not installed: '
                               'pip install pin')


@pytest.fixture
def engine(pin):
    """Return a function that wraps a Pinocchio model for batches of states."""
    return lambda model, hand='hand': PinocchioEngine(pin, model, hand)


@pytest.fixture
def reference(arm, pin, engine):
    """Return Pinocchio's model of the arm, which shares its numbers and no dynamics code."""
    from baxter_dynamics_ros.newton_euler import build_model
    return engine(build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount))


@pytest.fixture(scope='session')
def shared():
    """Return the folder beside the repository that holds the paper and the recordings."""
    if not SHARED.is_dir():
        pytest.skip(f'{SHARED} is missing: it holds the paper and the recordings')
    return SHARED


@pytest.fixture(scope='session')
def recordings(shared):
    """Return the folder of the recordings of real arms, which have no licence to be copied."""
    return shared / 'data'


@pytest.fixture
def make_bag(tmp_path):
    """
    Return a function that makes a bag and returns its path.

    Messages are (topic, time of receipt [ns], content); content is a text, or a joint state
    (stamp_ns, names, position, velocity, effort). Kinds are 'mcap', 'sqlite3' and 'ros1'.
    """
    pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
    from baxter_dynamics_ros.recordings.bag_files import type_store
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores

    def make(messages, kind='mcap', name='run', compression=None):
        is_ros1 = kind == 'ros1'
        path = tmp_path / (f'{name}.bag' if is_ros1 else name)
        store = type_store(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_JAZZY)
        serialise = store.serialize_ros1 if is_ros1 else store.serialize_cdr
        writer = rosbag1.Writer(path) if is_ros1 else rosbag2.Writer(
            path, version=9, storage_plugin=rosbag2.StoragePlugin[kind.upper()])
        if compression and is_ros1:
            writer.set_compression(writer.CompressionFormat[compression])
        elif compression:
            writer.set_compression(rosbag2.CompressionMode[compression],
                                   rosbag2.CompressionFormat.ZSTD)
        connections = {}
        with writer:
            for topic, received_ns, content in messages:
                message = _ros_message(store, content, is_ros1)
                key = topic, message.__msgtype__
                if key not in connections:
                    connections[key] = writer.add_connection(*key, typestore=store)
                writer.write(connections[key], received_ns, serialise(message, key[1]))
        return path

    return make


@pytest.fixture
def read_bag():
    """Return a function: the messages in a bag, topic -> [(time of receipt [ns], message)]."""
    from rosbags.highlevel import AnyReader

    def read(path):
        found = defaultdict(list)
        with AnyReader([path]) as reader:
            for connection, received, raw in reader.messages():
                found[connection.topic].append(
                    (received, reader.deserialize(raw, connection.msgtype)))
        return found

    return read


def _ros_message(store, content, is_ros1):
    if isinstance(content, str):
        return store.types['std_msgs/msg/String'](content)
    stamp_ns, names, *arrays = content
    stamp = store.types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
    header = store.types['std_msgs/msg/Header'](*([0] if is_ros1 else []), stamp, 'base')
    return store.types['sensor_msgs/msg/JointState'](
        header, list(names), *(np.array(array, float) for array in arrays))


@pytest.fixture
def moving_arm():
    """Return a function: n joint states at 100 Hz for make_bag, effort by settings and noise."""
    w = 2 * np.pi * np.array([[0.3, 0.25, 0.35, 0.3, 0.4, 0.45, 0.5],  # [rad/s]
                              [0.11, 0.17, 0.13, 0.19, 0.07, 0.23, 0.29]])

    def motion(t):
        return sum_of_sines(t, [0.0, -0.45, 0.0, 1.2, 0.0, 0.4, 0.0], 0.35, w,
                            np.arange(14.0).reshape(2, 7))

    def make(n, side='right', topic='/robot/joint_states', truth=None):
        settings = PredictorSettings.from_parameters({**(truth or {}), 'arm': side})
        q, lagging, effort = measured(settings, 0.01 * np.arange(n), motion)
        effort += np.random.default_rng(n).normal(0.0, 0.02, q.shape)
        names = joints.joint_names(side)
        return [(topic, stamp + 1000, (stamp, names, *row)) for stamp, *row in zip(
            range(10 ** 18, 10 ** 18 + n * 10 ** 7, 10 ** 7), q, lagging, effort)]

    return make


@pytest.fixture
def command(capsys):
    """Return a function that runs a command of baxter_dynamics: exit code, stdout, stderr."""
    for module in ('rosbags', 'pinocchio', 'scipy', 'matplotlib', 'jinja2', 'rich'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[offline]"')
    from baxter_dynamics_ros.cli.main import main

    def run(*arguments):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:  # of the parser of arguments
            code = end.code
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def start_command(tmp_path):
    """Return a function that starts a command as a process in tmp_path; all end with the test."""
    processes = []

    def start(*arguments, environment=None, **options):
        processes.append(subprocess.Popen(
            [sys.executable, '-m', 'baxter_dynamics_ros.cli.main', *map(str, arguments)], **{
                'cwd': tmp_path, 'env': {**os.environ, **(environment or {})}, 'text': True,
                'stdin': subprocess.DEVNULL, 'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE,
                # A script that runs the tests in the background ignores the signal.
                'preexec_fn': lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
                **options}))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.fixture
def refused(command, tmp_path, monkeypatch):
    """Return a function that asserts: one line, exit code 1, and all in tmp_path as before."""
    def contents():
        return {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob('*')}

    def run(name, *arguments):
        monkeypatch.chdir(tmp_path)
        before = contents()
        code, out, err = command(name, *arguments)
        assert (code, out) == (1, ''), err
        (line,) = err.splitlines()
        prefix, _, reason = line.partition(': ')
        assert prefix == f'baxter_dynamics {name}'
        assert contents() == before
        return reason

    return run


@pytest.fixture
def closed():
    """Return a context manager that takes away rights to a path for a while, also from root."""
    libc = ctypes.CDLL(None)
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)  # version 3 of the call, this thread

    @contextmanager
    def close(path, mode=0):
        before = path.stat().st_mode
        mine, less = (ctypes.c_uint32 * 6)(), (ctypes.c_uint32 * 6)()
        for capabilities in (mine, less):
            libc.capget(header, capabilities)
        less[0] &= ~0b110  # DAC_OVERRIDE and DAC_READ_SEARCH, by which root may do everything
        try:
            path.chmod(mode)
            libc.capset(header, less)
            yield
        finally:
            libc.capset(header, mine)
            path.chmod(before)

    return close


@pytest.fixture
def all_changed():
    """Return all settings with values other than their defaults, with more than seven digits."""
    def changed(setting):
        if isinstance(setting.default, bool):
            return not setting.default
        if isinstance(setting.default, str):
            return setting.choices[-1] if setting.choices else 'robot_1/'
        if isinstance(setting.default, int):
            return setting.default + 1
        if isinstance(setting.default, float):
            return 1.0123456789 * setting.default or 0.123456789
        return [1.0123456789 * x or 0.0123456789 for x in setting.default]

    possible = [2.34567891e-2, 3.45678912e-2, 2.98765432e-2, 1.23456789e-4, -2.34567891e-4, 1.5e-5]
    crosstalk = 0.0123456789 * (1.0 - np.eye(7))
    return PredictorSettings.from_parameters({
        **{setting.name: changed(setting) for setting in SETTINGS}, 'payload.inertia': possible,
        'effort_model.crosstalk': crosstalk.ravel()})
