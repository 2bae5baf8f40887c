"""The engines that the benchmark compares, each in a file of its own, all from our parameters."""

from importlib import import_module

# In the order of the table. A module has a function ``engines(arm)`` that returns its engines.
MODULES = ('ours', 'ours_numba', 'exported_c', 'pinocchio', 'mujoco', 'pybullet', 'drake',
           'toolbox', 'casadi', 'specification')


def load(name: str, arm) -> list:
    """
    Return the engines of one module, built from the parameters of a ``BaxterArm``.

    Raises
    ------
    ImportError
        If what it needs is not installed.

    """
    return import_module(f'{__name__}.{name}').engines(arm)
