"""The one formulation, on floats, on arrays and on symbols, against the matrix equations."""

from baxter_dynamics_ros.model.composite import CompositeDynamics
import numpy as np
import pytest

pytest.importorskip('casadi', reason='needed to derive the closed form: pip install casadi')
from baxter_dynamics_ros.model import lagrange_euler, paper_tables  # noqa: E402, I100
from tools.closed_form import frames  # noqa: E402
from tools.closed_form.quantities import formulate, PARAMETERS  # noqa: E402

EXACT = {'rtol': 0.0, 'atol': 1e-12}


@pytest.fixture
def formulation(arm):
    constants = dict(zip(PARAMETERS, arm.closed_form_parameters))
    return lambda q: formulate(np.sin(q).T, np.cos(q).T, constants)


@pytest.fixture
def composite(arm):
    pseudo = arm.parameters.pseudo_inertia.copy()
    pseudo[-1] += arm.payload.pseudo_inertia
    return CompositeDynamics(arm.parameters, pseudo, arm.mount[:3, :3].T @ arm.gravity_vector)


def stacked(nested):
    """Return nested lists of arrays (n,) and zeros as an array with n in front."""
    if isinstance(nested, (list, tuple)):
        parts = [stacked(part) for part in nested]
        n = max(part.shape[0] for part in parts)
        return np.stack([np.broadcast_to(p, (n,) + p.shape[1:]) for p in parts], 1)
    return np.atleast_1d(np.asarray(nested, float))


def test_turns_of_the_frames_are_those_of_table_ii():
    alpha = np.array(paper_tables.TABLE_II)[:6, 2]
    np.testing.assert_allclose(np.array(frames._ALPHA) * np.pi / 2, alpha)


def test_everything_on_floats(arm, formulation, composite, random_states):
    for q, qd, qdd in zip(*random_states(5)):
        f, (vd, ad) = formulation(q), (qd.tolist(), qdd.tolist())
        mass, coriolis, gravity = composite.terms(q, qd)
        np.testing.assert_allclose(f.mass_matrix(), mass, **EXACT)
        np.testing.assert_allclose(f.coriolis_matrix(vd), coriolis, **EXACT)
        np.testing.assert_allclose(f.gravity(), gravity, **EXACT)
        tau = composite.inverse_dynamics(q, qd, qdd)
        np.testing.assert_allclose(f.inverse_dynamics(vd, ad), tau, **EXACT)
        y = np.array(f.regressor(vd, ad))[:, :len(arm.base_parameters)]
        np.testing.assert_allclose(y @ arm.base_parameters, tau, **EXACT)


def test_christoffel_symbols_are_those_of_eq_7(arm, formulation, random_states):
    q, _, _ = random_states(20)
    loaded = arm.parameters.pseudo_inertia.copy()
    loaded[-1] += arm.payload.pseudo_inertia

    class Loaded:  # the specification reads an ArmParameters; the payload belongs to link 7
        a, d, alpha = arm.parameters.a, arm.parameters.d, arm.parameters.alpha
        theta_offset, pseudo_inertia = arm.parameters.theta_offset, loaded
    expected = lagrange_euler.christoffel(Loaded, q)
    np.testing.assert_allclose(stacked(formulation(q).christoffel_symbols()), expected, **EXACT)


def test_gradient_of_torques(formulation, composite, random_states):
    q, qd, qdd = random_states(20)
    by_q, by_qd = (stacked(x) for x in formulation(q).inverse_dynamics_gradient(qd.T, qdd.T))
    step = 1e-3
    for k, unit in enumerate(step * np.eye(7)):
        def difference(tau):  # of fourth order
            return (8 * (tau(1) - tau(-1)) - (tau(2) - tau(-2))) / (12 * step)
        expected = difference(lambda m: composite.inverse_dynamics(q + m * unit, qd, qdd))
        np.testing.assert_allclose(by_q[..., k], expected, rtol=0.0, atol=1e-8)
        expected = difference(lambda m: composite.inverse_dynamics(q, qd + m * unit, qdd))
        np.testing.assert_allclose(by_qd[..., k], expected, rtol=0.0, atol=1e-8)
