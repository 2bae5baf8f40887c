"""What the tests of exports share: files of an arm, states, and the specification's answers."""

from importlib import import_module
import subprocess

from baxter_dynamics_ros.model import _closed_form, lagrange_euler
from baxter_dynamics_ros.model.base_parameters import base_parameters
from baxter_dynamics_ros.model.composite import CompositeDynamics
import numpy as np
import pytest


@pytest.fixture
def export(tmp_path):
    """Return a function that writes an arm's files to tmp_path: their paths, by name."""
    def write(language, arm):
        module = import_module(f'baxter_dynamics_ros.export.{language}')
        paths = {}
        for name, text in module.files(arm, 'baxter_dynamics export').items():
            paths[name] = tmp_path / name
            paths[name].parent.mkdir(exist_ok=True)
            paths[name].write_text(text, encoding='utf-8')
        return paths

    return write


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a program in tmp_path, which must succeed: its output."""
    def call(*arguments):
        done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, timeout=110)
        assert done.returncode == 0, done.stderr or done.stdout
        return done.stdout

    return call


@pytest.fixture
def states(random_states):
    """Return 50 states by name, q, qd, qdd and tau, each (50, 7)."""
    q, qd, qdd = random_states(50)
    return {'q': q, 'qd': qd, 'qdd': qdd, 'tau': 10.0 * qdd[::-1]}


@pytest.fixture
def check(arm, states):
    """Return a function that compares results of a function with the equations of the paper."""
    q, qd, qdd, tau = states.values()
    pseudo = arm.parameters.pseudo_inertia.copy()
    pseudo[-1] += arm.payload.pseudo_inertia
    gravity = arm.mount[:3, :3].T @ arm.gravity_vector

    class Loaded:  # the specification reads an ArmParameters; the payload belongs to link 7
        a, d, alpha = arm.parameters.a, arm.parameters.d, arm.parameters.alpha
        theta_offset, pseudo_inertia = arm.parameters.theta_offset, pseudo
    composite = CompositeDynamics(arm.parameters, pseudo, gravity)
    mass, coriolis, torque = composite.terms(q, qd)
    moving = (coriolis @ qd[..., None])[..., 0]
    phi = base_parameters(arm.parameters, pseudo)
    step = 1e-3

    def derivative(function):
        return np.stack([(8 * (function(d) - function(-d)) - (function(2 * d) - function(-2 * d)))
                         / (12 * step) for d in step * np.eye(7)], -1)

    expected = {
        'mass_matrix': (mass,), 'gravity': (torque,), 'coriolis_matrix': (coriolis,),
        'coriolis_torque': (moving,), 'terms': (mass, coriolis, torque),
        'torque_terms': (mass, moving, torque),
        'momentum_terms': ((mass @ qd[..., None])[..., 0],
                           (coriolis.swapaxes(-1, -2) @ qd[..., None])[..., 0], torque),
        'inverse_dynamics': (composite.inverse_dynamics(q, qd, qdd),),
        'forward_dynamics': (np.linalg.solve(mass, (tau - moving - torque)[..., None])[..., 0],),
        'christoffel_symbols': (lagrange_euler.christoffel(Loaded, q),),
        'inverse_dynamics_gradient': (
            derivative(lambda d: composite.inverse_dynamics(q + d, qd, qdd)), 2 * coriolis),
        'forward_kinematics': (arm.mount @ composite.transforms(q)[:, -1],),
        'jacobian': (arm.jacobian(q),),
    }

    def compare(name, results):
        if name == 'regressor':
            results, wanted = [results[0] @ phi], expected['inverse_dynamics']
        else:
            wanted = expected[name]
        for result, right in zip(results, wanted, strict=True):
            tolerance = {'forward_dynamics': 1e-11 * np.abs(right).max(),
                         'inverse_dynamics_gradient': 1e-8}.get(name, 1e-11)
            np.testing.assert_allclose(result, right, rtol=0.0, atol=tolerance)

    assert expected.keys() | {'regressor'} == _closed_form.FUNCTIONS.keys()
    return compare
