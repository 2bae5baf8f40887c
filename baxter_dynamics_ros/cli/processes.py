"""Nodes as child processes."""

from collections.abc import Sequence
import signal
import subprocess
import sys
import tempfile

_GRACE = 5.0  # [s] between the signal to end and killing the process


class NodeProcess(subprocess.Popen[str]):
    """
    A node of this package, such as 'torque_predictor', as a child; a context manager ends it.

    An environment must be a whole copy of this process's: the ROS wheels need either both
    LD_LIBRARY_PATH and their guard variable or neither.
    """

    def __init__(self, executable: str, arguments: Sequence[str] = (),
                 environment: dict[str, str] | None = None) -> None:
        self.executable, self._output = executable, tempfile.TemporaryFile('w+')
        super().__init__(
            [sys.executable, '-m', f'baxter_dynamics_ros.nodes.{executable}', *arguments],
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT,
            env=environment)

    def __exit__(self, *exception: object) -> None:
        """End the process."""
        self.end()
        self._output.close()

    @property
    def output(self) -> str:
        """Output so far, stdout and stderr."""
        self._output.seek(0)
        return self._output.read()

    def end(self, by: int = signal.SIGINT) -> int:
        """Send a signal, kill the process if it does not end, and return its exit code."""
        if self.poll() is None:
            self.send_signal(by)
            try:
                self.wait(_GRACE)
            except subprocess.TimeoutExpired:
                self.kill()
        return self.wait()
