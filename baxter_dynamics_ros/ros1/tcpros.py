"""TCPROS client: the messages of one publisher over TCP."""

from contextlib import suppress
import socket
import struct

from . import joint_state
from .errors import Malformed, Ros1Error, Stage
from .network import connect, keep_alive

MAX_HEADER = 64 * 1024  # [bytes]
MAX_MESSAGE = 1024 * 1024  # [bytes]; a joint state of Baxter has 0.7 kB


class Stream:
    """
    TCP stream of serialised messages.

    Parameters
    ----------
    address : str
        Address of the publisher's host.
    port : int
        Port in the publisher's answer to ``requestTopic``.
    topic, caller_id : str
        Topic and name of this node.

    Raises
    ------
    Ros1Error
        If the connection fails, or the publisher refuses or has another type.
    Malformed
        If the publisher's header is malformed.

    """

    def __init__(self, address: str, port: int, topic: str, caller_id: str) -> None:
        self._socket = connect(address, port)
        # Buffered: one system call receives all waiting messages.
        self._file = self._socket.makefile('rb', 8192)
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            # Any type, so that the answer names the type of the publisher.
            self._socket.sendall(encode_header({
                'callerid': caller_id, 'topic': topic, 'type': '*', 'md5sum': '*',
                'tcp_nodelay': '1'}))
            header = decode_header(self.read(MAX_HEADER))
            _check(topic, header)
            keep_alive(self._socket)
        except BaseException:
            self.close()
            raise
        self.publisher = header.get('callerid', '')  # its name

    def close(self) -> None:
        """Close the connection."""
        self._file.close()
        self._socket.close()

    def interrupt(self) -> None:
        """Make a blocking read in another thread return."""
        with suppress(OSError):  # closed already
            self._socket.shutdown(socket.SHUT_RDWR)

    def read(self, longest: int = MAX_MESSAGE) -> bytes:
        """
        Return the next message.

        Raises
        ------
        EOFError, OSError
            If the connection has ended.
        Malformed
            If the message has more than ``longest`` bytes.

        """
        length, = struct.unpack('<I', self._exactly(4))
        if length > longest:
            raise Malformed(f'length of {length} bytes exceeds {longest}')
        return self._exactly(length)

    def _exactly(self, count: int) -> bytes:
        data = self._file.read(count)
        if len(data) < count:
            raise EOFError('the publisher closed the connection')
        return data


def encode_header(fields: dict[str, str]) -> bytes:
    """Return a connection header, preceded by its length."""
    parts = [f'{key}={value}'.encode() for key, value in fields.items()]
    body = b''.join(struct.pack('<I', len(part)) + part for part in parts)
    return struct.pack('<I', len(body)) + body


def decode_header(body: bytes) -> dict[str, str]:
    """Return the fields of a connection header; raise Malformed if a field is malformed."""
    fields, at = {}, 0
    while at < len(body):
        length = int.from_bytes(body[at:at + 4], 'little')
        at += 4
        if length > len(body) - at:
            raise Malformed('header field longer than the header')
        key, separator, value = body[at:at + length].partition(b'=')
        if not separator:
            raise Malformed('header field without "="')
        fields[key.decode(errors='replace')] = value.decode(errors='replace')
        at += length
    return fields


def _check(topic: str, header: dict[str, str]) -> None:
    """Raise Ros1Error if the publisher refuses, or publishes another type."""
    if 'error' in header:
        raise Ros1Error(
            Stage.PUBLISHER, f'the publisher refuses {topic} ({header["error"][:200]})',
            "look at the publisher's log")
    kind, md5sum = header.get('type', ''), header.get('md5sum', '')
    if kind != joint_state.TYPE:
        raise Ros1Error(Stage.TYPE, f'{topic} has the type {kind[:100] or "nothing"}',
                        f'choose a topic of {joint_state.TYPE}')
    if md5sum != joint_state.MD5SUM:
        raise Ros1Error(Stage.TYPE, f'{topic} has the checksum {md5sum[:100] or "nothing"}',
                        f"the publisher's definition of {joint_state.TYPE} is not that of ROS 1 "
                        f'({joint_state.MD5SUM}): build the publisher against common_msgs')
