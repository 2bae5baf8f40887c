"""Subscriptions on a ROS 1 master: every publisher of every topic, for as long as it runs."""

from collections.abc import Callable, Iterable
import os
import random
import threading
import time

from .callbacks import CallbackServer
from .connection import Connection
from .errors import Ros1Error, Step
from .joint_state import JointState
from .master import Master
from .network import is_loopback, resolve
from .source import Source

PERIOD = 1.0  # [s] between two looks at the master
PATIENCE = 5.0  # [s] between two registrations because a publisher cannot be reached
SILENCE = 2.0  # [s] without a message are a problem
MAX_PUBLISHERS = 64  # of a topic

OnMessage = Callable[[str, Source, JointState, int], None]


class Subscriber:
    """
    Receives topics of ``sensor_msgs/JointState`` from all of their publishers.

    A thread looks at the master once a second: where it has forgotten this node, or the
    publishers are others, it registers again. Between two looks the master calls back.

    Parameters
    ----------
    master_uri : str
        Such as ``http://011303P0017.local:11311``.
    topics : iterable of str
        Names of the topics.
    on_message : callable
        Called with topic, :class:`Source`, :class:`JointState` and the time of arrival [ns], by
        one thread a publisher.
    log : callable
        Called with a line for the user.

    Attributes
    ----------
    master : Master
        The client of the master.
    name : str
        Name of this node at the master.
    problem : Ros1Error or None
        Why the master cannot be used.

    Raises
    ------
    Ros1Error
        If the URI is not one.

    """

    def __init__(self, master_uri: str, topics: Iterable[str], on_message: OnMessage,
                 log: Callable[[str], None], name: str = '/joint_state_bridge') -> None:
        self.name = f'{name}_{os.getpid()}_{random.randrange(16 ** 6):06x}'
        self.master = Master(master_uri, self.name)
        self.topics = tuple(topics)
        self.problem: Ros1Error | None = None
        self._on_message = on_message
        self._log = log
        self._lock = threading.Lock()
        self._connections: dict[tuple[str, str], Connection] = {}
        self._sources: dict[tuple[str, str], Source] = {}
        self._reconnections = self._malformed = 0  # of connections that were given up
        self._substituted: dict[str, str] = {}  # host -> the master's address
        self._seen: dict[str, tuple[str, ...]] = {}  # topic -> names of its publishers
        self._registered: dict[str, float] = {}  # topic -> when, monotonic time [s]
        self._api = ''
        self._asked = float('inf')  # when the master was made to call, monotonic time [s]
        self._callbacks = CallbackServer(self._on_update)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name='ros1 master')

    def start(self) -> None:
        """Begin to subscribe."""
        self._thread.start()

    def stop(self) -> None:
        """End all connections and unregister; a second call does nothing."""
        if self._ended.is_set():
            return
        self._ended.set()
        with self._lock:
            for connection in self._connections.values():
                connection.stop()
            self._connections.clear()
        if self._thread.is_alive():
            self._thread.join(5.0)
        try:
            for topic in list(self._registered):
                self.master.unregister(topic, self._api)
        except Ros1Error:
            pass  # there is no master that would remember
        self._callbacks.close()

    def connections(self, topic: str) -> list[Connection]:
        """Return the connections to a topic's publishers."""
        with self._lock:
            return [each for (of, _), each in self._connections.items() if of == topic]

    def sources(self, topic: str) -> list[Source]:
        """Return what is known of each publisher that has ever sent on a topic."""
        with self._lock:
            return [source for (of, _), source in self._sources.items() if of == topic]

    def problems(self, topic: str) -> list[Ros1Error]:
        """Return what stands between a topic and its messages, the most important first."""
        if self.problem is not None:
            return [self.problem]
        connections = self.connections(topic)
        if topic in self._registered and not connections:
            return [Ros1Error(Step.TOPIC, f'{topic} is not published',
                              'has the robot finished starting? Check the name of the topic')]
        found = [each.problem for each in connections if each.problem is not None]
        if self.is_called is False:
            found.append(Ros1Error(
                Step.ADDRESS, f'the master does not reach this machine at {self._api}',
                "set ROS_IP to this machine's address in the robot's network, and open its "
                'firewall; new publishers are found later without'))
        if any(each.connected and time.monotonic() - each.since > SILENCE
               for each in connections) and self.silent_for(topic) > SILENCE:
            found.append(Ros1Error(
                Step.STREAM, f'nothing has arrived on {topic} for {SILENCE:g} s',
                'is the publisher stopped, or the network down?'))
        return found

    def silent_for(self, topic: str) -> float:
        """Return the time since the last message of a topic [s]; infinite if there was none."""
        latest = max((source.arrival_ns for source in self.sources(topic)), default=0)
        return (time.time_ns() - latest) * 1e-9 if latest else float('inf')

    @property
    def malformed(self) -> int:
        """Return the number of malformed headers and messages."""
        with self._lock:
            return self._malformed + sum(each.malformed for each in self._connections.values())

    @property
    def reconnections(self) -> int:
        """Return the number of connections beyond the first to each publisher."""
        with self._lock:
            return self._reconnections + sum(
                max(each.connections - 1, 0) for each in self._connections.values())

    @property
    def is_called(self) -> bool | None:
        """Whether calls of the master reach this machine; None while that is not known."""
        if self._callbacks.called.is_set():
            return True
        return False if time.monotonic() - self._asked > SILENCE else None

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                self._look()
                self.problem = None
            except Ros1Error as error:
                self.problem = error
            self._ended.wait(PERIOD)

    def _look(self) -> None:
        """Register where the master does not know this node, or publishers have changed."""
        api = f'http://{self.master.locate()}:{self._callbacks.port}/'
        moved, self._api = api != self._api, api
        state = self.master.system_state()
        for topic in self.topics:
            names = state.publishers.get(topic, ())
            connected = sum(each.connected for each in self.connections(topic))
            overdue = (connected < len(names)
                       and time.monotonic() - self._registered.get(topic, 0.0) > PATIENCE)
            known = not moved and self.name in state.subscribers.get(topic, ())
            if overdue or not known or names != self._seen.get(topic):
                if self._ended.is_set():
                    return
                self._registered[topic] = time.monotonic()
                if not known and topic == self.topics[0]:
                    self._ask_for_call(topic)
                self._set(topic, self.master.register(topic, api))
                self._seen[topic] = names

    def _ask_for_call(self, topic: str) -> None:
        """
        Register under another spelling of this node's address, just before the right one.

        A master then tells the first address that it is no longer used: so a call that does not
        come shows that this machine cannot be reached, before a publisher changes.
        """
        self._callbacks.called.clear()
        self._asked = time.monotonic()
        self.master.register(topic, self._api + 'RPC2')

    def _on_update(self, topic: str, uris: tuple[str, ...]) -> None:
        """Take the publishers of a topic, as the master's call gives them."""
        if topic in self.topics:
            self._set(topic, uris)

    def _set(self, topic: str, uris: tuple[str, ...]) -> None:
        """Connect to these publishers and to no others."""
        wanted = {(topic, uri) for uri in uris[:MAX_PUBLISHERS]}
        with self._lock:
            if self._ended.is_set():
                return
            for key in [key for key in self._connections if key[0] == topic and key not in wanted]:
                connection = self._connections.pop(key)
                connection.stop()
                self._malformed += connection.malformed
                self._reconnections += max(connection.connections - 1, 0)
            for key in wanted - self._connections.keys():
                self._connections[key] = Connection(*key, self.name, self._address, self._deliver)

    def _address(self, host: str) -> str:
        """Return the address of a publisher's host: the master's where the name is of no use."""
        master = self.master.address
        if self._substituted.get(host.lower()) == master:
            return master
        try:
            address = resolve(host)
            if not is_loopback(address) or is_loopback(master):
                return address
            reason = f'is {address}, which is this machine'
        except Ros1Error:
            reason = 'does not resolve'
        self._substituted[host.lower()] = master
        self._log(f'{host} {reason}: using the address of the master, {master}, for it')
        return master

    def _deliver(self, connection: Connection, state: JointState, arrival_ns: int) -> None:
        key = connection.topic, connection.publisher
        with self._lock:
            source = self._sources.get(key)
            if source is None:
                source = self._sources[key] = Source(connection.publisher)
        if source.take(connection.uri, state, arrival_ns):
            self._on_message(connection.topic, source, state, arrival_ns)
