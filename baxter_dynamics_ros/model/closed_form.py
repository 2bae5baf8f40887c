"""The generated closed form as an engine: one state in plain Python, many in NumPy's blocks."""

from collections.abc import Callable
from importlib.util import find_spec
from math import cos, sin
import os
from struct import Struct
import warnings

import numpy as np

from . import _closed_form
from .arrays import Array
from .base_parameters import base_parameters, lengths, NAMES, TILTED_NAMES
from .exceptions import ArgumentError
from .joints import N_JOINTS
from .parameters import ArmParameters, theta_offsets

# What calls a generated function: of q and the rest of the state, arrays (7,) or (n, 7).
Compute = Callable[..., Array]
Bind = Callable[[str, int, tuple[float, ...]], Compute]

# States computed at a time: 4096 floats of a temporary and its neighbours stay in the cache.
_BLOCK = 4096
_SQUARE = (N_JOINTS, N_JOINTS)
_to_list = np.ndarray.tolist
_UPRIGHT = 1e-12  # gravity's part across the axis of joint 1 that is rounding

# What computes: plain Python and NumPy; the same source compiled by numba; the latter where numba
# is installed. The environment variable decides where nobody else does.
PYTHON, NUMBA, AUTO = ENGINES = ('python', 'numba', 'auto')
ENGINE_VARIABLE = 'BAXTER_DYNAMICS_ENGINE'


class ClosedForm:
    """
    An arm's dynamics in frame {0} for one set of parameters.

    Inputs are float arrays (7,) or (n, 7), all alike and already validated: nothing is checked
    here, and numba reads beyond what is too short. Results gain their own axes.

    Parameters
    ----------
    parameters : ArmParameters
        The links.
    pseudo_inertia : ndarray (7, 4, 4)
        J of eq. (12); the parameters' own, with any payload added to the last.
    gravity : ndarray (3,)
        Gravity vector in frame {0} [m/s^2].
    engine : str, optional
        'python', 'numba', or 'auto': one of :data:`ENGINES`.

    Attributes
    ----------
    base_parameters : ndarray (43,) or (45,)
        phi of ``tau = Y phi`` in the order of ``base_parameters.TILTED_NAMES``; the last two
        only where gravity is not along the axis of joint 1. Read-only.
    constants : tuple of float
        The arm's numbers, as ``_closed_form.CONSTANTS`` names them.
    upright : bool
        Whether gravity is along the axis of joint 1.

    Raises
    ------
    ArgumentError
        If the parameters are not those of an arm built like Baxter's.

    """

    def __init__(self, parameters: ArmParameters, pseudo_inertia: Array, gravity: Array,
                 engine: str = AUTO) -> None:
        self.upright = bool(np.abs(gravity[:2]).max() <= _UPRIGHT * np.abs(gravity).max())
        if self.upright:  # but for the rounding of a mount
            gravity = gravity * [0.0, 0.0, 1.0]
        phi = base_parameters(parameters, pseudo_inertia)
        self.base_parameters = phi[:len(NAMES)] if self.upright else phi
        self.base_parameters.flags.writeable = False
        self.constants = (*phi.tolist(), *lengths(parameters), *(-gravity).tolist())
        self._bind = _choose(engine)
        self._calls: dict[str, Compute] = {}
        self._parameters = parameters

    def mass_matrix(self, q: Array) -> Array:
        """Return M(q), (..., 7, 7) [kg m^2], eq. (6)."""
        return self._call('mass_matrix')(q).reshape(q.shape[:-1] + _SQUARE)

    def gravity(self, q: Array) -> Array:
        """Return G(q), (..., 7) [N m], eq. (8)."""
        return self._call('gravity')(q)

    def coriolis_matrix(self, q: Array, qd: Array) -> Array:
        """Return C(q, qd), (..., 7, 7) [kg m^2/s], eq. (7)."""
        return self._call('coriolis_matrix')(q, qd).reshape(q.shape[:-1] + _SQUARE)

    def coriolis_torque(self, q: Array, qd: Array) -> Array:
        """Return C(q, qd) qd, (..., 7) [N m]."""
        return self._call('coriolis_torque')(q, qd)

    def terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """Return M(q), C(q, qd) and G(q) together, eqs. (6) to (8)."""
        result, square = self._call('terms')(q, qd), q.shape[:-1] + _SQUARE
        return (result[..., :49].reshape(square), result[..., 49:98].reshape(square),
                result[..., 98:])

    def torque_terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """Return M(q), C(q, qd) qd and G(q) together."""
        result = self._call('torque_terms')(q, qd)
        return (result[..., :49].reshape(q.shape[:-1] + _SQUARE), result[..., 49:56],
                result[..., 56:])

    def momentum_terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """Return p = M(q) qd, C(q, qd)^T qd and G(q) together, without forming M or C."""
        result = self._call('momentum_terms')(q, qd)
        return result[..., :7], result[..., 7:14], result[..., 14:]

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return tau, (..., 7) [N m], eq. (5), without forming M or C."""
        return self._call('inverse_dynamics')(q, qd, qdd)

    def forward_dynamics(self, q: Array, qd: Array, tau: Array) -> Array:
        """Return qdd, (..., 7) [rad/s^2], by M = L D L^T."""
        return self._call('forward_dynamics')(q, qd, tau)

    def christoffel_symbols(self, q: Array) -> Array:
        """Return h_ikm, (..., 7, 7, 7) [kg m^2], eq. (7)."""
        result = self._call('christoffel_symbols')(q)
        return result.reshape(q.shape + _SQUARE)

    def regressor(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return Y, (..., 7, 43), or (..., 7, 45) where the base is tilted: tau = Y phi."""
        result = self._call('regressor')(q, qd, qdd)
        result = result.reshape(q.shape + (len(TILTED_NAMES),))
        return result[..., :len(self.base_parameters)]

    def inverse_dynamics_gradient(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array]:
        """Return d tau/dq and d tau/dqd, each (..., 7, 7)."""
        result = self._call('inverse_dynamics_gradient')(q, qd, qdd)
        result = result.reshape(q.shape[:-1] + (2,) + _SQUARE)
        return result[..., 0, :, :], result[..., 1, :, :]

    def _call(self, name: str) -> Compute:
        """Return what calls a generated function; where it has a form for upright arms, that."""
        call = self._calls.get(name)
        if call is None:
            function = f'{name}_upright' if self.upright and name in _closed_form.UPRIGHT else name
            call = self._calls[name] = self._shifted(
                self._bind(function, _closed_form.SIZES[name], self.constants))
        return call

    def _shifted(self, call: Compute) -> Compute:
        # The generated functions have theta_2 = q_2 + pi/2 built in.
        shift = self._parameters.theta_offset - theta_offsets()
        return (lambda q, *rest: call(q + shift, *rest)) if shift.any() else call


def _choose(engine: str) -> Bind:
    """Return the ``bind`` of an engine."""
    source = 'engine'
    if engine == AUTO and os.environ.get(ENGINE_VARIABLE):
        source, engine = ENGINE_VARIABLE, os.environ[ENGINE_VARIABLE]
    if engine not in ENGINES:
        raise ArgumentError(source, f'expected one of {", ".join(ENGINES)}, got {engine!r}')
    if engine == PYTHON or engine == AUTO and find_spec('numba') is None:
        return bind
    try:
        from .. import compiled
    except Exception as error:  # a numba that does not fit Python or NumPy raises what it likes
        reason = (f'numba does not load ({error}); install the extra `fast`, or choose '
                  f'{PYTHON!r}')
        if engine == NUMBA:
            raise ArgumentError(source, reason) from None
        warnings.warn(f'{source}: {reason}; computing in Python', stacklevel=4)
        return bind
    return compiled.bind


def bind(name: str, size: int, constants: tuple[float, ...]) -> Compute:
    """
    Return what calls a generated function.

    Parameters
    ----------
    name : str
        A function of ``_closed_form``.
    size : int
        How many scalars it gives.
    constants : tuple of float
        As ``_closed_form.CONSTANTS`` names them.

    Returns
    -------
    callable
        Of q and the rest of the state, arrays (7,) or (n, 7); returns an ndarray (size,) or
        (n, size).

    """
    function = getattr(_closed_form, name)
    # Twice as fast as np.array for many numbers.
    write: Callable[..., None] = Struct(f'{size}d').pack_into

    def compute(q: Array, *rest: Array) -> Array:
        if q.ndim > 1:
            return _compute_many(function, size, constants, q, *rest)
        angles, out, result = q.tolist(), [0.0] * size, np.empty(size)
        function(map(sin, angles), map(cos, angles), *map(_to_list, rest), constants, out)
        write(result, 0, *out)
        return result
    return compute


def _compute_many(function: Callable[..., None], size: int, constants: tuple[float, ...],
                  *arrays: Array) -> Array:
    """Call a generated function on arrays (n, 7), block by block."""
    n = len(arrays[0])
    result = np.empty((n, size))
    states: list[Array] = [np.empty((N_JOINTS, min(n, _BLOCK))) for _ in arrays]
    sine, cosine = np.empty((2, *states[0].shape))
    out: Array = np.empty((size, states[0].shape[1]))
    for start in range(0, n, _BLOCK):
        block = slice(start, start + _BLOCK)
        if n - start < len(out[0]):  # the last block
            states, (sine, cosine, out) = (
                [x[:, :n - start] for x in xs] for xs in (states, (sine, cosine, out)))
        for state, x in zip(states, arrays):
            state[:] = x[block].T
        _sine_and_cosine(states[0], sine, cosine)
        function(sine, cosine, *states[1:], constants, out)
        result[block] = out.T
    return result


def _sine_and_cosine(x: Array, sine: Array, cosine: Array) -> None:
    """Write sin x and cos x, by the tangent of x/2: one transcendental function for both."""
    tangent = np.tan(np.multiply(x, 0.5, out=sine), out=sine)
    square = np.multiply(tangent, tangent, out=cosine)
    factor = 1.0 / (1.0 + square)
    np.subtract(1.0, square, out=cosine)
    cosine *= factor
    sine += tangent
    sine *= factor
