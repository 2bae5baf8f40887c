"""What every file explains: the arm's numbers by name, value, unit and meaning, and its head."""

from typing import NamedTuple

import numpy as np

from .functions import COMMAND, constants, CONVENTION, SOURCE
from .payload import rule
from ..closed_form.quantities import ONLY_TILTED
from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.base_parameters import TILTED_NAMES

# What the parameters mean.
FRAMES = (
    "Body frame k has the axis of joint k as its z axis and the origin of the paper's (Denavit-"
    'Hartenberg) frame {k-1}, and turns with link k: at q = 0 its x axis is that of frame {k-1}, '
    'turned by 90 degrees for link 2 alone, where theta_2 = q_2 + pi/2. Inertial parameters are '
    'base parameters, all that torques can tell of the links: what lies on the own axis of a '
    "joint is counted to the link before it. In this order they are the regressor's columns.")


RIGID = ("tau is the rigid body's. The effort that a real Baxter measures has the springs at s1, "
         'friction and bias as well.')


class Parameter(NamedTuple):
    """One of the arm's numbers."""

    name: str  # as in quantities.CONSTANTS
    value: float
    unit: str
    text: str


def parameters(arm: BaxterArm) -> list[Parameter]:
    """Return the numbers that the functions of an arm may read, as Parameters, in order."""
    return [Parameter(name, value, *_meaning(name)) for name, value in constants(arm).items()
            if not (arm.dynamics.upright and name in ONLY_TILTED)]


def head(arm: BaxterArm, command: str = COMMAND) -> list[str]:
    """Return the paragraphs that open a file, which a command wrote."""
    return [SOURCE.format(command=command), CONVENTION, RIGID,
            *arm_paragraphs(arm, f'Other links change the parameters alone. {rule(arm)}')]


def arm_paragraphs(arm: BaxterArm, other: str) -> list[str]:
    """Return the paragraphs about the arm: payload, ``other`` payloads, gravity, its mount."""
    payload = arm.payload
    carried = (f'The payload of {payload.mass:g} kg at {list(payload.center_of_mass)} m in the '
               'hand frame is in the parameters.' if payload.mass else 'The hand is empty.')
    gravity = ('Gravity is along the axis of joint 1; for a tilted base, export anew.'
               if arm.dynamics.upright else 'Gravity may have any direction.')
    return [f'{carried} {gravity} {other}', _mounted(arm)]


def storage(columns: int) -> str:
    """Return how matrices lie in memory, of a regressor with so many columns."""
    return (f'Matrices are stored row by row: element (i, k), counted from 0, is at 7 i + k; of '
            f'the regressor Y at {columns} i + k; h_ikm at 49 i + 7 k + m.')


def _mounted(arm: BaxterArm) -> str:
    """Return how the paper's frame {0} lies in the base frame, and the gravity vector there."""
    rotation, place = arm.mount[:3, :3], _vector(arm.mount[:3, 3])
    up = 'up_z is' if arm.dynamics.upright else 'up_x, up_y and up_z are'
    if (arm.mount == np.eye(4)).all():
        text = 'is the base frame'
    elif rotation[2, 2] == 1.0:
        yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
        text = f"has its origin at {place} m in the robot's base, turned by {yaw:.6g} rad about z"
    else:
        rows = ', '.join(_vector(row) for row in rotation)
        text = (f"has its origin at {place} m in the robot's base, and its axes are the columns "
                f'of the matrix with the rows {rows}')
    return (f"{up} along axes of the paper's frame {{0}}, which {text}. Exported for the gravity "
            f'vector {_vector(arm.gravity_vector)} m/s^2 in base axes.')


def _vector(numbers: Array) -> str:
    return f'({", ".join(f"{x + 0.0:.6g}" for x in numbers)})'


def _meaning(name: str) -> tuple[str, str]:
    """Return the unit and the meaning of a constant."""
    if name == 'izz1':
        return 'kg m^2', 'moment of inertia of link 1 about its joint'
    if name.startswith('up_'):
        return 'm/s^2', f"minus the gravity vector, {name[-1]} in the paper's frame {{0}}"
    if name in TILTED_NAMES:
        element, link = name[:-1], name[-1]
        if element[0] == 'h':
            return 'kg m', f'first moment of mass {element[1]} of link {link}, body frame {link}'
        return 'kg m^2', (f'second moment of mass {element[0]} {element[1]} of link {link}, body '
                          f'frame {link}')
    return 'm', f'Denavit-Hartenberg {name[0]} of link {name[1]}'
