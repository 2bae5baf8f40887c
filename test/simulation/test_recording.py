"""A recording of the fake Baxter is what the robot publishes, in the order of its stamps."""

import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.recorder import record  # noqa: E402, I100
from baxter_dynamics_ros.simulation.robot import (  # noqa: E402
    FakeBaxter, GRIPPER_NAMES, JOINT_STATE_NAMES)


@pytest.mark.parametrize('rate', [50.0, 1000.0])
def test_a_recording_is_what_the_robot_publishes(rate):
    messages = list(record(FakeBaxter(seed=2), 1.5, rate, seed=4))
    stamps = np.array([stamp for stamp, *_ in messages])
    assert (np.diff(stamps) > 0).all()
    arms = [m for m in messages if m[1] == JOINT_STATE_NAMES]
    grippers = [m for m in messages if m[1] == GRIPPER_NAMES]
    assert len(messages) == len(arms) + len(grippers)
    assert len(arms) == round(1.5 * rate)
    assert len(grippers) == 57
    ticks = 10 ** 18 + np.arange(1, len(arms) + 1) / rate * 1e9
    jitter = np.array([m[0] - 10 ** 18 for m in arms]) - (ticks - 10 ** 18)
    assert 3e-5 < jitter.std() * 1e-9 < 5e-5
    np.testing.assert_allclose(np.diff([m[0] for m in grippers]), 1e9 / 38, atol=1.0)
    robot = FakeBaxter(seed=2)
    for k, message in enumerate(arms[:20]):
        robot.advance((k + 1) / rate)
        np.testing.assert_array_equal(message[2:], robot.joint_state())


def test_a_recording_goes_on_from_where_the_robot_is_and_repeats_by_its_seed():
    def recorded(seed):
        robot = FakeBaxter(seed=seed)
        robot.advance(2.5)
        return list(record(robot, 0.2, 100.0, seed)), robot.time
    (first, time), (second, _), (other, _) = (recorded(seed) for seed in (1, 1, 2))
    assert time == pytest.approx(2.7)
    assert first[0][0] == pytest.approx(10 ** 18 + 10 ** 7, abs=5e5)
    for a, b in zip(first, second):
        assert a[:2] == b[:2]
        np.testing.assert_array_equal(a[2:], b[2:])
    assert [m[0] for m in first] != [m[0] for m in other]
