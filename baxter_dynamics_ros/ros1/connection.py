"""Connection to one publisher of one topic, with reconnection."""

from collections.abc import Callable
from contextlib import closing
import struct
import threading
import time
from typing import Any

from .errors import Malformed, Ros1Error, Stage
from .joint_state import JointState, parse
from .network import Endpoint, endpoint
from .rpc import call
from .tcpros import Stream

FIRST_PAUSE, LAST_PAUSE = 0.1, 1.0  # [s], before reconnecting: doubled after each failure


class Connection:
    """
    Receiver of the messages of one publisher, in its own thread.

    Parameters
    ----------
    topic, uri, caller_id : str
        The topic, the publisher's URI and the name of this node.
    address_of : callable
        Returns the address of a host.
    on_message : callable
        Called with this connection, the joint state and its time of arrival [ns].

    """

    def __init__(self, topic: str, uri: str, caller_id: str, address_of: Callable[[str], str],
                 on_message: Callable[['Connection', JointState, int], None]) -> None:
        self.topic = topic
        self.uri = uri
        self.publisher = ''  # name; empty before the first connection
        self.connected = False
        self.since = time.monotonic()  # start of the latest connection [s]
        self.connections = 0  # number of connections so far
        self.malformed = 0  # number of malformed headers and messages
        self.problem: Ros1Error | None = None  # why the connection is closed
        self._caller_id = caller_id
        self._address_of = address_of
        self._on_message = on_message
        self._stream: Stream | None = None
        self._pause = FIRST_PAUSE
        self._ended = threading.Event()
        threading.Thread(target=self._run, daemon=True, name=f'ros1 {topic}').start()

    def stop(self) -> None:
        """Close the connection; no delivery starts after the return."""
        self._ended.set()
        stream = self._stream
        if stream is not None:
            stream.interrupt()

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                self._receive()
            except Ros1Error as error:
                self.problem = error
            except Malformed as error:
                self.malformed += 1
                self.problem = Ros1Error(
                    Stage.STREAM, f'{self.uri} sent a malformed message on {self.topic} '
                    f'({error})', 'reconnecting; restart the publisher if this persists')
            except (OSError, EOFError, struct.error, ValueError) as error:
                # ValueError: the stream was closed by stop().
                self.problem = Ros1Error(
                    Stage.STREAM, f'the connection to {self.uri} ended ({error})',
                    'reconnecting; is the publisher running?')
            self.connected, self._stream = False, None
            self._ended.wait(self._pause)
            self._pause = min(2 * self._pause, LAST_PAUSE)

    def _receive(self) -> None:
        """Connect, and deliver messages until an exception ends the connection."""
        with closing(self._open()) as stream:
            self._stream = stream
            self.publisher = stream.publisher or self.uri
            self.since = time.monotonic()
            self.connected, self.problem = True, None
            self.connections += 1
            while True:
                data = stream.read()
                arrival_ns = time.time_ns()
                state = parse(data)
                if self._ended.is_set():
                    return
                self._pause = FIRST_PAUSE
                self._on_message(self, state, arrival_ns)

    def _open(self) -> Stream:
        node = endpoint(self.uri)
        server = Endpoint(self._address_of(node.host), node.port)
        host, port = call(server, Stage.PUBLISHER, self._parse, 'requestTopic', self._caller_id,
                          self.topic, [['TCPROS']])
        return Stream(self._address_of(host), port, self.topic, self._caller_id)

    def _parse(self, answer: Any) -> tuple[str, int]:
        """Return the host and port in a publisher's answer to ``requestTopic``."""
        match answer:
            case ['TCPROS', str(host), int(port)] if 0 < port < 2 ** 16:
                return host, port
        raise Ros1Error(Stage.PUBLISHER, f'{self.uri} does not offer TCPROS',
                        'is it a ROS 1 node? Only TCPROS is supported')
