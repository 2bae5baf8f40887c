"""A real ROS 1 master and real rospy publishers as processes: Debian's packages."""

from functools import cache
import os
from pathlib import Path
import socket
import subprocess
import tempfile
import time
import xmlrpc.client

PYTHON = '/usr/bin/python3'
PUBLISHER = Path(__file__).with_name('ros1') / 'rospy_publisher.py'
MISSING = ('needs the ROS 1 master and rospy of Debian: apt-get install python3-rosmaster '
           'python3-rospy python3-sensor-msgs')
_MASTER = ('import sys; from rosmaster.main import rosmaster_main; '
           'rosmaster_main(["rosmaster", "--core", "-p", sys.argv[1], "-w", "3"])')
# Without this Python's paths, which hold ROS 2's messages.
_ENVIRONMENT = {key: os.environ[key] for key in ('PATH', 'HOME', 'LANG') if key in os.environ}


@cache
def available() -> bool:
    """Return whether the system's Python has rosmaster, rospy and sensor_msgs."""
    return os.path.exists(PYTHON) and subprocess.run(
        [PYTHON, '-c', 'import rosmaster, rospy, sensor_msgs.msg'], env=_ENVIRONMENT,
        capture_output=True, timeout=60).returncode == 0


class Ros1:
    """ROS 1 on a port of its own; a context manager that ends all of its processes."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory()
        self._processes = []
        with socket.socket() as free:
            free.bind(('127.0.0.1', 0))
            self.port = free.getsockname()[1]
        self.uri = f'http://127.0.0.1:{self.port}'

    def __enter__(self):
        """Start the master."""
        self.master = self.start_master()
        return self

    def __exit__(self, *exception):
        """End all processes."""
        for process in self._processes:
            if process.poll() is None:
                process.kill()
            process.wait()
            process.stdout.close()
        self._folder.cleanup()

    def start_master(self):
        """Start a master, and return its process once it answers."""
        process = self.start(['-c', _MASTER, str(self.port)])
        limit = time.monotonic() + 20.0
        while time.monotonic() < limit:
            try:
                self.state()
                return process
            except OSError:
                time.sleep(0.05)
        raise AssertionError('the ROS 1 master does not answer')

    def publish(self, *arguments, address='127.0.0.1'):
        """Start a publisher as rospy_publisher.py takes it; return its process once ready."""
        process = self.start([str(PUBLISHER), *map(str, arguments)], ROS_HOSTNAME=address)
        assert process.stdout.readline() == b'ready\n'
        return process

    def state(self):
        """Return the master's publishers, subscribers and services: name to nodes, each."""
        proxy = xmlrpc.client.ServerProxy(self.uri)
        return [dict(side) for side in proxy.getSystemState('/test')[2]]

    def everything(self):
        """Return all that the master knows: state, types, parameters."""
        proxy = xmlrpc.client.ServerProxy(self.uri)
        parameters = proxy.getParam('/test', '/')[2]
        return self.state(), sorted(proxy.getTopicTypes('/test')[2]), parameters

    def kill(self, process):
        """Kill a process, which then cannot unregister."""
        process.kill()
        process.wait()

    def start(self, command, stdin=subprocess.DEVNULL, **environment):
        """Start the system's Python with arguments; return its process."""
        process = subprocess.Popen(
            [PYTHON, *command], stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            env={**_ENVIRONMENT, 'ROS_MASTER_URI': self.uri, 'ROS_HOSTNAME': '127.0.0.1',
                 'ROS_LOG_DIR': self._folder.name, 'ROS_HOME': self._folder.name, **environment})
        self._processes.append(process)
        return process
