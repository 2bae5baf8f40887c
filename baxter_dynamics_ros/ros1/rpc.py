"""Read-only XML-RPC client of ROS 1 masters and nodes, with bounded answers."""

from http.client import HTTPConnection, HTTPException, HTTPResponse
from typing import Any
from xml.parsers.expat import ExpatError
import xmlrpc.client

from .errors import Malformed, Ros1Error, Step
from .network import connection_error, Endpoint, TIMEOUT

# The only requests this package can send: it cannot publish, call a service or set a parameter.
METHODS = frozenset({'getSystemState', 'getTopicTypes', 'registerSubscriber',
                     'unregisterSubscriber', 'requestTopic'})
MAX_ANSWER = 4 * 1024 * 1024  # [bytes]; a Baxter's system state has about 0.1 MB

_NOT_XMLRPC = (xmlrpc.client.Error, HTTPException, ExpatError, ValueError, TypeError, LookupError,
               AttributeError, ArithmeticError, Malformed)


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


def call(server: Endpoint, step: Step, method: str, *arguments: Any) -> Any:
    """
    Call a method of a ROS 1 master or node.

    Parameters
    ----------
    server : Endpoint
        Address and port.
    step : Step
        MASTER or PUBLISHER: the step to report if the answer is not from a ROS node.
    method : str
        One of METHODS.
    *arguments
        Arguments of the method.

    Returns
    -------
    The third part of (code, message, value).

    Raises
    ------
    Ros1Error
        If there is no answer, or it is not from a ROS node, or reports a failure.

    """
    if method not in METHODS:
        raise ValueError(f'{method}: this client is read-only')
    # A transport caches its connection, so each call has its own.
    transport = _Transport()
    try:
        with xmlrpc.client.ServerProxy(server.uri, transport) as proxy:
            code, message, value = getattr(proxy, method)(*arguments)
    except OSError as error:
        raise connection_error(server.host, server.port, error) from None
    except _NOT_XMLRPC as error:
        raise not_ros(server, step, error) from None
    if code != 1:
        raise Ros1Error(step, f'{method} on {server.uri} failed ({str(message)[:200]})',
                        "look at the robot's log")
    return value


def not_ros(server: Endpoint, step: Step, error: Exception) -> Ros1Error:
    """Return the error for a server that does not answer as ROS 1 does."""
    kind = 'master' if step is Step.MASTER else 'node'
    reason = ': '.join(filter(None, (type(error).__name__, ' '.join(str(error).split())[:100])))
    return Ros1Error(step, f'{server.uri} is not a ROS 1 {kind} ({reason})',
                     "check host and port; the port of Baxter's master is 11311")


def texts(value: Any) -> tuple[str, ...]:
    """Return a list of strings as a tuple; raise Malformed if it is anything else."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, str) for item in value):
        raise Malformed('expected a list of strings')
    return tuple(value)
