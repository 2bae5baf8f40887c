"""Name resolution and TCP connections, with timeouts and descriptive errors."""

from collections.abc import Mapping
import os
import socket
from typing import NamedTuple
from urllib.parse import urlsplit

from .errors import Ros1Error, Stage

TIMEOUT = 2.0  # [s], of connections and answers
MASTER_PORT = 11311


class Endpoint(NamedTuple):
    """Host and port of an XML-RPC server."""

    host: str
    port: int

    @property
    def uri(self) -> str:
        """URI of the server."""
        return f'http://{self.host}:{self.port}/'


def endpoint(uri: str, default_port: int = MASTER_PORT) -> Endpoint:
    """Return the host and port of a URI such as ``http://host:11311/``, or raise Ros1Error."""
    try:
        parts = urlsplit(uri)
        if parts.scheme == 'http' and parts.hostname:
            host = parts.netloc.rpartition('@')[2].partition(':')[0]  # hostname is in lower case
            return Endpoint(host, parts.port or default_port)
    except ValueError:
        pass
    raise Ros1Error(Stage.NAME, f'{uri!r} is not the URI of a ROS 1 master or node',
                    f'expected http://HOST:{default_port}')


def resolve(host: str) -> str:
    """Return the IPv4 address of a host; raise Ros1Error if the name does not resolve."""
    try:
        return str(socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_STREAM)[0][4][0])
    except (OSError, UnicodeError):  # UnicodeError: a label of more than 63 characters
        raise Ros1Error(
            Stage.NAME, f'{host} does not resolve to an address',
            "use the robot's IP address, add the name to /etc/hosts, or, for a name in .local, "
            'install avahi-daemon and libnss-mdns') from None


def connect(address: str, port: int) -> socket.socket:
    """Return a TCP connection with a timeout of TIMEOUT, or raise Ros1Error."""
    try:
        return socket.create_connection((address, port), TIMEOUT)
    except (OSError, OverflowError) as error:  # OverflowError: the port has more than 16 bits
        raise connection_error(address, port, error) from None


def connection_error(address: str, port: int, error: Exception) -> Ros1Error:
    """Return a Ros1Error with the cause of a failed connection."""
    if isinstance(error, ConnectionRefusedError):
        return Ros1Error(Stage.PORT, f'port {port} of {address} is closed',
                         'is ROS running there? A robot takes two minutes to start; the port of '
                         "Baxter's master is 11311")
    reason = getattr(error, 'strerror', None) or str(error) or type(error).__name__
    return Ros1Error(Stage.ROUTE, f'{address} port {port} cannot be reached ({reason})',
                     'check cable, power and firewall, and that this machine has an address in '
                     "the robot's network")


def local_address(address: str, environment: Mapping[str, str] = os.environ) -> str:
    """Return the host under which others reach this machine: ROS_HOSTNAME, ROS_IP or by route."""
    given = environment.get('ROS_HOSTNAME') or environment.get('ROS_IP')
    if given:
        return given
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((address, MASTER_PORT))  # sends nothing, only selects the route
        except OSError as error:
            raise connection_error(address, MASTER_PORT, error) from None
        return str(probe.getsockname()[0])


def keep_alive(connection: socket.socket) -> None:
    """Make the kernel close the connection 4 s after the peer or the network has gone."""
    connection.settimeout(None)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in ((socket.TCP_KEEPIDLE, 1), (socket.TCP_KEEPINTVL, 1),
                          (socket.TCP_KEEPCNT, 3)):
        connection.setsockopt(socket.IPPROTO_TCP, option, value)
