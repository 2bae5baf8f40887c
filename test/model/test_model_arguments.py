"""BaxterArm and Payload validate their arguments and do not modify them."""

from dataclasses import replace

from baxter_dynamics_ros import ArgumentError, BaxterArm, mount, Payload
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
import numpy as np
import pytest

# Every method and the names of its arguments.
METHODS = {name: ('q', *vectors) for name, (vectors, _) in FUNCTIONS.items()}
INVALID_JOINTS = [
    (np.zeros(6), r'expected shape \(\.\.\., 7\), got \(6,\)'),
    (np.zeros((7, 1)), r'expected shape \(\.\.\., 7\), got \(7, 1\)'),
    (0.0, r'expected shape \(\.\.\., 7\), got \(\)'),
    ([0, 0, 0, float('nan'), 0, 0, 0], r'expected finite values, got nan at index \(3,\)'),
    (np.full((2, 7), -np.inf), r'expected finite values, got -inf at index \(0, 0\)'),
    (np.zeros(7, dtype=complex), 'expected real numbers'),
    (['0'] * 7, 'expected real numbers'),
    ([True] * 7, 'expected real numbers'),
    (None, 'expected real numbers'),
    ([[0.0] * 7, [0.0] * 6], 'expected real numbers'),
]
RIGID = 'expected the inertia of a rigid body'
INVALID = [
    (BaxterArm, {'gravity': (0.0, -9.81)}, r'expected shape \(3,\), got \(2,\)'),
    (BaxterArm, {'gravity': 9.81}, r'expected shape \(3,\), got \(\)'),
    (BaxterArm, {'gravity': (0.0, 0.0, np.nan)}, 'expected finite values, got nan'),
    (BaxterArm, {'mount': np.eye(3)}, r'expected shape \(4, 4\), got \(3, 3\)'),
    (BaxterArm, {'mount': np.diag([2.0, 2.0, 2.0, 1.0])}, 'expected .*rotation'),
    (BaxterArm, {'mount': np.diag([-1.0, 1.0, 1.0, 1.0])}, 'expected .*rotation'),
    (BaxterArm, {'mount': np.diag([1.0, 1.0, 1.0, 2.0])}, 'expected .*last row 0 0 0 1'),
    (BaxterArm, {'mount': 'right'}, 'expected real numbers'),
    (BaxterArm, {'payload': 0.3}, 'expected Payload, got 0.3'),
    (BaxterArm, {'parameters': 0.3}, 'expected ArmParameters, got 0.3'),
    (mount, {'side': 'top'}, "expected one of right, left, got 'top'"),
    (Payload, {'mass': -0.1}, r'expected .* \[0, 10\] kg, got -0.1'),
    (Payload, {'mass': 10.0000001}, r'expected .* \[0, 10\] kg, got 10\.0000001'),
    (Payload, {'center_of_mass': (0.0, 0.0, np.nan)}, 'expected finite values, got nan'),
    (Payload, {'inertia': np.eye(3)}, r'expected shape \(6,\), got \(3, 3\)'),
    (Payload, {'inertia': (-1e-3, 1e-3, 1e-3, 0, 0, 0)}, RIGID),
    (Payload, {'inertia': (1e-3, 1e-3, 1e-3, 2e-3, 0, 0)}, RIGID),
    (Payload, {'inertia': (1e-3, 1e-3, 3e-3, 0, 0, 0)}, RIGID),  # no triangle
    (Payload, {'inertia': (1e-3, 1e-3, 1e-3, 0, 0, 0)}, 'expected zero where payload.mass is'),
]


@pytest.mark.parametrize('value, expected', INVALID_JOINTS)
def test_invalid_joint_vectors(value, expected):
    for method, names in METHODS.items():
        arguments = [*[np.zeros(7)] * (len(names) - 1), value]
        with pytest.raises(ArgumentError, match=f'^{names[-1]}: {expected}') as caught:
            getattr(BaxterArm(), method)(*arguments)
        assert caught.value.argument == names[-1]


@pytest.mark.parametrize('kind, arguments, expected', INVALID)
def test_invalid_arms_mounts_and_payloads(kind, arguments, expected):
    ((name, _),) = arguments.items()
    name = f'payload.{name}' if kind is Payload else name
    with pytest.raises(ArgumentError, match=f'^{name}: {expected}') as caught:
        kind(**arguments)
    assert caught.value.argument == name


def test_limiting_cases_of_payload_inertia():
    for inertia in ((1e-3, 1e-3, 2e-3, 0, 0, 0),  # a disc: the triangle inequality's border
                    (0, 1e-3, 1e-3, 0, 0, 0),  # a rod
                    (0, 0, 0, 0, 0, 0)):  # a point
        assert Payload(mass=1.0, inertia=inertia).mass == 1.0


def test_public_arrays_are_read_only(arm):
    arrays = [arm.gravity_vector, arm.mount, *(
        value for value in vars(arm.parameters).values() if isinstance(value, np.ndarray))]
    assert len(arrays) == 10
    for array in arrays:
        with pytest.raises(ValueError, match='read-only'):
            array[...] = 0.0


def test_arguments_are_copied(rng):
    gravity, pose, center, inertia = (np.array([0.0, 0.0, -9.81]), mount('right'),
                                      np.array([0.0, 0.0, 0.1]), np.zeros(6))
    arm = BaxterArm(Payload(1.0, center, inertia), gravity, pose)
    q = rng.uniform(-1.0, 1.0, 7)
    torques, hand = arm.gravity(q), arm.forward_kinematics(q)
    for array in (gravity, pose, center, inertia):
        array += 1.0  # still the caller's, and writeable
    np.testing.assert_array_equal(arm.gravity(q), torques)
    np.testing.assert_array_equal(arm.forward_kinematics(q), hand)
    assert arm.payload == Payload(1.0, (0.0, 0.0, 0.1))


@pytest.mark.parametrize('shape', [(7,), (5, 7), (4100, 7)], ids=str)
def test_arguments_are_unchanged_and_results_are_new(arm, rng, shape):
    for method, names in METHODS.items():
        arguments = [rng.uniform(-1.0, 1.0, shape) for _ in names]
        before = [argument.copy() for argument in arguments]
        for argument in arguments:
            argument.flags.writeable = False
        results = getattr(arm, method)(*arguments)
        for result in results if isinstance(results, tuple) else (results,):
            result[...] = 7.0  # must reach neither the arguments nor the arm
        np.testing.assert_array_equal(arguments, before)
        again = getattr(arm, method)(*arguments)
        for result in again if isinstance(again, tuple) else (again,):
            assert not (result == 7.0).any()


def test_replaced_parameters_are_copied_and_rederived():
    before = BaxterArm().parameters
    mass = 2.0 * before.mass
    doubled = replace(before, mass=mass)
    mass[:] = 0.0
    np.testing.assert_array_equal(doubled.mass, 2.0 * before.mass)
    np.testing.assert_array_equal(doubled.pseudo_inertia[:, 3], 2.0 * before.pseudo_inertia[:, 3])
    with pytest.raises(ArgumentError, match='mass: expected shape'):
        replace(before, mass=np.ones(6))
