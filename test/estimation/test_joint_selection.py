"""Joint selection: one arm's values by name, and NaN as 'not available'."""

from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.stream import JointSelector
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

ALPHABETICAL = ('e0', 'e1', 's0', 's1', 'w0', 'w1', 'w2')
# The message of the robot's own publisher.
SDK = ('head_nod', 'head_pan', *(f'left_{joint}' for joint in ALPHABETICAL),
       *(f'right_{joint}' for joint in ALPHABETICAL), 'torso_t0')
GRIPPER = ('right_gripper_l_finger_joint', 'right_gripper_r_finger_joint')
FIELDS = ('position', 'velocity', 'effort')
EMPTY = np.empty(0)

pytestmark = pytest.mark.filterwarnings('error')


def values(names) -> dict:
    """Return the fields of a message; values differ between the joints of SDK."""
    k = np.array([SDK.index(name) if name in SDK else len(SDK) for name in names], dtype=float)
    return {'position': 0.1 * k + 0.01, 'velocity': k + 0.02, 'effort': 10.0 * k + 0.03}


@pytest.fixture
def selector():
    return JointSelector('right')


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('arrange', [list, lambda names: names[::-1], lambda names: sorted(
    names, key=lambda name: (name[-1], name))], ids=['sdk', 'reversed', 'shuffled'])
def test_picks_the_joints_by_name(side, arrange):
    names = arrange(SDK)
    wanted = values([f'{side}_{joint}' for joint in ('s0', 's1', 'e0', 'e1', 'w0', 'w1', 'w2')])
    for read, field in zip(JointSelector(side).read(names, **values(names)), FIELDS):
        np.testing.assert_array_equal(read, wanted[field])


@pytest.mark.parametrize('missing', [('velocity',), ('effort',), ('velocity', 'effort')])
@pytest.mark.parametrize('joint', [None, *joint_names('right')])  # with NaN; None: empty fields
def test_missing_velocity_and_effort_are_none(selector, missing, joint):
    message, wanted = values(SDK), values(joint_names('right'))
    for field in missing:
        if joint:
            message[field][SDK.index(joint)] = np.nan
        else:
            message[field] = EMPTY
    for field, read in zip(FIELDS, selector.read(SDK, **message)):
        if field in missing:
            assert read is None
        else:
            np.testing.assert_array_equal(read, wanted[field])
    message['position'][SDK.index(joint or 'right_s0')] = 7.0
    assert selector.read(SDK, **message) is Event.IMPLAUSIBLE


@pytest.mark.parametrize('names, event', [
    ((), Event.NOT_THIS_ARM),
    (GRIPPER, Event.NOT_THIS_ARM),
    (joint_names('left'), Event.NOT_THIS_ARM),
    (('right_s0_extra', 's0'), Event.NOT_THIS_ARM),
    (joint_names('right')[:6], Event.INCOMPLETE_ARM),
    (joint_names('left') + ('right_w2',), Event.INCOMPLETE_ARM),
    (joint_names('right') + ('right_e1',), Event.DUPLICATE_JOINT),
    (joint_names('right')[:6] + ('right_s0',), Event.DUPLICATE_JOINT),
], ids=['empty', 'gripper', 'other arm', 'similar names', 'six joints', 'one joint',
        'eight joints', 'one for another'])
def test_names_without_a_complete_arm(selector, names, event):
    assert selector.read(names, **values(names)) is event


@pytest.mark.parametrize('field', FIELDS)
@pytest.mark.parametrize('n', [1, len(SDK) - 1, len(SDK) + 1])
def test_length_mismatch(selector, field, n):
    message = values(SDK) | {field: np.ones(n)}
    assert selector.read(SDK, **message) is Event.LENGTH_MISMATCH


@pytest.mark.parametrize('joint', joint_names('right'))
@pytest.mark.parametrize('field, value', [
    ('position', np.nan), *((field, sign * np.inf) for field in FIELDS for sign in (1, -1))])
def test_non_finite(selector, field, joint, value):
    message = values(SDK)
    message[field][SDK.index(joint)] = value
    if field != 'effort':
        message['effort'][SDK.index('right_e1')] = 1e9  # implausible, but not reported first
    assert selector.read(SDK, **message) is Event.NON_FINITE


def test_prefix(selector):
    prefixed = JointSelector('right', 'robot_1/')
    names = tuple('robot_1/' + name for name in SDK)
    for found, wanted in zip(prefixed.read(names, **values(SDK)),
                             selector.read(SDK, **values(SDK))):
        np.testing.assert_array_equal(found, wanted)
    assert prefixed.names[0] == 'robot_1/right_s0'
    assert prefixed.other_names is None
    assert prefixed.read(SDK, **values(SDK)) is Event.NOT_THIS_ARM
    assert prefixed.other_names == SDK


@pytest.mark.parametrize('field', FIELDS)
def test_non_finite_value_of_another_joint_does_not_matter(selector, field):
    message = values(SDK)
    for joint, value in zip(('head_pan', 'left_e0', 'torso_t0'), (np.nan, np.inf, 1e300)):
        message[field][SDK.index(joint)] = value
    q, _, _ = selector.read(SDK, **message)
    np.testing.assert_array_equal(q, values(joint_names('right'))['position'])


@pytest.mark.parametrize('field, bound', [
    ('position', 2 * np.pi), ('velocity', 40.0), ('effort', 1000.0)], ids=FIELDS)
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_implausible(selector, field, bound, sign):
    for joint in joint_names('right'):
        message = values(SDK)
        message[field][SDK.index(joint)] = sign * bound
        assert isinstance(selector.read(SDK, **message), tuple)
        message[field][SDK.index(joint)] *= 1 + 1e-12
        assert selector.read(SDK, **message) is Event.IMPLAUSIBLE
