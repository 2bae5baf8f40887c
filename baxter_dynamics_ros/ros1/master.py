"""Client of a ROS 1 master that reads and subscribes."""

from typing import Any, NamedTuple

from .errors import Malformed, Step
from .network import connect, Endpoint, endpoint, local_address, resolve
from .rpc import call, not_ros, texts


class SystemState(NamedTuple):
    """Names of the publishers and subscribers of each topic."""

    publishers: dict[str, tuple[str, ...]]
    subscribers: dict[str, tuple[str, ...]]


class Master:
    """
    Read-only client of a ROS 1 master.

    Parameters
    ----------
    uri : str
        URI of the master, such as ``http://011303P0017.local:11311``.
    caller_id : str
        Name of this node.

    Attributes
    ----------
    endpoint : Endpoint
        Host and port of the URI.
    address : str
        Address of the master; empty before the first :meth:`locate`.

    """

    def __init__(self, uri: str, caller_id: str) -> None:
        self.endpoint = endpoint(uri)
        self.address = ''
        self._caller_id = caller_id

    def locate(self) -> str:
        """
        Resolve and test the master's address; return this machine's address on that route.

        Raises
        ------
        Ros1Error
            If the name does not resolve or the port cannot be reached.

        """
        address = resolve(self.endpoint.host)
        connect(address, self.endpoint.port).close()
        self.address = address
        return local_address(address)

    def system_state(self) -> SystemState:
        """Return the publishers and subscribers of all topics."""
        value = self._call('getSystemState')
        try:
            publishers, subscribers = value[:2]
            return SystemState(*({str(topic): texts(nodes) for topic, nodes in side}
                                 for side in (publishers, subscribers)))
        except (Malformed, TypeError, ValueError) as error:
            raise not_ros(self.endpoint, Step.MASTER, error) from None

    def topic_types(self) -> dict[str, str]:
        """Return the type of each topic known to the master."""
        value = self._call('getTopicTypes')
        try:
            return {pair[0]: pair[1] for pair in map(texts, value)}
        except (Malformed, TypeError, LookupError) as error:
            raise not_ros(self.endpoint, Step.MASTER, error) from None

    def register(self, topic: str, caller_api: str) -> tuple[str, ...]:
        """
        Register a subscription and return the URIs of the topic's publishers.

        The type is ``*``: the master then stores no type for a topic without publishers.
        """
        value = self._call('registerSubscriber', topic, '*', caller_api)
        try:
            return texts(value)
        except Malformed as error:
            raise not_ros(self.endpoint, Step.MASTER, error) from None

    def unregister(self, topic: str, caller_api: str) -> None:
        """Unregister a subscription."""
        self._call('unregisterSubscriber', topic, caller_api)

    def _call(self, method: str, *arguments: str) -> Any:
        server = Endpoint(self.address or resolve(self.endpoint.host), self.endpoint.port)
        return call(server, Step.MASTER, method, self._caller_id, *arguments)
