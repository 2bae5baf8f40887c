"""Residual of real recordings, streamed through the running node."""

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

# N m, s0 ... w2; uncalibrated.
LIMIT = np.array([1.1, 1.05, 0.9, 0.65, 0.16, 0.35, 0.22])
PIECE = 500  # rows of each of four recordings: 20 s together
STAMP_JITTER = 4e-5  # sd of the robot's own stamps [s]


@pytest.mark.timeout(180)
def test_residual_on_recordings(robot, start_predictor, recordings):
    with np.load(recordings / 'baxter_left_arm_tracking.npz') as file:
        data = {key: file[key] for key in file}
    start_predictor('-p', 'arm:=left')
    random = np.random.default_rng(0)
    order = [tuple(data['joint_names']).index(name) for name in joint_names('left')]
    for number, recording in enumerate((0, 2, 6, 10)):
        rows = np.flatnonzero(data['recording'] == recording)[1000:1000 + PIECE]
        piece = [(data['position'][row][order], data['velocity'][row][order],
                  data['effort'][row][order]) for row in rows]
        jitter = np.round(random.normal(0.0, STAMP_JITTER, PIECE) * 1e9)
        start = (1700000000 + 60 * number) * 10 ** 9
        for k, row in enumerate(piece):
            robot.spin(0.001)
            stamp = start + round(k * float(data['period']) * 1e9) + int(jitter[k])
            robot.send(stamp, ['l_gripper_l_finger_joint'], [0.0], [0.0], [0.0])
            robot.send_arm(stamp, *row, side='left')
    # Each piece settles anew, after a message that confirms the gap.
    settled = 4 * PIECE - 4 * 21 - 3
    robot.until(lambda: len(robot.residual) >= settled)
    residual = np.array([message.effort for message in robot.residual])
    assert len(residual) == settled
    rms = np.sqrt(np.mean(residual ** 2, axis=0))
    print('residual RMS [N m]:', rms.round(3))
    assert (rms <= LIMIT).all(), rms
