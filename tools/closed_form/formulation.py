"""
The Lagrange-Euler dynamics in body frames: the smallest exact form, written once.

docs/closed_form.md derives it. Scalars are floats, NumPy arrays or symbols. With the twist xi_k of
joint k, in body frame k Q of eq. (11), and <X, Y> = Tr(X Y^T):

* S_l = T_l J_l T_l^T, the pseudo-inertia of link l, and H_k = sum_{l>=k} S_l;
* V_l = sum_{k<=l} xi_k qd_k, so that dT_l/dt = V_l T_l, and B_k = sum_{l>=k} V_l S_l;
* A_l, so that A_l T_l is d^2 T_l/dt^2 less gravity;
* P_k = xi_k H_k and D_k = sum_{j>k} qd_j P_j: how H_k moves relative to link k;

and for i <= k:

* M_ik = <P_k, xi_i>                                          eq. (6)
* C_ik = <V_k P_k + xi_k D_k, xi_i>                           eq. (7), above the diagonal
* C_ki = <dxi_i/dt, P_k> + <xi_i, xi_k B_k^T>, i < k          eq. (7), below it
* G_k = -g . (P_k)[:, 4]                                      eq. (8)
* tau_k = <sum_{l>=k} A_l S_l, xi_k>                          eq. (5)

<X, xi_i> needs only six numbers of X, a wrench, and at body frame i it is the wrench's moment
about z. So wrenches are carried inward, link by link, and read on the way.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import TypeVar

from .frames import (about_axis, Acceleration, acceleration, acceleration_wrench, add, Affine,
                     apply, axis_moment_of_transpose, axis_wrench, change_on, change_with_axis,
                     derivative_of_axis, Frames, moment_of_moving_transpose, N, pair,
                     PseudoInertia, Rows, Scalar, Scalars, spun, total, turned, Twist,
                     twist_matrix, unit_torques, Vector, Wrench, wrench_of, ZERO)

_T = TypeVar('_T')
_LINK_COLUMNS = 7  # base parameters of each link but the first


class Formulation:
    """
    The dynamics at one configuration.

    Matrices are lists of rows; qd, qdd and tau are sequences of 7 scalars.
    """

    def __init__(self, frames: Frames, links: Sequence[PseudoInertia], up: Vector) -> None:
        self.frames = frames
        self.links = links  # base parameters of the 7 links, in body frames [kg m^2, kg m]
        # Minus the gravity vector in frame {0} [m/s^2]: the acceleration of a base without gravity
        # that loads the arm alike.
        self.up = up

    @cached_property
    def composites(self) -> list[PseudoInertia]:
        """H_1 ... H_7 without their masses, each in its body frame."""
        result = list(self.links)
        for k in range(N - 1, 0, -1):
            moved = self.frames.pseudo_inertia_inward(k, result[k])
            result[k - 1] = PseudoInertia(*add(result[k - 1], moved))
        return result

    def mass_matrix(self) -> Rows:
        """Return M, eq. (6)."""
        result = _square()
        for k, h in enumerate(self.composites):
            for i, p in _inward(k, wrench_of(turned(h)), self.frames.wrench_inward):
                result[i][k] = result[k][i] = p.moment[2]
        return result

    def gravity(self) -> list[Scalar]:
        """Return G, eq. (8)."""
        result, up = [], self.up
        for k, h in enumerate(self.composites):
            up = self.frames.outward(k, up)
            result.append(up[1] * h.hx - up[0] * h.hy)
        return result

    def coriolis_matrix(self, qd: Scalars) -> Rows:
        """Return C, eq. (7): of the Christoffel symbols, so that dM/dt - 2 C is skew."""
        result = _square()
        twists = self._velocities(qd)
        for k, (h, d) in enumerate(zip(self.composites, self._motion_beyond(qd))):
            omega, velocity = twists[k]
            p = turned(h)
            above = total(wrench_of(spun(omega, p)), axis_wrench(d))
            for i, column in _inward(k, above, self.frames.wrench_inward):
                result[i][k] = column.moment[2]
            b = moment_of_moving_transpose(omega, velocity, h, d)
            momenta = _inward(k, wrench_of(p), self.frames.wrench_inward)
            for (i, momentum), (_, transpose) in zip(
                    momenta, _inward(k, b, self.frames.inward)):
                if i < k:
                    change = pair(derivative_of_axis(*twists[i]), momentum)
                    result[k][i] = change + transpose[2]
        return result

    def coriolis_torque(self, qd: Scalars) -> list[Scalar]:
        """Return C qd, by the recursion of eq. (5)."""
        return self._torques(self._accelerations(qd, (0,) * N, ZERO))

    def inverse_dynamics(self, qd: Scalars, qdd: Scalars) -> list[Scalar]:
        """Return tau, eq. (5), without forming M or C."""
        return self._torques(self._accelerations(qd, qdd, self.up))

    def momentum_terms(self, qd: Scalars) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
        """
        Return p = M qd, C^T qd and G: dp/dt = tau + C^T qd - G, without forming M or C.

        With the momentum of link k and all beyond it, sum_{l>=k} V_l S_l = B_k: p_k = <B_k, xi_k>,
        and C^T qd, the derivative of the kinetic energy by q, is <B_k, dxi_k/dt>.
        """
        twists = self._velocities(qd)
        momenta = self._wrenches([twist_matrix(*twist) for twist in twists])
        changes = [pair(derivative_of_axis(*twist), m) for twist, m in zip(twists, momenta)]
        return [m.moment[2] for m in momenta], changes, self.gravity()

    def forward_dynamics(self, qd: Scalars, tau: Scalars) -> list[Scalar]:
        """Return qdd = M^-1 (tau - C qd - G), by M = L D L^T."""
        bias = self._torques(self._accelerations(qd, (0,) * N, self.up))
        return _solve(self.mass_matrix(), [t - b for t, b in zip(tau, bias)])

    def regressor(self, qd: Scalars, qdd: Scalars) -> Rows:
        """
        Return Y, rows of 45: tau = Y phi, with a column for each base parameter.

        xx of link 1; xx yy xy xz yz hx hy of links 2 to 7; hx hy of link 1.
        """
        columns = 1 + _LINK_COLUMNS * (N - 1)
        result = [[0] * (columns + 2) for _ in range(N)]
        twists: list[Twist] = []
        for link, a in enumerate(self._accelerations(qd, qdd, self.up)):
            twists = [self.frames.twist_outward(link, *twist) for twist in twists] if link else []
            twists.append(((0, 0, 1), ZERO))
            for i, twist in enumerate(twists):
                seven = unit_torques(twist, a)
                if link == 0:
                    result[i][0], result[i][-2:] = seven[0], seven[-2:]
                else:
                    start = 1 + _LINK_COLUMNS * (link - 1)
                    result[i][start:start + _LINK_COLUMNS] = seven
        return result

    def christoffel_symbols(self) -> list[Rows]:
        """
        Return h of eq. (7) as h[i][k][m]: C_ik = sum_m h_ikm qd_m, symmetric in k and m.

        With r the largest and a <= b the others, all are read from P_r at frames a and b:
        h_iar = <xi_a P_r, xi_i>, h_bar = <xi_a, xi_b P_r^T> = -h_rab.
        """
        h = [_square() for _ in range(N)]
        for r, composite in enumerate(self.composites):
            p = turned(composite)
            for b in range(r, -1, -1):
                for i, column in _inward(b, axis_wrench(p), self.frames.wrench_inward):
                    h[i][b][r] = h[i][r][b] = column.moment[2]
                moments = _inward(b, axis_moment_of_transpose(p), self.frames.inward)
                for a, moment in moments:
                    h[b][a][r] = h[b][r][a] = moment[2]
                    if b < r:
                        h[r][a][b] = h[r][b][a] = -moment[2]
                if b:
                    p = self.frames.affine_inward(b, p)
        return h

    def inverse_dynamics_gradient(self, qd: Scalars, qdd: Scalars) -> tuple[Rows, Rows]:
        """
        Return d tau/dq and d tau/dqd.

        The latter is 2 C, as eq. (7) is quadratic. For the former let q_k change in body frame
        k: the twist changes by dxi_k/dt, A_k by A_k xi_k - xi_k A_k, and the wrench that link
        k - 1 exerts on link k turns with it. Rows i <= k depend on q_k by that wrench alone; rows
        i > k by the change of A on P_i, and by twice dxi_k/dt on the motion of H_i relative to
        link k.
        """
        result = _square()
        twists = self._velocities(qd)
        accelerations = self._accelerations(qd, qdd, self.up)
        exerted = self._wrenches(accelerations)
        changes = [change_with_axis(a) for a in accelerations]
        axes = [derivative_of_axis(*twist)[0] for twist in twists]
        for k, (h, d) in enumerate(zip(self.composites, self._motion_beyond(qd))):
            twice = tuple(x + x for x in axes[k])
            above = total(acceleration_wrench(changes[k], h), wrench_of(spun(twice, d)))
            above = total(above, Wrench(*(about_axis(v) for v in exerted[k])))
            for i, column in _inward(k, above, self.frames.wrench_inward):
                result[i][k] = column.moment[2]
            p, relative = turned(h), axis_moment_of_transpose(d)
            for i in range(k - 1, -1, -1):
                rate = axis_moment_of_transpose(p)
                relative = tuple(x - qd[i + 1] * y for x, y in zip(relative, rate))
                relative = self.frames.inward(i + 1, relative)
                p = self.frames.affine_inward(i + 1, p)
                turn = axes[i][0] * relative[0] + axes[i][1] * relative[1]
                result[k][i] = change_on(changes[i], p) + turn + turn
        return result, [[c + c for c in row] for row in self.coriolis_matrix(qd)]

    def _velocities(self, qd: Scalars) -> list[Twist]:
        """Return V_k of each link in its body frame, as twists (angular, linear)."""
        result = []
        twist = ZERO, ZERO
        for k in range(N):
            if k:
                twist = self.frames.twist_outward(k, *twist)
            angular, linear = twist
            twist = (*angular[:2], angular[2] + qd[k]), linear
            result.append(twist)
        return result

    def _accelerations(self, qd: Scalars, qdd: Scalars, up: Vector) -> list[Acceleration]:
        """Return A_k of each link in its body frame."""
        result: list[Acceleration] = []
        omega, omega_dot, column = ZERO, ZERO, up
        for k in range(N):
            if k:
                shift = self.frames.shift(k - 1)
                column = add(column, apply(result[-1].block, shift))
            omega, omega_dot, column = (
                self.frames.outward(k, v) for v in (omega, omega_dot, column))
            x, y, z = omega_dot
            omega_dot = x + omega[1] * qd[k], y - omega[0] * qd[k], z + qdd[k]
            omega = *omega[:2], omega[2] + qd[k]
            result.append(acceleration(omega, omega_dot, column))
        return result

    def _motion_beyond(self, qd: Scalars) -> list[Affine]:
        """Return D_1 ... D_7, each in its body frame."""
        result = [Affine()]
        for k in range(N - 1, 0, -1):
            p, d = turned(self.composites[k]), result[0]
            block = tuple(tuple(x + qd[k] * y for x, y in zip(*rows))
                          for rows in zip(d.block, p.block))
            column = tuple(x + qd[k] * y for x, y in zip(d.column, p.column))
            result.insert(0, self.frames.affine_inward(k, Affine(block, column)))
        return result

    def _wrenches(self, motions: list[Acceleration]) -> list[Wrench]:
        """Return the wrench of sum_{l>=k} A_l S_l for A, or V, of each link, in body frame k."""
        result = [acceleration_wrench(a, j) for a, j in zip(motions, self.links)]
        for k in range(N - 1, 0, -1):
            result[k - 1] = total(result[k - 1], self.frames.wrench_inward(k, result[k]))
        return result

    def _torques(self, accelerations: list[Acceleration]) -> list[Scalar]:
        return [w.moment[2] for w in self._wrenches(accelerations)]


def _inward(k: int, x: _T, move: Callable[[int, _T], _T]) -> Iterator[tuple[int, _T]]:
    """Yield (i, x of body frame k in body frame i) for i from k down to 0."""
    yield k, x
    for i in range(k, 0, -1):
        x = move(i, x)
        yield i - 1, x


def _square() -> Rows:
    return [[0] * N for _ in range(N)]


def _solve(m: Rows, right: Scalars) -> list[Scalar]:
    """Return m^-1 right for a symmetric positive definite m, which is overwritten."""
    x = list(right)
    inverse = [0] * len(x)
    for k in range(len(x)):  # m becomes L below its diagonal; L x = right
        inverse[k] = 1 / m[k][k]
        for i in range(k + 1, len(x)):
            factor = m[i][k] * inverse[k]
            for j in range(k + 1, i + 1):
                m[i][j] = m[i][j] - factor * m[j][k]
            x[i] = x[i] - factor * x[k]
    for k in range(len(x) - 1, -1, -1):
        x[k] = x[k] * inverse[k]
        for i in range(k + 1, len(x)):
            x[k] = x[k] - m[i][k] * inverse[k] * x[i]
    return x
