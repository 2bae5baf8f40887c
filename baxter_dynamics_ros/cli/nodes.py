"""The node commands: report a missing library in one line."""

import sys

from .loading import load_module
from ..model.exceptions import BaxterDynamicsError


def torque_predictor() -> int:
    """Run the predictor; return its exit code."""
    return _run('torque_predictor')


def fake_baxter() -> int:
    """Run the fake Baxter; return its exit code."""
    return _run('fake_baxter')


def _run(executable: str) -> int:
    try:
        return load_module(f'baxter_dynamics_ros.nodes.{executable}', 'ros').main()
    except BaxterDynamicsError as error:
        print(f'{executable}: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # while modules load, before the node handles signals
        return 0
