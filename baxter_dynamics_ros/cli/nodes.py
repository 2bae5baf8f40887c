"""The commands of the nodes, which report a missing library in one line."""

from functools import partial
from importlib import import_module

from .main import needs
from .terminal import complain
from ..model.exceptions import BaxterDynamicsError


def _run(executable: str) -> int:
    """Run a node; return its exit code."""
    try:
        with needs('ros'):
            return int(import_module(f'baxter_dynamics_ros.nodes.{executable}').main())
    except BaxterDynamicsError as error:
        complain(f'{executable}: {error}')
        return 1
    except KeyboardInterrupt:  # while modules load, before the node handles signals
        return 0


torque_predictor = partial(_run, 'torque_predictor')
fake_baxter = partial(_run, 'fake_baxter')
joint_state_bridge = partial(_run, 'joint_state_bridge')
