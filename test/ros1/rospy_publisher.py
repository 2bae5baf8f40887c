"""
Publish joint states through the real rospy; run by the system's Python, for the tests.

The k-th message is a function of k, so that a receiver can tell exactly what was sent; or the
messages are the lines of a file, each a JSON list of stamp [ns], names and three lists of numbers.
"""

import argparse
import json
import time

import rospy
from sensor_msgs.msg import JointState

parser = argparse.ArgumentParser()
parser.add_argument('--name', default='robot')
parser.add_argument('--rate', type=float, default=100.0)
parser.add_argument('--count', type=int, default=10 ** 9)
parser.add_argument('--joints', default='')
parser.add_argument('--begin', type=int, default=0, help='stamp of the first message [ns]; 0: now')
parser.add_argument('--behind', type=float, default=0.0, help="the robot's clock, behind ours [s]")
parser.add_argument('--subscribers', type=int, default=1)
parser.add_argument('--play', type=argparse.FileType(), default=())
options = parser.parse_args(rospy.myargv()[1:])

rospy.init_node(options.name, disable_signals=True)
publisher = rospy.Publisher('/robot/joint_states', JointState, queue_size=10000, tcp_nodelay=True)
names = options.joints.split()
rows = [json.loads(line) for line in options.play]


def message(k):
    """Return the k-th message."""
    if rows:
        stamp, *fields = rows[k]
    else:
        stamp = (options.begin + round(k * 1e9 / options.rate) if options.begin
                 else time.time_ns() - round(options.behind * 1e9))
        values = [k + 0.001 * i for i in range(len(names))]
        fields = names, values, [-x for x in values], [2 * x for x in values]
    state = JointState(None, *fields)
    state.header.stamp = rospy.Time(*divmod(stamp, 10 ** 9))
    return state


print('ready', flush=True)
while publisher.get_num_connections() < options.subscribers:
    time.sleep(0.01)
begin = time.monotonic()
for k in range(len(rows) or options.count):
    wait = begin + k / options.rate - time.monotonic()
    if wait > 0.0:
        time.sleep(wait)
    publisher.publish(message(k))
print('done', flush=True)
time.sleep(1e6)  # the connections stay
