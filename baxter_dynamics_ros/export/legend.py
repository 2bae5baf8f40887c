"""What every file explains: the arm's numbers by name, value, unit and meaning, and its head."""

from typing import NamedTuple

from .functions import constants
from .functions import CONVENTIONS
from .functions import SOURCE
from ..core.arm import BaxterArm
from ..core.base_parameters import NAMES

# Felt only where gravity is not along the axis of joint 1.
_ONLY_TILTED = ('hx1', 'hy1', 'up_x', 'up_y')

# What the parameters mean.
FRAMES = (
    "Body frame k has the axis of joint k as its z axis and the origin of the paper's (Denavit-"
    'Hartenberg) frame {k-1}, and turns with link k: at q = 0 its x axis is that of frame {k-1}, '
    'turned by 90 degrees for link 2 alone, where theta_2 = q_2 + pi/2. Inertial parameters are '
    'base parameters, all that torques can tell of the links: what lies on the own axis of a '
    "joint is counted to the link before it. In this order they are the regressor's columns.")


class Parameter(NamedTuple):
    """One of the arm's numbers."""

    name: str  # as in quantities.CONSTANTS
    value: float
    unit: str
    text: str


def parameters(arm: BaxterArm) -> list:
    """Return the numbers that the functions of an arm may read, as Parameters, in order."""
    return [Parameter(name, value, *_meaning(name)) for name, value in constants(arm).items()
            if not (arm.dynamics.upright and name in _ONLY_TILTED)]


def head(arm: BaxterArm) -> list:
    """Return the paragraphs that open a file."""
    payload = arm.payload
    carried = (f'The payload of {payload.mass:g} kg at {list(payload.center_of_mass)} m in the '
               'hand frame is in the parameters.' if payload.mass else 'The hand is empty.')
    gravity = ('Gravity is along the axis of joint 1; for a tilted base, export anew.'
               if arm.dynamics.upright else 'Gravity may have any direction.')
    return [SOURCE, CONVENTIONS[0],
            f'{carried} {gravity} Another payload or other links change the parameters alone.']


def _meaning(name: str) -> tuple:
    """Return the unit and the meaning of a constant."""
    if name == 'izz1':
        return 'kg m^2', 'moment of inertia of link 1 about its joint'
    if name.startswith('up_'):
        return 'm/s^2', f"minus the gravity vector, {name[-1]} in the paper's frame {{0}}"
    if name in NAMES or name in _ONLY_TILTED:
        element, link = name[:-1], name[-1]
        if element[0] == 'h':
            return 'kg m', f'first moment of mass {element[1]} of link {link}, body frame {link}'
        return 'kg m^2', (f'second moment of mass {element[0]} {element[1]} of link {link}, body '
                          f'frame {link}')
    return 'm', f'Denavit-Hartenberg {name[0]} of link {name[1]}'
