"""A ROS 1 master, looked at and subscribed with."""

from typing import Any, NamedTuple

from .errors import Malformed, Step
from .network import connect, Endpoint, endpoint, local_address, resolve
from .rpc import call, not_ros, texts


class SystemState(NamedTuple):
    """Names of the nodes that publish and subscribe each topic."""

    publishers: dict[str, tuple[str, ...]]
    subscribers: dict[str, tuple[str, ...]]


class Master:
    """
    Read-only client of a ROS 1 master.

    Parameters
    ----------
    uri : str
        Such as ``http://011303P0017.local:11311``.
    caller_id : str
        Name of this node.

    Attributes
    ----------
    endpoint : Endpoint
        Host and port of the URI.
    address : str
        Address at which the master was reached last; empty before :meth:`locate`.

    """

    def __init__(self, uri: str, caller_id: str) -> None:
        self.endpoint = endpoint(uri)
        self.address = ''
        self._caller_id = caller_id

    def locate(self) -> str:
        """
        Resolve the host, connect once, and return the address of this machine on that route.

        Raises
        ------
        Ros1Error
            If the name, the route or the port fails.

        """
        address = resolve(self.endpoint.host)
        connect(address, self.endpoint.port).close()
        self.address = address
        return local_address(address)

    def system_state(self) -> SystemState:
        """Return the publishers and subscribers of all topics, by the nodes' names."""
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

        The type is given as ``*``: the master then keeps nothing of a topic nobody publishes.
        """
        value = self._call('registerSubscriber', topic, '*', caller_api)
        try:
            return texts(value)
        except Malformed as error:
            raise not_ros(self.endpoint, Step.MASTER, error) from None

    def unregister(self, topic: str, caller_api: str) -> None:
        """Take back a subscription."""
        self._call('unregisterSubscriber', topic, caller_api)

    def _call(self, method: str, *arguments: str) -> Any:
        server = Endpoint(self.address or resolve(self.endpoint.host), self.endpoint.port)
        return call(server, Step.MASTER, method, self._caller_id, *arguments)
