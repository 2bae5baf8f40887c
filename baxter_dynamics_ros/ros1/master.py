"""Read-only XML-RPC client of a ROS 1 master and its nodes, with bounded answers."""

from collections.abc import Callable
from contextlib import closing
from http.client import HTTPConnection
import os
import re
import socket
from typing import Any, TypeVar
import xmlrpc.client

from .wire import connect, connection_error, Ros1Error, TIMEOUT

MASTER_PORT = 11311
# The only requests this package can send: it cannot publish, call a service or set a parameter.
METHODS = frozenset({'getSystemState', 'getTopicTypes', 'lookupNode', 'registerSubscriber',
                     'unregisterSubscriber', 'requestTopic'})
MAX_ANSWER = 4 * 1024 * 1024  # [bytes]; a Baxter's system state has about 0.1 MB

_Value = TypeVar('_Value')


class Master:
    """Read-only client of the ROS 1 master at a URI; its methods raise Ros1Error."""

    def __init__(self, uri: str, caller_id: str) -> None:
        self.host, self.port = endpoint(uri)
        self.address = ''  # empty before the first locate()
        self._caller_id = caller_id

    def locate(self) -> str:
        """Find the master's address; return the host under which it reaches this machine."""
        address = resolve(self.host)
        with connect(address, self.port) as connection:
            local = str(connection.getsockname()[0])
        self.address = address
        return os.environ.get('ROS_HOSTNAME') or os.environ.get('ROS_IP') or local

    def system_state(self) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
        """Return the names of the publishers and of the subscribers of each topic."""
        def names(side: Any) -> dict[str, list[str]]:
            return {str(topic): list(map(str, nodes)) for topic, nodes in side}
        return self.ask('getSystemState', parse=lambda value: (names(value[0]), names(value[1])))

    def ask(self, method: str, *arguments: str, parse: Callable[[Any], _Value]) -> _Value:
        """Call a method of the master and return its parsed value."""
        return call(self.address or resolve(self.host), self.port, 'master', parse, method,
                    self._caller_id, *arguments)


def endpoint(uri: str) -> tuple[str, int]:
    """Return the host and port of a URI such as ``http://host:11311/``, or raise Ros1Error."""
    found = re.fullmatch(r'http://([^:/]+)(?::(\d{1,5}))?(?:/.*)?', uri)
    if found is None:
        raise Ros1Error('name', f'{uri!r} is not the URI of a ROS 1 master or node',
                        f'expected http://HOST:{MASTER_PORT}')
    return found[1], int(found[2] or MASTER_PORT)


def resolve(host: str) -> str:
    """Return the IPv4 address of a host; raise Ros1Error if the name does not resolve."""
    try:
        return str(socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_STREAM)[0][4][0])
    except (OSError, ValueError):  # ValueError: a label of more than 63 characters
        raise Ros1Error(
            'name', f'{host} does not resolve to an address',
            "use the robot's IP address, add the name to /etc/hosts, or, for a name in .local, "
            'install avahi-daemon and libnss-mdns') from None


def call(address: str, port: int, stage: str, parse: Callable[[Any], _Value], method: str,
         *arguments: Any) -> _Value:
    """Call a method of a ROS 1 master or node and return its parsed value, or raise Ros1Error."""
    if method not in METHODS:
        raise ValueError(f'{method}: this client is read-only')
    try:
        code, message, value = _exchange(
            address, port, xmlrpc.client.dumps(arguments, method).encode())
        if code == 1:
            return parse(value)
    except OSError as error:
        raise connection_error(address, port, error) from None
    except Exception as error:  # arbitrary answers make xmlrpc and parse raise of all kinds
        kind = 'master' if stage == 'master' else 'node'
        reason = f'{type(error).__name__}: {" ".join(str(error).split())[:100]}'.rstrip(': ')
        raise Ros1Error(stage, f'http://{address}:{port}/ is not a ROS 1 {kind} ({reason})',
                        "check host and port; the port of Baxter's master is 11311") from None
    raise Ros1Error(stage, f'{method} on http://{address}:{port}/ failed ({str(message)[:200]})',
                    "look at the robot's log")


def _exchange(address: str, port: int, request: bytes) -> Any:
    """Send a request; return the code, the message and the value in its answer."""
    with closing(HTTPConnection(address, port, timeout=TIMEOUT)) as connection:
        connection.request('POST', '/', request, {'Content-Type': 'text/xml'})
        data = connection.getresponse().read(MAX_ANSWER + 1)
    if len(data) > MAX_ANSWER:
        raise ValueError(f'an answer of more than {MAX_ANSWER} bytes')
    return xmlrpc.client.loads(data)[0][0]
