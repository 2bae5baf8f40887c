"""CasADi: our closed form as exported, and the recursive Newton-Euler method, symbolically."""

from baxter_dynamics_ros.export import casadi_file
from baxter_dynamics_ros.export.functions import derive
import casadi
import numpy as np

from .engine import Engine


def engines(arm) -> list:
    """Return the closed form that `baxter_dynamics export` writes, and the recursion below."""
    exported = {}
    (text,) = casadi_file.files(derive(arm, ('tau',)), arm).values()
    exec(text, exported)
    q, qd, qdd = (casadi.SX.sym(name, 7) for name in ('q', 'qd', 'qdd'))
    tau = casadi.cse(newton_euler(arm.parameters, arm.gravity_vector, q, qd, qdd))
    return [_engine('CasADi, our export', exported['function']('inverse_dynamics')),
            _engine('CasADi, Newton-Euler', casadi.Function('tau', [q, qd, qdd], [tau]))]


def _engine(name: str, function) -> Engine:
    """Return the engine of a Function (q, qd, qdd) -> tau, called through its buffers."""
    buffer, trigger = function.buffer()  # tenfold as fast as a call with arrays
    state, result = np.empty((3, 7)), np.empty(7)
    for i, row in enumerate(state):
        buffer.set_arg(i, memoryview(row))
    buffer.set_res(0, memoryview(result))

    def tau(q, qd, qdd):
        state[0], state[1], state[2] = q, qd, qdd
        trigger()
        return result

    tau.buffer = buffer  # which trigger uses and does not keep

    def batch(q, qd, qdd):
        return function(q.T, qd.T, qdd.T).full().T

    note = f'virtual machine, {function.n_instructions()} instructions'
    return Engine(name=name, tau=tau, batch=batch, notes={'tau': note, 'batch': note})


def newton_euler(p, gravity, q, qd, qdd):
    """
    Return tau (7,) as an expression.

    Every vector is resolved in the frame of its link; ``w``, ``dw`` and ``a`` are the link's
    angular velocity, its derivative and the acceleration of the frame's origin, of a base that
    is accelerated by -g. Exact zeros are structural, so that no operation is spent on them.
    """
    z = casadi.DM([0, 0, 1])
    w, dw, a = casadi.SX(3, 1), casadi.SX(3, 1), -_sparse(gravity)
    links = []
    for i in range(7):
        rotation = _rotation_z(q[i], p.theta_offset[i]) @ _sparse(_rotation_x(p.alpha[i]))
        arm = _sparse(_rotation_x(p.alpha[i]).T @ [p.a[i], 0.0, p.d[i]])
        dw = rotation.T @ (dw + z * qdd[i] + casadi.cross(w, z * qd[i]))
        w = rotation.T @ (w + z * qd[i])
        a = rotation.T @ a + _moved(w, dw, arm)
        center, inertia = _sparse(p.center_of_mass[i]), _sparse(p.inertia[i])
        force = p.mass[i] * (a + _moved(w, dw, center))
        moment = (inertia @ dw + casadi.cross(w, inertia @ w) + casadi.cross(center, force))
        links.append((rotation, arm, force, moment))
    tau, force, moment = [], casadi.SX(3, 1), casadi.SX(3, 1)
    for rotation, arm, own_force, own_moment in reversed(links):
        force += own_force
        moment = rotation @ (moment + own_moment + casadi.cross(arm, force))
        force = rotation @ force
        tau.insert(0, moment[2])
    return casadi.vertcat(*tau)


def _moved(w, dw, arm):
    """Return the acceleration of a point of a link less that of its frame's origin."""
    return casadi.cross(dw, arm) + casadi.cross(w, casadi.cross(w, arm))


def _rotation_z(q, offset: float):
    cq, sq, co, so = casadi.cos(q), casadi.sin(q), *_exact([np.cos(offset), np.sin(offset)])
    c, s = cq * co - sq * so, sq * co + cq * so
    return casadi.blockcat([[c, -s, casadi.SX(1, 1)], [s, c, casadi.SX(1, 1)],
                            [casadi.SX(1, 1), casadi.SX(1, 1), 1]])


def _rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return _exact([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _exact(numbers) -> np.ndarray:
    """Return the numbers with a cosine of pi/2 that is 0."""
    return np.where(np.abs(numbers) < 1e-15, 0.0, numbers)


def _sparse(numbers):
    return casadi.SX(casadi.sparsify(casadi.DM(numbers)))
