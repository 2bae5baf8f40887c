"""The commands that run a node: they say in one line what is missing where there is no ROS."""

import importlib
import sys


def torque_predictor() -> int:
    """Run the predictor; return its exit code."""
    return _run('torque_predictor')


def fake_baxter() -> int:
    """Run the fake Baxter; return its exit code."""
    return _run('fake_baxter')


def joint_state_bridge() -> int:
    """Run the bridge from a ROS 1 robot; return its exit code."""
    return _run('joint_state_bridge')


def _run(executable: str) -> int:
    try:
        return _node(executable)
    except KeyboardInterrupt:  # before the node handles it, while modules load
        return 0


def _node(executable: str) -> int:
    try:
        node = importlib.import_module(f'baxter_dynamics_ros.nodes.{executable}')
    except ImportError as error:
        print(f'{executable}: {error}. Without ROS, install the ros extra: pip install ".[ros]"',
              file=sys.stderr)
        return 1
    return node.main()
