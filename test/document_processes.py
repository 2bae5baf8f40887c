"""Processes that a document starts: in groups of their own, ended as from a terminal."""

import os
import re
import signal
import subprocess
import tempfile
import time

LIMIT = 100.0  # [s] for a command that ends by itself
STARTED = 30.0  # [s] until one that runs for ever says something
GRACE = 5.0  # [s] between being asked to end and being killed


class Failure(AssertionError):
    """A command does not do what a reader expects of it."""


def run(words: list, folder, environment: dict) -> str:
    """Run a command to its end and return what it prints; it must exit with 0."""
    process = Background(words, folder, environment)
    try:
        code = process.wait(LIMIT)
    finally:
        process.end()
    if code != 0:
        raise Failure(f'exit code {code}\n{process.output}')
    if 'Traceback' in process.output:
        raise Failure(process.output)
    return process.output


class Background:
    """A command that runs beside others, until its end is asked for."""

    def __init__(self, words: list, folder, environment: dict):
        self.words = words
        self._output = tempfile.TemporaryFile('w+')
        try:
            self._process = subprocess.Popen(
                words, cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                stdout=self._output, stderr=subprocess.STDOUT, start_new_session=True)
        except OSError as error:
            raise Failure(str(error)) from None

    @property
    def output(self) -> str:
        """Output so far, stdout and stderr."""
        self._output.seek(0)
        return self._output.read()

    def wait(self, seconds: float) -> int:
        """Return the exit code when it ends by itself."""
        try:
            return self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            raise Failure(f'has not ended within {seconds:.0f} s\n{self.output}') from None

    def wait_for(self, sign: str, times: int = 1):
        """
        Wait until it has said something, the sign that it is up; fail where it ends instead.

        Parameters
        ----------
        sign : str
            Regular expression.
        times : int
            How many different matches it takes.

        """
        limit = time.monotonic() + STARTED
        while len(set(re.findall(sign, self.output))) < times:
            self.check()
            if time.monotonic() > limit:
                raise Failure(f'no {sign!r} within {STARTED:.0f} s\n{self.output}')
            time.sleep(0.02)

    def check(self):
        """Fail where it has ended, or an exception shows."""
        if self._process.poll() is not None:
            raise Failure(f'has ended with exit code {self._process.poll()}\n{self.output}')
        if 'Traceback' in self.output or 'process has died' in self.output:
            raise Failure(self.output)

    def ask_to_end(self):
        """Send it and its children what Ctrl-C sends."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGINT)

    def end(self):
        """End it and its children."""
        self.ask_to_end()
        try:
            self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
