"""Joint states to be written to bags, and the comparison with those read from them."""

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np

TOPIC = '/robot/joint_states'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT, LEFT = joint_names('right'), joint_names('left')
ROBOT = ('head_nod', 'head_pan', *LEFT, *RIGHT, 'torso_t0')
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
KINDS = ['mcap', 'sqlite3', 'ros1']  # of bags


def states(n, names=RIGHT, topic=TOPIC, start=START):
    """Return n joint states 10 ms apart, each received 1 ms after its stamp, for make_bag."""
    draw = np.random.default_rng(n).normal
    return [(topic, stamp + 1_000_000, (stamp, names, *draw(size=(3, len(names)))))
            for stamp in range(start, start + n * 10_000_000, 10_000_000)]


def assert_played(recording, messages):
    """Assert that a recording yields the joint states in messages, all and in this order."""
    played = list(recording)
    assert len(played) == recording.count == len(messages)
    for state, (_, received_ns, (stamp_ns, names, *arrays)) in zip(played, messages):
        assert (state.stamp_ns, tuple(state.names)) == (stamp_ns, tuple(names))
        assert state.received_ns == received_ns
        for array, wanted in zip(state[2:5], arrays):
            assert array.dtype == np.float64
            np.testing.assert_array_equal(array, wanted)
