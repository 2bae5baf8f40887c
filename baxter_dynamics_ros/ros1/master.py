"""Read-only client of a ROS 1 master."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from .errors import Stage
from .network import connect, Endpoint, endpoint, local_address, resolve
from .rpc import call, texts

_Value = TypeVar('_Value')


class SystemState(NamedTuple):
    """Names of the publishers and subscribers of each topic."""

    publishers: dict[str, tuple[str, ...]]
    subscribers: dict[str, tuple[str, ...]]


class Master:
    """
    Read-only client of a ROS 1 master; its methods raise Ros1Error.

    Parameters
    ----------
    uri : str
        URI of the master, such as ``http://011303P0017.local:11311``.
    caller_id : str
        Name of this node.

    """

    def __init__(self, uri: str, caller_id: str) -> None:
        self.endpoint = endpoint(uri)
        self.address = ''  # empty before the first locate()
        self._caller_id = caller_id

    def locate(self) -> str:
        """Find and test the master's address; return this machine's address on that route."""
        address = resolve(self.endpoint.host)
        connect(address, self.endpoint.port).close()
        self.address = address
        return local_address(address)

    def system_state(self) -> SystemState:
        """Return the publishers and subscribers of all topics."""
        return self._call(lambda value: SystemState(*(
            {str(topic): texts(nodes) for topic, nodes in value[side]} for side in (0, 1))),
            'getSystemState')

    def topic_types(self) -> dict[str, str]:
        """Return the type of each topic known to the master."""
        return self._call(lambda value: {pair[0]: pair[1] for pair in map(texts, value)},
                          'getTopicTypes')

    def register(self, topic: str, caller_api: str) -> tuple[str, ...]:
        """
        Register a subscription and return the URIs of the topic's publishers.

        The type is ``*``: the master then stores no type for a topic without publishers.
        """
        return self._call(texts, 'registerSubscriber', topic, '*', caller_api)

    def unregister(self, topic: str, caller_api: str) -> None:
        """Unregister a subscription."""
        self._call(lambda value: None, 'unregisterSubscriber', topic, caller_api)

    def _call(self, parse: Callable[[Any], _Value], method: str, *arguments: str) -> _Value:
        server = Endpoint(self.address or resolve(self.endpoint.host), self.endpoint.port)
        return call(server, Stage.MASTER, parse, method, self._caller_id, *arguments)
