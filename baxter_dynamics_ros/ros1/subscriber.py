"""Subscriber to topics of a ROS 1 robot, connected to every publisher of each topic."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, field
from math import inf
import os
import random
import threading
import time
from typing import Any
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

from .source import Source
from .wire import (call, endpoint, JointState, Malformed, Master, MessageStream, parse, resolve,
                   Ros1Error)

PERIOD = 1.0  # longest time between polls of the master [s]
REST = 0.1  # shortest time between them, however often this node is called [s]
MAX_PUBLISHERS = 64  # per topic
SILENCE = 2.0  # time without a message before a topic is reported as silent [s]
FIRST_PAUSE, LAST_PAUSE = 0.1, 1.0  # [s], before reconnecting: doubled after each failure

OnMessage = Callable[[str, Source, JointState, int], None]


@dataclass(eq=False)
class Connection:
    """Connection to one publisher of a topic; a thread restores it until end() is called."""

    topic: str
    uri: str
    publisher: str  # name
    stream: MessageStream | None = None  # None while not connected
    since: float = 0.0  # monotonic time of the latest connection [s]; 0 before the first
    pause: float = FIRST_PAUSE  # before reconnecting [s]
    problem: Ros1Error | None = None  # why it is not connected
    ended: threading.Event = field(default_factory=threading.Event)

    def fail(self, stage: str, cause: str, remedy: str) -> None:
        """Set the problem, and name the publisher in it."""
        self.problem = Ros1Error(stage, f'{self.publisher} at {self.uri}: {cause}', remedy)

    def end(self) -> None:
        """Close the connection for good."""
        self.ended.set()
        if (stream := self.stream) is not None:
            stream.interrupt()


class Subscriber:
    """
    Subscriber to topics of ``sensor_msgs/JointState``; starts at once, in its own threads.

    One thread polls the master once a second, and whenever the master calls. It registers topics
    that the master does not know, and keeps a connection to each of their publishers.
    ``on_message`` is called with topic, :class:`Source`, :class:`JointState` and time of arrival
    [ns], from one thread at a time, and ``log`` with each log line. Raises Ros1Error if the URI
    of the master is malformed.
    """

    def __init__(self, master_uri: str, topics: Iterable[str], on_message: OnMessage,
                 log: Callable[[str], None], name: str = '/joint_state_bridge') -> None:
        self.name = f'{name}_{os.getpid()}_{random.randrange(16 ** 6):06x}'
        self.master = Master(master_uri, self.name)
        self.topics = tuple(topics)
        self.problem: Ros1Error | None = Ros1Error(  # of the last poll of the master
            'master', f'no answer from {master_uri} yet', 'is the robot switched on?')
        self.malformed = 0  # number of malformed headers and messages
        self.reconnections = 0  # number of connections after the first to each publisher
        self._on_message = on_message
        self._log = log
        self._connections: dict[tuple[str, str], Connection] = {}  # by topic and URI
        self._sources: dict[tuple[str, str], Source] = {}  # by topic and name
        self._substituted: dict[str, str] = {}  # hosts replaced by the master's address
        self._api = ''  # URI of this node's callback server
        self._is_called = False  # whether the master has called since the probe
        self._probed = inf  # monotonic time of the reachability probe [s]
        self._heard: dict[str, float] = {}  # monotonic time of a topic's last message [s]
        self._lock = threading.Lock()  # of deliveries and counts
        self._ended, self._wake = threading.Event(), threading.Event()
        self._server = SimpleXMLRPCServer(('', 0), _Handler, logRequests=False)
        self._server.register_instance(self)
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True).start()
        self._poller = threading.Thread(target=self._run, daemon=True)
        self._poller.start()

    def close(self) -> None:
        """Close all connections and unregister; no delivery starts after the return."""
        with self._lock:
            self._ended.set()
        self._wake.set()
        self._poller.join(3.0)  # the resolution of a name may take longer

    def connections(self, topic: str) -> list[Connection]:
        """Return the connections to a topic's publishers."""
        return [each for each in list(self._connections.values()) if each.topic == topic]

    def sources(self, topic: str) -> list[Source]:
        """Return the statistics of every publisher that has sent on a topic."""
        return [each for (of, _), each in list(self._sources.items())
                if of == topic and each.received]

    def problems(self, topic: str) -> list[Ros1Error]:
        """Return the reasons why messages of a topic do not arrive, most important first."""
        if self.problem is not None:
            return [self.problem]
        connections = self.connections(topic)
        if not connections:
            return [Ros1Error('topic', f'{topic} is not published',
                              'has the robot finished starting? Check the name of the topic; '
                              'after a restart of the master alone, restart the robot')]
        found = [each.problem for each in connections if each.problem is not None]
        if self.is_called is False:
            found.append(Ros1Error(
                'address', f'the master does not reach this machine at {self._api}',
                "unset ROS_HOSTNAME, set ROS_IP to this machine's address in the robot's network, "
                'and open its firewall; until then, new publishers are found by polling'))
        if self.is_silent(topic) and any(each.stream and time.monotonic() - each.since > SILENCE
                                         for each in connections):
            found.append(Ros1Error(
                'stream', f'nothing has arrived on {topic} for {SILENCE:g} s',
                'is the publisher stopped, or the network down?'))
        return found

    def is_silent(self, topic: str) -> bool:
        """Return whether no message has arrived on a topic for SILENCE."""
        return time.monotonic() - self._heard.get(topic, -inf) > SILENCE

    @property
    def is_called(self) -> bool | None:
        """Return whether the master can call this node; None until the probe has ended."""
        if self._is_called:
            return True
        return False if time.monotonic() - self._probed > SILENCE else None

    def _run(self) -> None:
        """Poll the master until stopped, then unregister."""
        while not self._ended.is_set():
            self._wake.clear()
            try:
                self._poll()
                self.problem = None
            except Ros1Error as error:
                self.problem = error
            if not self._ended.wait(REST):
                self._wake.wait(PERIOD - REST)
        self._follow({})
        with suppress(Ros1Error):  # the master is gone, and the registration with it
            for topic in self.topics if self._api else ():
                self.master.ask('unregisterSubscriber', topic, self._api, parse=bool)
        self._server.shutdown()
        self._server.server_close()

    def _poll(self) -> None:
        api = f'http://{self.master.locate()}:{self._server.server_address[1]}/'
        moved, self._api = api != self._api, api
        publishers, subscribers = self.master.system_state()
        wanted: dict[tuple[str, str], str] = {}
        for topic in self.topics:
            if moved or self.name not in subscribers.get(topic, ()):
                self._register(topic)
            wanted |= {(topic, uri): name for uri, name in self._uris(publishers.get(topic, []))}
        self._follow(wanted)

    def _uris(self, names: list[str]) -> Iterator[tuple[str, str]]:
        """Yield URI and name of the first MAX_PUBLISHERS nodes, except those that have gone."""
        for name in names[:MAX_PUBLISHERS]:
            try:
                yield self.master.ask('lookupNode', name, parse=str), name
            except Ros1Error as error:
                if error.stage != 'master':  # the master does not answer
                    raise

    def _register(self, topic: str) -> None:
        """
        Register a topic, and make the master call this node, to find out whether it can.

        The first topic is registered with another spelling of the callback URI beforehand. Once
        the right one is registered, the master calls ``shutdown`` on the other, because one name
        belongs to one node. The type ``*`` leaves no trace of a topic without publishers.
        """
        if topic == self.topics[0]:
            self._is_called, self._probed = False, time.monotonic()
            self.master.ask('registerSubscriber', topic, '*', self._api + 'RPC2', parse=bool)
        self.master.ask('registerSubscriber', topic, '*', self._api, parse=bool)

    def _dispatch(self, method: str, arguments: Any) -> tuple[int, str, int]:
        """Answer a call of the master: the next poll finds what has changed."""
        if method not in ('publisherUpdate', 'shutdown', 'getPid'):
            return -1, 'not supported', 0
        if method != 'getPid':  # which rosnode asks
            self._is_called = True
            self._wake.set()
        return 1, '', 0

    def _follow(self, wanted: dict[tuple[str, str], str]) -> None:
        """Connect to exactly these publishers: topic and URI to name."""
        before = self._connections
        self._connections = {key: before.get(key) or Connection(*key, name)
                             for key, name in wanted.items()}
        for key in before.keys() - wanted.keys():
            before[key].end()
        for key in wanted.keys() - before.keys():
            threading.Thread(target=self._keep_up, args=(self._connections[key],),
                             daemon=True).start()

    def _keep_up(self, connection: Connection) -> None:
        """Receive messages, reconnecting until the connection is ended."""
        while not connection.ended.is_set():
            try:
                self._receive(connection)
            except Ros1Error as error:
                connection.fail(error.stage, error.cause, error.remedy)
            except Malformed as error:
                with self._lock:
                    self.malformed += 1
                connection.fail('stream', f'malformed message on {connection.topic} ({error})',
                                'reconnecting; restart the publisher if this persists')
            except Exception as error:  # OSError, or any of on_message
                connection.fail('stream', f'connection ended ({type(error).__name__}: {error})',
                                'reconnecting; is the publisher running?')
            connection.stream = None
            connection.ended.wait(connection.pause)
            connection.pause = min(2 * connection.pause, LAST_PAUSE)

    def _receive(self, connection: Connection) -> None:
        """Connect, and deliver messages until an exception ends the connection."""
        topic, (host, port) = connection.topic, endpoint(connection.uri)
        match call(self._address(host), port, 'publisher', list, 'requestTopic', self.name, topic,
                   [['TCPROS']]):
            case ['TCPROS', str(host), int(port)]:
                stream = MessageStream(self._address(host), port)
            case _:
                raise Ros1Error('publisher', 'the publisher does not offer TCPROS',
                                'is it a ROS 1 node? Only TCPROS is supported')
        with closing(stream):
            name = stream.subscribe(topic, self.name) or connection.publisher
            with self._lock:
                self.reconnections += bool(connection.since)
                source = self._sources.setdefault((topic, name), Source(name))
            connection.since = time.monotonic()
            connection.publisher, connection.problem, connection.stream = name, None, stream
            while not connection.ended.is_set():
                data = stream.read()
                arrival_ns = time.time_ns()
                state = parse(data)
                self._heard[topic], connection.pause = time.monotonic(), FIRST_PAUSE
                with self._lock:
                    if not self._ended.is_set() and source.take(connection.uri, state, arrival_ns):
                        self._on_message(topic, source, state, arrival_ns)

    def _address(self, host: str) -> str:
        """Return the address of a host, or the master's if the name leads to no other machine."""
        master = self.master.address
        if self._substituted.get(host.lower()) == master:
            return master
        try:
            address = resolve(host)
            if not address.startswith('127.') or master.startswith('127.'):
                return address
            reason = f'is {address}, which is this machine'
        except Ros1Error:
            reason = 'does not resolve'
        self._substituted[host.lower()] = master
        self._log(f'{host} {reason}: using the address of the master, {master}, for it')
        return master


class _Handler(SimpleXMLRPCRequestHandler):
    """Request handler with bounded length and time."""

    timeout = 2.0  # [s]

    def do_POST(self) -> None:  # noqa: N802
        """Answer a request of at most 999,999 bytes."""
        length = self.headers.get('content-length', '')
        if length.isdecimal() and len(length) <= 6:
            super().do_POST()
        else:
            self.send_error(413)
        self.close_connection = True  # a client must not occupy the only thread
