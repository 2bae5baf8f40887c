"""Subscriber to topics of a ROS 1 robot, connected to every publisher of each topic."""

from collections.abc import Callable, Iterable
import os
import random
import threading
import time

from .callbacks import CallbackServer
from .connection import Connection
from .errors import Ros1Error, Stage
from .joint_state import JointState
from .master import Master
from .network import resolve
from .source import Source

PERIOD = 1.0  # [s], between polls of the master
PATIENCE = 5.0  # [s], between registrations while a publisher cannot be reached
SILENCE = 2.0  # [s] without a message before the topic is reported as silent
MAX_PUBLISHERS = 64  # per topic

OnMessage = Callable[[str, Source, JointState, int], None]


class Subscriber:
    """
    Subscriber to topics of ``sensor_msgs/JointState``.

    A thread polls the master once a second. It registers again when the master has restarted, and
    when the publishers of a topic have changed. Between polls, the master calls back.

    Parameters
    ----------
    master_uri : str
        URI of the master, such as ``http://011303P0017.local:11311``.
    topics : iterable of str
        Names of the topics.
    on_message : callable
        Called with topic, :class:`Source`, :class:`JointState` and time of arrival [ns], from
        one thread per publisher.
    log : callable
        Called with each log line.
    name : str
        Prefix of this node's name; the rest makes it unique on the master.

    Raises
    ------
    Ros1Error
        If the URI is malformed.

    """

    def __init__(self, master_uri: str, topics: Iterable[str], on_message: OnMessage,
                 log: Callable[[str], None], name: str = '/joint_state_bridge') -> None:
        self.name = f'{name}_{os.getpid()}_{random.randrange(16 ** 6):06x}'
        self.master = Master(master_uri, self.name)
        self.topics = tuple(topics)
        self.problem: Ros1Error | None = None  # failure of the last poll of the master
        self._on_message = on_message
        self._log = log
        self._lock = threading.Lock()
        self._connections: dict[tuple[str, str], Connection] = {}
        self._sources: dict[tuple[str, str], Source] = {}
        self._reconnections = self._malformed = 0  # of closed connections
        self._substituted: dict[str, str] = {}  # hosts replaced by the master's address
        self._publishers: dict[str, tuple[str, ...]] = {}  # topic -> names at the registration
        self._registered: dict[str, float] = {}  # topic -> monotonic time [s]
        self._api = ''  # URI of this node's callback server
        self._probed = float('inf')  # monotonic time of the reachability probe [s]
        self._callbacks = CallbackServer(self._on_update)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name='ros1 master')

    def start(self) -> None:
        """Start polling the master."""
        self._thread.start()

    def stop(self) -> None:
        """Close all connections and unregister; further calls do nothing."""
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
            pass  # the master is gone, and the registration with it
        self._callbacks.close()

    def connections(self, topic: str) -> list[Connection]:
        """Return the connections to a topic's publishers."""
        with self._lock:
            return [each for (of, _), each in self._connections.items() if of == topic]

    def sources(self, topic: str) -> list[Source]:
        """Return the statistics of every publisher that has sent on a topic."""
        with self._lock:
            return [each for (of, _), each in self._sources.items() if of == topic]

    def problems(self, topic: str) -> list[Ros1Error]:
        """Return the reasons why messages of a topic do not arrive, most important first."""
        if self.problem is not None:
            return [self.problem]
        connections = self.connections(topic)
        if topic in self._registered and not connections:
            return [Ros1Error(Stage.TOPIC, f'{topic} is not published',
                              'has the robot finished starting? Check the name of the topic')]
        found = [each.problem for each in connections if each.problem is not None]
        if self.is_called is False:
            found.append(Ros1Error(
                Stage.ADDRESS, f'the master does not reach this machine at {self._api}',
                "set ROS_IP to this machine's address in the robot's network, and open its "
                'firewall; until then, new publishers are found later'))
        if any(each.connected and time.monotonic() - each.since > SILENCE
               for each in connections) and self.silent_for(topic) > SILENCE:
            found.append(Ros1Error(
                Stage.STREAM, f'nothing has arrived on {topic} for {SILENCE:g} s',
                'is the publisher stopped, or the network down?'))
        return found

    def silent_for(self, topic: str) -> float:
        """Return the time since the last message of a topic [s], infinite before the first."""
        latest = max((source.arrival_ns for source in self.sources(topic)), default=0)
        return (time.time_ns() - latest) * 1e-9 if latest else float('inf')

    @property
    def malformed(self) -> int:
        """Return the number of malformed headers and messages."""
        with self._lock:
            return self._malformed + sum(each.malformed for each in self._connections.values())

    @property
    def reconnections(self) -> int:
        """Return the number of connections after the first to each publisher."""
        with self._lock:
            return self._reconnections + sum(
                max(each.connections - 1, 0) for each in self._connections.values())

    @property
    def is_called(self) -> bool | None:
        """Return whether the master can call this node back; None until the probe has ended."""
        if self._callbacks.called.is_set():
            return True
        return False if time.monotonic() - self._probed > SILENCE else None

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                self._poll()
                self.problem = None
            except Ros1Error as error:
                self.problem = error
            self._ended.wait(PERIOD)

    def _poll(self) -> None:
        """Register topics that the master has forgotten, and whose publishers have changed."""
        api = f'http://{self.master.locate()}:{self._callbacks.port}/'
        moved, self._api = api != self._api, api
        state = self.master.system_state()
        for topic in self.topics:
            names = state.publishers.get(topic, ())
            connected = sum(each.connected for each in self.connections(topic))
            overdue = (connected < len(names)
                       and time.monotonic() - self._registered.get(topic, 0.0) > PATIENCE)
            known = not moved and self.name in state.subscribers.get(topic, ())
            if overdue or not known or names != self._publishers.get(topic):
                if self._ended.is_set():
                    return
                self._registered[topic] = time.monotonic()
                if not known and topic == self.topics[0]:
                    self._probe_callback(topic)
                self._connect(topic, self.master.register(topic, api))
                self._publishers[topic] = names

    def _probe_callback(self, topic: str) -> None:
        """
        Make the master call this node, to find out whether it can.

        This registers a second spelling of the callback URI. When the right one is registered
        next, a master calls ``shutdown`` on the first, because one name belongs to one node.
        """
        self._callbacks.called.clear()
        self._probed = time.monotonic()
        self.master.register(topic, self._api + 'RPC2')

    def _on_update(self, topic: str, uris: tuple[str, ...]) -> None:
        """Connect to the publishers that the master announces."""
        if topic in self.topics:
            self._connect(topic, uris)

    def _connect(self, topic: str, uris: tuple[str, ...]) -> None:
        """Connect to exactly these publishers of a topic."""
        wanted = {(topic, uri) for uri in uris[:MAX_PUBLISHERS]}
        with self._lock:
            if self._ended.is_set():
                return
            present = {key for key in self._connections if key[0] == topic}
            for key in present - wanted:
                connection = self._connections.pop(key)
                connection.stop()
                self._malformed += connection.malformed
                self._reconnections += max(connection.connections - 1, 0)
            for key in wanted - present:
                self._connections[key] = Connection(*key, self.name, self._address, self._deliver)

    def _address(self, host: str) -> str:
        """Return the address of a host, or the master's where the name leads nowhere."""
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

    def _deliver(self, connection: Connection, state: JointState, arrival_ns: int) -> None:
        key = connection.topic, connection.publisher
        with self._lock:
            source = self._sources.get(key)
            if source is None:
                source = self._sources[key] = Source(connection.publisher)
        if source.take(connection.uri, state, arrival_ns):
            self._on_message(connection.topic, source, state, arrival_ns)
