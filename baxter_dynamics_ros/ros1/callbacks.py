"""XML-RPC server that a ROS 1 master calls when the publishers of a topic change."""

from collections.abc import Callable
import threading
from typing import Any
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

from .errors import Malformed
from .rpc import texts

MAX_REQUEST = 1024 * 1024  # [bytes]


class _Handler(SimpleXMLRPCRequestHandler):
    """Request handler with bounded length and time."""

    timeout = 2.0  # [s]

    def do_POST(self) -> None:  # noqa: N802
        """Answer a request of known and acceptable length."""
        length = self.headers.get('content-length', '')
        if length.isascii() and length.isdigit() and int(length[:10]) <= MAX_REQUEST:
            super().do_POST()
        else:
            self.send_error(413)
        self.close_connection = True  # a client must not occupy the only thread


class CallbackServer:
    """
    XML-RPC server of a subscriber, in its own thread, on a free port of all addresses.

    Parameters
    ----------
    on_update : callable
        Called with a topic and the URIs of its publishers when these change.

    """

    def __init__(self, on_update: Callable[[str, tuple[str, ...]], None]) -> None:
        self._on_update = on_update
        self.called = threading.Event()  # set by every call of the master
        self._server = SimpleXMLRPCServer(('', 0), _Handler, logRequests=False)
        self.port: int = self._server.server_address[1]
        self._server.register_function(self._update, 'publisherUpdate')
        self._server.register_function(self._shutdown, 'shutdown')
        self._server.register_function(lambda caller_id: (1, '', 0), 'getPid')
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True,
                         name='ros1 callbacks').start()

    def close(self) -> None:
        """Stop listening."""
        self._server.shutdown()
        self._server.server_close()

    def _update(self, caller_id: Any, topic: Any, publishers: Any) -> tuple[int, str, int]:
        self.called.set()
        try:
            self._on_update(str(topic), texts(publishers))
        except Malformed as error:
            return -1, str(error), 0
        return 1, '', 0

    def _shutdown(self, caller_id: Any, reason: Any = '') -> tuple[int, str, int]:
        self.called.set()
        return 1, 'ignored: stop this node with a signal', 0
