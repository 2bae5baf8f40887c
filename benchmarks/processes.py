"""What the benchmarks of nodes share: a domain of their own, waiting, costs of a process."""

from collections.abc import Callable
import os
from pathlib import Path
import time

import rclpy
from rclpy.node import Node


def isolate(domain: int) -> None:
    """Let nodes of this machine alone find each other, in a domain unless one is set."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', str(domain))


def spin(node: Node, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
    """Process messages for a while, or until a condition holds; return whether it holds."""
    limit = time.perf_counter() + seconds
    while not until():
        left = limit - time.perf_counter()
        if left <= 0.0:
            return False
        rclpy.spin_once(node, timeout_sec=min(left, 0.05))
    return True


def processor_time(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def resident(pid: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 2 ** 20
