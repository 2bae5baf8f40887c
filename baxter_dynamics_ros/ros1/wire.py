"""ROS 1 on the wire: calls of a master and its nodes, TCPROS streams, joint states, failures."""

from array import array
from collections.abc import Callable
from contextlib import closing, suppress
from http.client import HTTPConnection
import os
import re
import socket
import struct
from typing import Any, NamedTuple, TypeVar
import xmlrpc.client

TYPE = 'sensor_msgs/JointState'
MD5SUM = '3066dcd76a6cfaef579bd0f34173e9fd'
MASTER_PORT = 11311
# The only requests this package can send: it cannot publish, call a service or set a parameter.
METHODS = frozenset({'getSystemState', 'getTopicTypes', 'lookupNode', 'registerSubscriber',
                     'unregisterSubscriber', 'requestTopic'})

TIMEOUT = 2.0  # of connections and answers [s]
MAX_ANSWER = 4 * 1024 * 1024  # [bytes]; a Baxter's system state has about 0.1 MB
MAX_MESSAGE = 1024 * 1024  # of headers, too [bytes]; a joint state of Baxter has 0.7 kB

_REMEDIES = {'master': "check host and port: the port of Baxter's master is 11311, and a robot "
                       'takes two minutes to start',
             'publisher': 'if the publisher was killed, rosnode cleanup on the robot removes its '
                          'registration'}

_Value = TypeVar('_Value')


class Ros1Error(Exception):
    """
    Failure at one stage of the connection to a robot, with cause and remedy.

    The stages are name, route, port, master, topic, publisher, type, address and stream.
    """

    def __init__(self, stage: str, cause: str, remedy: str) -> None:
        super().__init__(f'{stage}: {cause}: {remedy}')
        self.stage = stage
        self.cause = cause
        self.remedy = remedy


class Malformed(Exception):
    """Data that violate the protocol."""


class JointState(NamedTuple):
    """A ROS 1 joint state."""

    seq: int  # sequence number of the publisher
    stamp_ns: int  # [ns]
    frame_id: str
    name: list[str]
    position: 'array[float]'
    velocity: 'array[float]'
    effort: 'array[float]'


class Master:
    """Read-only client of the ROS 1 master at a URI; its methods raise Ros1Error."""

    def __init__(self, uri: str, caller_id: str) -> None:
        self.host, self.port = endpoint(uri)
        self.address = ''  # empty before the first locate()
        self._caller_id = caller_id

    def locate(self) -> str:
        """Find the master's address; return the host under which it reaches this machine."""
        address = resolve(self.host)
        with connect(address, self.port, 'master') as connection:
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
    request = xmlrpc.client.dumps(arguments, method).encode()
    uri = f'http://{address}:{port}/'
    with closing(HTTPConnection(address, port)) as connection:
        connection.sock = connect(address, port, stage)
        try:
            code, message, value = _exchange(connection, request)
            if code == 1:
                return parse(value)
        except OSError as error:
            raise Ros1Error('port', f'{uri} does not answer ({error})', f'is it a ROS 1 {stage}, '
                            'and neither stopped nor overloaded?') from None
        except Exception as error:  # arbitrary answers make xmlrpc and parse raise anything
            reason = f'{type(error).__name__}: {" ".join(str(error).split())[:100]}'.rstrip(': ')
            raise Ros1Error(stage, f'{uri} is not a ROS 1 {stage} ({reason})',
                            _REMEDIES[stage]) from None
    raise Ros1Error(stage, f'{method} on {uri} failed ({str(message)[:200]})',
                    "look at the robot's log")


def _exchange(connection: HTTPConnection, request: bytes) -> Any:
    """Send a request; return the code, the message and the value in its answer."""
    connection.request('POST', '/', request, {'Content-Type': 'text/xml'})
    data = connection.getresponse().read(MAX_ANSWER + 1)
    if len(data) > MAX_ANSWER:
        raise ValueError(f'an answer of more than {MAX_ANSWER} bytes')
    return xmlrpc.client.loads(data)[0][0]


class MessageStream:
    """TCPROS stream of one publisher's messages."""

    def __init__(self, address: str, port: int) -> None:
        self._socket = connect(address, port, 'publisher')
        # Buffered: one system call receives all waiting messages.
        self._file = self._socket.makefile('rb', 8192)

    def subscribe(self, topic: str, caller_id: str) -> str:
        """Exchange headers; return the publisher's name, or raise Ros1Error if it refuses."""
        # Ask for any type, so that the answer names the publisher's.
        self._socket.sendall(encode_header({'callerid': caller_id, 'topic': topic, 'type': '*',
                                            'md5sum': '*', 'tcp_nodelay': '1'}))
        header = decode_header(self.read())
        if 'error' in header:
            raise Ros1Error(
                'publisher', f'the publisher refuses {topic} ({header["error"][:200]})',
                "look at the publisher's log")
        kind, md5sum = (header.get(key, '')[:100] or 'nothing' for key in ('type', 'md5sum'))
        if (kind, md5sum) != (TYPE, MD5SUM):
            raise Ros1Error('type', f'{topic} has the type {kind} with the checksum {md5sum}',
                            f'choose a topic of {TYPE} with the checksum of ROS 1, {MD5SUM}')
        # From now on a read may wait, but only 4 s once the peer or the network has gone.
        self._socket.settimeout(None)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for option, value in ((socket.TCP_KEEPIDLE, 1), (socket.TCP_KEEPINTVL, 1),
                              (socket.TCP_KEEPCNT, 3)):
            self._socket.setsockopt(socket.IPPROTO_TCP, option, value)
        return header.get('callerid', '')

    def close(self) -> None:
        """Close the connection."""
        self._file.close()
        self._socket.close()

    def interrupt(self) -> None:
        """Make a blocking read in another thread return."""
        with suppress(OSError):  # closed already
            self._socket.shutdown(socket.SHUT_RDWR)

    def read(self) -> bytes:
        """Return the next message; raise OSError if the connection has ended."""
        length = int.from_bytes(self._exactly(4), 'little')
        if length > MAX_MESSAGE:
            raise Malformed(f'length of {length} bytes exceeds {MAX_MESSAGE}')
        return self._exactly(length)

    def _exactly(self, count: int) -> bytes:
        data = self._file.read(count)
        if len(data) < count:
            raise ConnectionError('closed by the publisher')
        return data


def connect(address: str, port: int, stage: str) -> socket.socket:
    """Return a TCP connection with a timeout of TIMEOUT, or raise Ros1Error."""
    try:
        return socket.create_connection((address, port), TIMEOUT)
    except ConnectionRefusedError:
        raise Ros1Error('port', f'port {port} of {address} is closed', _REMEDIES[stage]) from None
    except (OSError, OverflowError) as error:  # OverflowError: the port has more than 16 bits
        reason = getattr(error, 'strerror', None) or str(error)
        raise Ros1Error('route', f'{address} port {port} cannot be reached ({reason})',
                        'check cable, power and firewall, and that this machine has an address '
                        "in the robot's network") from None


def parse(data: bytes) -> JointState:
    """Return the joint state in a message; raise Malformed if it is not exactly one."""
    try:
        seq, seconds, nanoseconds = struct.unpack_from('<3I', data)
        frame_id, at = _block(data, 12, 1)
        count, = struct.unpack_from('<I', data, at)
        at += 4
        names = []
        for _ in range(count):
            name, at = _block(data, at, 1)
            names.append(name.decode())
        fields = []
        for _ in range(3):
            field, at = _block(data, at, 8)
            fields.append(array('d', field))  # little-endian, as on all machines of ROS 2
        if at != len(data):
            raise Malformed(f'not a joint state: {len(data) - at} bytes too many')
        return JointState(seq, seconds * 1_000_000_000 + nanoseconds, frame_id.decode(), names,
                          *fields)
    except (struct.error, UnicodeDecodeError) as error:
        raise Malformed(f'not a joint state: {error}') from None


def encode_header(fields: dict[str, str]) -> bytes:
    """Return a connection header, preceded by its length."""
    parts = [f'{key}={value}'.encode() for key, value in fields.items()]
    body = b''.join(struct.pack('<I', len(part)) + part for part in parts)
    return struct.pack('<I', len(body)) + body


def decode_header(body: bytes) -> dict[str, str]:
    """Return the fields of a connection header; raise Malformed if a field is malformed."""
    fields, at = {}, 0
    while at < len(body):
        field, at = _block(body, at, 1)
        key, separator, value = field.decode(errors='replace').partition('=')
        if not separator:
            raise Malformed('header field without "="')
        fields[key] = value
    return fields


def _block(data: bytes, at: int, size: int) -> tuple[bytes, int]:
    """Return the items of ``size`` bytes after their number at an offset, and the end."""
    begin = at + 4
    end = begin + size * int.from_bytes(data[at:begin], 'little')
    if end > len(data):
        raise Malformed(f'a field of {end - begin} bytes in {len(data)} bytes')
    return data[begin:end], end
