"""BaxterArm and Payload validate their arguments and do not modify them."""

from dataclasses import replace

from baxter_dynamics_ros import ArgumentError, BaxterArm, mount, Payload
import numpy as np
import pytest

# Every method and the names of its arguments.
METHODS = {
    'mass_matrix': ('q',),
    'coriolis_matrix': ('q', 'qd'),
    'gravity': ('q',),
    'terms': ('q', 'qd'),
    'inverse_dynamics': ('q', 'qd', 'qdd'),
    'forward_dynamics': ('q', 'qd', 'tau'),
    'forward_kinematics': ('q',),
    'jacobian': ('q',),
}
INVALID_JOINTS = {
    'six': (np.zeros(6), r'expected shape \(\.\.\., 7\), got \(6,\)'),
    'column': (np.zeros((7, 1)), r'expected shape \(\.\.\., 7\), got \(7, 1\)'),
    'scalar': (0.0, r'expected shape \(\.\.\., 7\), got \(\)'),
    'nan': ([0, 0, 0, float('nan'), 0, 0, 0], r'expected finite values, got nan at index \(3,\)'),
    'infinite': (np.full((2, 7), -np.inf), r'expected finite values, got -inf at index \(0, 0\)'),
    'complex': (np.zeros(7, dtype=complex), 'expected real numbers'),
    'text': (['0'] * 7, 'expected real numbers'),
    'boolean': ([True] * 7, 'expected real numbers'),
    'none': (None, 'expected real numbers'),
    'ragged': ([[0.0] * 7, [0.0] * 6], 'expected real numbers'),
}

INVALID_ARMS = {
    'gravity_shape': ({'gravity': (0.0, -9.81)}, 'gravity',
                      r'expected shape \(3,\), got \(2,\)'),
    'gravity_number': ({'gravity': 9.81}, 'gravity', r'expected shape \(3,\), got \(\)'),
    'gravity_nan': ({'gravity': (0.0, 0.0, np.nan)}, 'gravity', 'expected finite values, got nan'),
    'mount_shape': ({'mount': np.eye(3)}, 'mount', r'expected shape \(4, 4\), got \(3, 3\)'),
    'mount_nan': ({'mount': np.full((4, 4), np.nan)}, 'mount', 'expected finite values, got nan'),
    'mount_scaled': ({'mount': np.diag([2.0, 2.0, 2.0, 1.0])}, 'mount', 'expected .*rotation'),
    'mount_mirrored': ({'mount': np.diag([-1.0, 1.0, 1.0, 1.0])}, 'mount', 'expected .*rotation'),
    'mount_last_row': ({'mount': np.diag([1.0, 1.0, 1.0, 2.0])}, 'mount',
                       'expected .*last row 0 0 0 1'),
    'mount_text': ({'mount': 'right'}, 'mount', 'expected real numbers'),
}

INVALID_PAYLOADS = {
    'negative_mass': ({'mass': -0.1}, 'payload.mass', r'expected .* \[0, inf\], got -0.1'),
    'infinite_mass': ({'mass': np.inf}, 'payload.mass', 'expected finite values, got inf'),
    'mass_array': ({'mass': [1.0]}, 'payload.mass', r'expected shape \(\), got \(1,\)'),
    'center_shape': ({'mass': 1.0, 'center_of_mass': (0.0, 0.0)}, 'payload.center_of_mass',
                     r'expected shape \(3,\), got \(2,\)'),
    'center_nan': ({'mass': 1.0, 'center_of_mass': (0.0, 0.0, np.nan)}, 'payload.center_of_mass',
                   'expected finite values, got nan'),
    'inertia_as_tensor': ({'mass': 1.0, 'inertia': np.eye(3)}, 'payload.inertia',
                          r'expected shape \(6,\), got \(3, 3\)'),
    'inertia_negative': ({'mass': 1.0, 'inertia': (-1e-3, 1e-3, 1e-3, 0, 0, 0)},
                         'payload.inertia', 'expected the inertia of a rigid body'),
    'inertia_off_diagonal': ({'mass': 1.0, 'inertia': (1e-3, 1e-3, 1e-3, 2e-3, 0, 0)},
                             'payload.inertia', 'expected the inertia of a rigid body'),
    'inertia_triangle': ({'mass': 1.0, 'inertia': (1e-3, 1e-3, 3e-3, 0, 0, 0)},
                         'payload.inertia', 'expected the inertia of a rigid body'),
    'inertia_without_mass': ({'inertia': (1e-3, 1e-3, 1e-3, 0, 0, 0)}, 'payload.inertia',
                             'expected zero where payload.mass is zero'),
}


@pytest.mark.parametrize('value, expected', INVALID_JOINTS.values(), ids=INVALID_JOINTS)
def test_invalid_joint_vectors(value, expected):
    for method, names in METHODS.items():
        arguments = [*[np.zeros(7)] * (len(names) - 1), value]
        with pytest.raises(ArgumentError, match=f'^{names[-1]}: {expected}') as caught:
            getattr(BaxterArm(), method)(*arguments)
        assert caught.value.argument == names[-1]


@pytest.mark.parametrize('arguments, name, expected', INVALID_ARMS.values(), ids=INVALID_ARMS)
def test_invalid_arms(arguments, name, expected):
    with pytest.raises(ArgumentError, match=f'^{name}: {expected}'):
        BaxterArm(**arguments)


@pytest.mark.parametrize('arguments, name, expected', INVALID_PAYLOADS.values(),
                         ids=INVALID_PAYLOADS)
def test_invalid_payloads(arguments, name, expected):
    with pytest.raises(ArgumentError, match=f'^{name}: {expected}') as caught:
        Payload(**arguments)
    assert caught.value.argument == name


def test_invalid_side():
    with pytest.raises(ValueError, match='side: expected one of right, left, got .top.'):
        mount('top')


@pytest.mark.parametrize('inertia', [
    (1e-3, 1e-3, 2e-3, 0, 0, 0),  # a disc: the triangle inequality's border
    (0, 1e-3, 1e-3, 0, 0, 0),  # a rod
    (0, 0, 0, 0, 0, 0),  # a point
], ids=['disc', 'rod', 'point'])
def test_limiting_cases_of_payload_inertia(inertia):
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


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('shape', [(7,), (5, 7), (4100, 7)], ids=str)
def test_arguments_are_unchanged_and_results_are_new(arm, rng, method, shape):
    arguments = [rng.uniform(-1.0, 1.0, shape) for _ in METHODS[method]]
    before = [argument.copy() for argument in arguments]
    for argument in arguments:
        argument.flags.writeable = False
    results = getattr(arm, method)(*arguments)
    for result in results if isinstance(results, tuple) else (results,):
        assert result.flags.writeable
        result[...] = 7.0  # must reach neither the arguments nor the arm
    np.testing.assert_array_equal(arguments, before)
    again = getattr(arm, method)(*arguments)
    for result in again if isinstance(again, tuple) else (again,):
        assert not (result == 7.0).any()


@pytest.mark.parametrize('argument', ['payload', 'parameters'])
def test_wrong_types_are_refused(argument):
    with pytest.raises(ArgumentError, match=f'{argument}: expected a .*, got 0.3'):
        BaxterArm(**{argument: 0.3})


def test_replaced_parameters_are_copied_and_rederived():
    before = BaxterArm().parameters
    mass = 2.0 * before.mass
    doubled = replace(before, mass=mass)
    mass[:] = 0.0
    np.testing.assert_array_equal(doubled.mass, 2.0 * before.mass)
    np.testing.assert_array_equal(doubled.pseudo_inertia[:, 3], 2.0 * before.pseudo_inertia[:, 3])
    with pytest.raises(ArgumentError, match='mass: expected shape'):
        replace(before, mass=np.ones(6))
