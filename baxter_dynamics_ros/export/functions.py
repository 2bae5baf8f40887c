"""What to export: functions derived for one arm, and what every file says about them."""

from collections.abc import Sequence
from typing import NamedTuple

from ..closed_form.program import Program
from ..closed_form.quantities import CONSTANTS, QUANTITIES, Quantity, TILTED_REGRESSOR
from ..model.arm import BaxterArm
from ..model.exceptions import ArgumentError
from ..model.joints import JOINTS
from ..model.parameters import theta_offsets

# What users ask for -> the quantity of BaxterArm.
SYMBOLS = {
    'M': 'mass_matrix',
    'C': 'coriolis_matrix',
    'G': 'gravity',
    'Cqd': 'coriolis_torque',
    'MCG': 'terms',
    'tau': 'inverse_dynamics',
    'qdd': 'forward_dynamics',
    'regressor': 'regressor',
    'gradient': 'inverse_dynamics_gradient',
    'christoffel': 'christoffel_symbols',
}
DEFAULT_SYMBOLS = ('M', 'C', 'G', 'MCG', 'tau')

CONVENTION = (f'Joint order: {", ".join(JOINTS)}. tau is positive in the direction of positive '
              'q.')
COMMAND = 'baxter_dynamics export'
SOURCE = ('Closed-form dynamics of a Baxter arm, tau = M(q) qdd + C(q, qd) qd + G(q), after '
          '"Lagrange-Euler Closed Dynamics Model of the Baxter Robot", its two errors mended; '
          'written by `{command}`.')
_LABELS = {'qd': 'joint velocities [rad/s]', 'qdd': 'joint accelerations [rad/s^2]',
           'tau': 'joint torques [N m]', 'q': 'joint positions [rad]'}


class Function(NamedTuple):
    """One function of an export."""

    quantity: Quantity  # its name, inputs beside q, outputs with shapes and units
    program: Program  # from sin_q[0] ... cos_q[6], qd[0] ..., constants' names

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the vectors (7) that it takes, in order: q, then the quantity's inputs."""
        return 'q', *self.quantity.inputs

    @property
    def size(self) -> int:
        """How many scalars it gives: those of its outputs one after the other."""
        return len(self.program.outputs)


def derive(arm: BaxterArm, symbols: Sequence[str] = DEFAULT_SYMBOLS) -> list[Function]:
    """
    Derive the functions to export for one arm.

    Parameters
    ----------
    arm : BaxterArm
        Whose payload, links and gravity; only whether gravity is along the axis of joint 1
        changes the functions, the rest is numbers.
    symbols : sequence of str
        Some of :data:`SYMBOLS`.

    Returns
    -------
    list of Function

    Raises
    ------
    ImportError
        If CasADi is not installed.
    ArgumentError
        If a symbol is unknown or named twice, or there is none, or the arm leaves theta_2's
        offset out.

    """
    check_symbols(symbols)
    from ..closed_form.derivation import program_of  # CasADi
    if (arm.parameters.theta_offset != theta_offsets()).any():
        raise ArgumentError('parameters', 'the functions have theta_2 = q_2 + pi/2 built in; '
                            'an arm without that correction cannot be exported')
    result = []
    for symbol in symbols:
        quantity, tilted = QUANTITIES[SYMBOLS[symbol]], not arm.dynamics.upright
        if tilted and quantity.name == 'regressor':
            quantity = TILTED_REGRESSOR
        result.append(Function(quantity, program_of(quantity, tilted)))
    return result


def check_symbols(symbols: Sequence[str]) -> None:
    """
    Refuse what is no list of quantities.

    Raises
    ------
    ArgumentError
        If a symbol is unknown or named twice, or there is none.

    """
    if not symbols:
        raise ArgumentError('quantities', f'name at least one of {", ".join(SYMBOLS)}')
    for i, symbol in enumerate(symbols):
        if symbol not in SYMBOLS:
            raise ArgumentError('quantities', f'unknown {symbol!r}; expected some of '
                                f'{", ".join(SYMBOLS)}')
        if symbol in symbols[:i]:
            raise ArgumentError('quantities', f'{symbol} is named twice')


def constants(arm: BaxterArm) -> dict[str, float]:
    """Return the arm's numbers by name: base parameters, lengths [m], minus gravity [m/s^2]."""
    return dict(zip(CONSTANTS, arm.dynamics.constants))


def describe(argument: str) -> str:
    """Return what an argument is, with its unit."""
    return _LABELS[argument]
