"""Shared by the benchmarks of nodes: ROS domain, waiting, costs of a process."""

from collections.abc import Callable
import os
from pathlib import Path
import time

import rclpy
from rclpy.node import Node


def isolate(domain: int) -> None:
    """Restrict discovery to this machine and, unless one is set, to a domain."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', str(domain))


def spin(node: Node, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
    """Process messages for a while, or until a condition holds; return whether it holds."""
    limit = time.perf_counter() + seconds
    while not (holds := until()) and (left := limit - time.perf_counter()) > 0.0:
        rclpy.spin_once(node, timeout_sec=min(left, 0.05))
    return holds


def costs(pid: int) -> tuple:
    """Return processor time [s] and resident memory [MB] of a process."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return ((int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK'),
            int(fields[21]) * os.sysconf('SC_PAGE_SIZE') / 2 ** 20)
