"""Nodes as child processes."""

from collections.abc import Sequence
import signal
import subprocess
import sys
import tempfile

_GRACE = 5.0  # [s] between the signal to end and killing the process


class NodeProcess:
    """
    A node of this package as a child process; a context manager that ends it.

    Parameters
    ----------
    executable : str
        Module below ``nodes``, such as 'torque_predictor'.
    arguments : list of str
        Command line, such as ``['--ros-args', '-p', 'align:=false']``.
    environment : dict, optional
        Environment; that of this process by default. The ROS wheels need either both
        LD_LIBRARY_PATH and their guard variable or neither, so copy it whole.

    """

    def __init__(self, executable: str, arguments: Sequence[str] = (),
                 environment: dict[str, str] | None = None) -> None:
        self.executable = executable
        self._output = tempfile.TemporaryFile('w+')
        self._process = subprocess.Popen(
            [sys.executable, '-m', f'baxter_dynamics_ros.nodes.{executable}', *arguments],
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT,
            env=environment)

    def __enter__(self) -> 'NodeProcess':
        """Return this process."""
        return self

    def __exit__(self, *exception: object) -> None:
        """End the process."""
        self.end()
        self._output.close()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> 'int | None':
        """Exit code; None while it runs."""
        return self._process.poll()

    @property
    def output(self) -> str:
        """Output so far, stdout and stderr."""
        self._output.seek(0)
        return self._output.read()

    def wait(self, timeout: float) -> int:
        """Wait for the process to end by itself; return its exit code or raise TimeoutExpired."""
        return self._process.wait(timeout)

    def end(self, by: int = signal.SIGINT) -> int:
        """Send a signal, kill the process if it does not end, and return its exit code."""
        if self._process.poll() is None:
            self._process.send_signal(by)
            try:
                self._process.wait(_GRACE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        return self._process.returncode
