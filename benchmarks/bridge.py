"""
Compare joint_state_bridge with a rospy subscriber on the same streams.

Uses a ROS 1 master and rospy publishers: two at 100 and 38 Hz, as on Baxter, or one at 800 Hz.
Measures lost and duplicate messages, stamps that differ from those received by rospy, and latency
from publishing in ROS 1 to receiving in ROS 2. Run: python benchmarks/bridge.py [--seconds 120]
"""

import argparse
from pathlib import Path
import subprocess
import sys
import time

from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.nodes.messages import stamp_ns
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
import numpy as np
from processes import costs, isolate, spin
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
from ros1_processes import available, MISSING, Ros1  # noqa: E402, I100

TOPIC = '/robot/joint_states'
ARMS, GRIPPERS = ' '.join(JOINT_STATE_NAMES), 'l_gripper_l_finger_joint l_gripper_r_finger_joint'
STREAMS = {'100 and 38 Hz': ((100, ARMS), (38, GRIPPERS)), '800 Hz': ((800, ARMS),)}
SETTLE = 1.0  # initial time without latency measurement [s]
# Prints number, number of joints, stamp and time of arrival of each message.
ROSPY = """
import sys, time, rospy
from sensor_msgs.msg import JointState
rows = []
rospy.init_node('listener', disable_signals=True)
rospy.Subscriber('/robot/joint_states', JointState, lambda m: rows.append((
    int(m.position[0]), len(m.name), m.header.stamp.to_nsec(), time.time_ns())), tcp_nodelay=True)
print('ready', flush=True)
sys.stdin.readline()
for row in rows:
    print(*row)
"""


def measure(publishers, seconds: float) -> dict:
    """Run one stream; return the results of the bridge and of rospy."""
    rows = []
    node = Node('listener')
    node.create_subscription(JointState, TOPIC, lambda message: rows.append((
        int(message.position[0]), len(message.name), stamp_ns(message.header), time.time_ns())),
        1000)
    sent = {(k, len(joints.split())) for rate, joints in publishers
            for k in range(round(rate * seconds))}
    with Ros1() as ros1, NodeProcess('joint_state_bridge', [
            '--ros-args', '-p', f'master_uri:={ros1.uri}', '-p', 'clock:=robot']) as bridge:
        listener = ros1.start(['-c', ROSPY], stdin=subprocess.PIPE)
        listener.stdout.readline()
        spin(node, 30.0, lambda: node.count_publishers(TOPIC) and len(
            ros1.state()[1].get(TOPIC, ())) == 2)
        spin(node, 1.0)
        for i, (rate, joints) in enumerate(publishers):
            ros1.publish('--name', f'robot{i}', '--rate', rate, '--joints', joints, '--count',
                         round(rate * seconds), '--subscribers', 2)
        before, _ = costs(bridge.pid)
        spin(node, seconds + 10.0, lambda: len(rows) >= len(sent))
        spin(node, 1.0)  # duplicates
        after, _ = costs(bridge.pid)
        out, _ = listener.communicate(b'\n', 30.0)
    node.destroy_node()
    theirs = [tuple(map(int, line.split())) for line in out.splitlines()]
    result = {}
    for name, got in (('bridge', rows), ('rospy', theirs)):
        keys = [row[:2] for row in got]
        late = np.array([arrival - stamp for k, n, stamp, arrival in got
                         if k >= SETTLE * max(rate for rate, _ in publishers)]) * 1e-6
        result[name] = {'received': len(got), 'lost': len(sent - set(keys)),
                        'doubled': len(keys) - len(set(keys)), 'median [ms]': np.median(late),
                        'p99 [ms]': np.percentile(late, 99)}
    stamps = {row[:2]: row[2] for row in theirs}
    result['bridge'] |= {'CPU [%]': 100 * (after - before) / seconds, 'other stamps': sum(
        stamps[row[:2]] != row[2] for row in rows if row[:2] in stamps)}
    return result


def main():
    """Print one line per stream and subscriber, and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=120.0)
    options = parser.parse_args()
    if not available():
        raise SystemExit(MISSING)
    isolate(94)
    rclpy.init(args=[])
    for name, publishers in STREAMS.items():
        result = measure(publishers, options.seconds)
        for who, values in result.items():
            row = ', '.join(f'{key} {value:.6g}' for key, value in values.items())
            print(f'{name:14}{who:8}{row}')
        median, p99 = (result['bridge'][key] / result['rospy'][key]
                       for key in ('median [ms]', 'p99 [ms]'))
        print(f'{name:14}bridge / rospy: median {median:.2f}, p99 {p99:.2f}', flush=True)
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
