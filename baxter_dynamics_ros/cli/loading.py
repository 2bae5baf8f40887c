"""Imports of modules that need an extra of setup.py."""

import importlib
from types import ModuleType

from ..model.exceptions import BaxterDynamicsError


def load_module(name: str, extra: str) -> ModuleType:
    """
    Import a module.

    Raises
    ------
    BaxterDynamicsError
        If a library is missing; the message names the extra that installs it.

    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BaxterDynamicsError(
            f'{error}. Without ROS, install the {extra} extra: pip install ".[{extra}]"; on a '
            'ROS machine, install the missing library with rosdep or pip') from None
