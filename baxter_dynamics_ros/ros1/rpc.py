"""Read-only XML-RPC client of ROS 1 masters and nodes, with bounded answers."""

from collections.abc import Callable
from http.client import HTTPConnection, HTTPException, HTTPResponse
from typing import Any, TypeVar
from xml.parsers.expat import ExpatError
import xmlrpc.client

from .errors import Malformed, Ros1Error, Stage
from .network import connection_error, Endpoint, TIMEOUT

# The only requests this package can send: it cannot publish, call a service or set a parameter.
METHODS = frozenset({'getSystemState', 'getTopicTypes', 'registerSubscriber',
                     'unregisterSubscriber', 'requestTopic'})
MAX_ANSWER = 4 * 1024 * 1024  # [bytes]; a Baxter's system state has about 0.1 MB

_NOT_ROS = (xmlrpc.client.Error, HTTPException, ExpatError, ValueError, TypeError, LookupError,
            AttributeError, ArithmeticError, Malformed)
_Value = TypeVar('_Value')


class _Transport(xmlrpc.client.Transport):
    """Transport with a timeout and a maximum length of answers."""

    accept_gzip_encoding = False

    def make_connection(self, host: Any) -> HTTPConnection:
        """Return a new connection."""
        return HTTPConnection(host, timeout=TIMEOUT)

    def parse_response(self, response: HTTPResponse) -> Any:
        """Return the values of an answer; raise Malformed if it is too long."""
        data = response.read(MAX_ANSWER + 1)
        if len(data) > MAX_ANSWER:
            raise Malformed(f'an answer of more than {MAX_ANSWER} bytes')
        parser, target = self.getparser()
        parser.feed(data)
        parser.close()
        return target.close()


def call(server: Endpoint, stage: Stage, parse: Callable[[Any], _Value], method: str,
         *arguments: Any) -> _Value:
    """
    Call a method of a ROS 1 master or node and return its parsed value.

    Raises
    ------
    Ros1Error
        If there is no answer, it is not from a ROS node (then with the given stage), it reports a
        failure, or ``parse`` rejects its value.

    """
    if method not in METHODS:
        raise ValueError(f'{method}: this client is read-only')
    try:
        # A transport caches its connection, so each call has its own.
        with xmlrpc.client.ServerProxy(server.uri, _Transport()) as proxy:
            code, message, value = getattr(proxy, method)(*arguments)
        if code != 1:
            raise Ros1Error(stage, f'{method} on {server.uri} failed ({str(message)[:200]})',
                            "look at the robot's log")
        return parse(value)
    except OSError as error:
        raise connection_error(server.host, server.port, error) from None
    except _NOT_ROS as error:
        kind = 'master' if stage is Stage.MASTER else 'node'
        reason = ': '.join(filter(None, (
            type(error).__name__, ' '.join(str(error).split())[:100])))
        raise Ros1Error(stage, f'{server.uri} is not a ROS 1 {kind} ({reason})', 'check host and '
                        "port; the port of Baxter's master is 11311") from None


def texts(value: Any) -> tuple[str, ...]:
    """Return a list of strings as a tuple; raise Malformed if it is anything else."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, str) for item in value):
        raise Malformed('expected a list of strings')
    return tuple(value)
