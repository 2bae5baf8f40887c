"""Failures of the connection to a robot: each names its stage, and none ends the client."""

from http.server import BaseHTTPRequestHandler, HTTPServer
import socket
import struct
import threading
import time
import urllib.error
import urllib.request
from xmlrpc.server import SimpleXMLRPCServer

from baxter_dynamics_ros.ros1.errors import Ros1Error, Stage
from baxter_dynamics_ros.ros1.joint_state import MD5SUM, TYPE
from baxter_dynamics_ros.ros1.master import Master
from baxter_dynamics_ros.ros1.network import Endpoint, local_address
from baxter_dynamics_ros.ros1.rpc import call, MAX_ANSWER
from baxter_dynamics_ros.ros1.subscriber import Subscriber
from baxter_dynamics_ros.ros1.tcpros import encode_header
from hypothesis import given, settings, strategies as st
import pytest

TOPIC = '/robot/joint_states'
HEADER = {'callerid': '/robot', 'topic': TOPIC, 'type': TYPE, 'md5sum': MD5SUM}
LONG = struct.pack('<I', 2 ** 31)


def message(seq):
    """Return a joint state without joints, with its length."""
    return struct.pack('<I', 32) + struct.pack('<8I', seq, 1500000000 + seq, 0, 0, 0, 0, 0, 0)[:32]


class Robot:
    """A ROS 1 master and publisher in one: answers are as given, a connection gets given bytes."""

    def __init__(self, replies):
        self.answers = {'requestTopic': None}
        self.registered, self.replies, self.connections = [], list(replies), 0
        self._rpc = SimpleXMLRPCServer(('127.0.0.1', 0), logRequests=False)
        self._tcp = socket.create_server(('127.0.0.1', 0))
        self.uri = f'http://127.0.0.1:{self._rpc.server_address[1]}/'
        self._rpc.register_instance(self)
        for target in (lambda: self._rpc.serve_forever(0.02), self._serve):
            threading.Thread(target=target, daemon=True).start()

    def close(self):
        """Close both servers."""
        self._rpc.shutdown()
        self._rpc.server_close()
        self._tcp.close()

    def _dispatch(self, method, arguments):
        if method == 'registerSubscriber':
            self.registered.append(arguments)
        subscribers = [arguments[0] for arguments in self.registered]
        value = {'getSystemState': [[[TOPIC, ['/robot']]], [[TOPIC, subscribers]], []],
                 'registerSubscriber': [self.uri], 'unregisterSubscriber': 1,
                 'requestTopic': ['TCPROS', '127.0.0.1', self._tcp.getsockname()[1]]}[method]
        return 1, '', self.answers.get(method) or value

    def _serve(self):
        while True:
            try:
                peer, _ = self._tcp.accept()
            except OSError:
                return
            with peer:
                peer.recv(4096)
                reply = self.replies[min(self.connections, len(self.replies) - 1)]
                self.connections += 1
                try:
                    peer.sendall(reply)
                    if reply.endswith(message(3)):
                        peer.recv(1)  # until the client closes
                except OSError:
                    pass


@pytest.fixture
def serve(monkeypatch):
    """Return a function that subscribes to a robot with these replies: robot, client, messages."""
    monkeypatch.delenv('ROS_IP', raising=False)
    monkeypatch.delenv('ROS_HOSTNAME', raising=False)
    ends = []

    def serve_(*replies, **answers):
        robot = Robot(replies)
        robot.answers.update(answers)
        received, notes = [], []
        client = Subscriber(robot.uri, [TOPIC], lambda *given: received.append(given[2].seq),
                            notes.append)
        ends.extend((client.stop, robot.close))
        client.start()
        return robot, client, received
    yield serve_
    for end in ends:
        end()


def until(condition, seconds=10.0):
    """Wait until a condition holds."""
    limit = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.02)


@pytest.mark.parametrize('reply, answers, stage, found', [
    (encode_header({'error': 'no such topic here'}), {}, Stage.PUBLISHER, 'no such topic here'),
    (encode_header({**HEADER, 'type': 'std_msgs/String'}), {}, Stage.TYPE, 'std_msgs/String'),
    (encode_header({**HEADER, 'md5sum': 'f00'}), {}, Stage.TYPE, 'checksum f00'),
    (encode_header({}), {}, Stage.TYPE, 'has the type nothing'),
    (b'', {'requestTopic': ['UDPROS', 'x', 1]}, Stage.PUBLISHER, 'does not offer TCPROS'),
    (b'', {'requestTopic': 'x'}, Stage.PUBLISHER, 'does not offer TCPROS'),
    (b'', {'requestTopic': ['TCPROS', 'x', 10 ** 6]}, Stage.PUBLISHER, 'does not offer TCPROS'),
    (b'', {'requestTopic': ['TCPROS', '127.0.0.1', 1]}, Stage.PORT, 'port 1 of 127.0.0.1 is'),
    (b'', {'registerSubscriber': ['rosrpc://x:1']}, Stage.NAME, "'rosrpc://x:1' is not the URI"),
    (b'', {'registerSubscriber': 'x'}, Stage.MASTER, 'is not a ROS 1 master'),
    (b'', {'getSystemState': [3]}, Stage.MASTER, 'is not a ROS 1 master'),
    (b'', {'getSystemState': [[[TOPIC, 7]], [], []]}, Stage.MASTER, 'is not a ROS 1 master'),
    (encode_header(HEADER), {}, Stage.STREAM, 'the publisher closed the connection'),
    (encode_header(HEADER) + LONG, {}, Stage.STREAM, 'sent a malformed message'),
    (encode_header(HEADER) + message(3), {}, Stage.ADDRESS, 'does not reach this machine'),
])
def test_each_failure_names_its_stage(serve, reply, answers, stage, found):
    _, client, _ = serve(reply, **answers)
    until(lambda: any(error.stage == stage and found in error.cause and error.remedy
                      for error in client.problems(TOPIC)))


def test_unusable_hosts_ports_and_uris(monkeypatch):
    with socket.create_server(('127.0.0.1', 0)) as silent:  # accepts, and never answers
        monkeypatch.setattr('baxter_dynamics_ros.ros1.rpc.TIMEOUT', 0.2)
        cases = {
            f'http://127.0.0.1:{silent.getsockname()[1]}': Stage.ROUTE,
            'http://no-such-robot.invalid': Stage.NAME, 'http://127.0.0.1:1': Stage.PORT,
            'http://x:99999999': Stage.NAME, 'robot:11311': Stage.NAME,
            f'http://{"a" * 70}.local': Stage.NAME}
        for uri, stage in cases.items():
            with pytest.raises(Ros1Error) as error:
                Master(uri, '/test').system_state()
            assert error.value.stage == stage and error.value.remedy


def test_local_address_follows_the_environment():
    assert local_address('127.0.0.1', {}) == '127.0.0.1'
    assert local_address('127.0.0.1', {'ROS_IP': '10.0.0.7'}) == '10.0.0.7'
    assert local_address('127.0.0.1', {'ROS_IP': '10.0.0.7', 'ROS_HOSTNAME': 'me'}) == 'me'


def test_client_is_read_only(serve):
    for method in ('setParam', 'registerPublisher', 'registerService', 'deleteParam', 'shutdown'):
        with pytest.raises(ValueError, match='read-only'):
            call(Endpoint('127.0.0.1', 1), Stage.MASTER, str, method)


def test_malformed_streams_are_counted_and_reconnected(serve):
    good = encode_header(HEADER) + message(1) + message(2)
    robot, client, received = serve(
        LONG, struct.pack('<I', 5) + b'\xff' * 5, good + LONG,
        good + message(2) + b'\x04\0\0\0abcd',
        good + struct.pack('<I', 33) + message(1)[4:] + b'x', encode_header(HEADER) + message(3))
    until(lambda: 3 in received)
    assert client.malformed == 5
    assert client.reconnections == 3
    source, = client.sources(TOPIC)
    assert source.repeated >= 1 and source.publisher == '/robot'


def test_changed_publishers_are_followed(serve):
    robot, client, received = serve(encode_header(HEADER) + message(3))
    until(lambda: received)
    assert robot.registered[-1][2] == '*' and robot.registered[-1][1] == TOPIC
    client._on_update(TOPIC, (robot.uri, robot.uri))
    client._on_update('/other', (robot.uri,))
    time.sleep(0.3)
    assert len(client.connections(TOPIC)) == robot.connections == 1
    client._on_update(TOPIC, ())
    until(lambda: not client.connections(TOPIC))
    until(lambda: client.connections(TOPIC))  # the next look at the master, which lists it


def test_callback_server_refuses_long_requests(serve):
    robot, client, _ = serve(encode_header(HEADER) + message(3))
    until(lambda: robot.registered)
    api = robot.registered[-1][3]
    for body, length in ((b'<a', 10 ** 12), (b'<a', 'x'), (b'<a', -1), (b'<methodCall>', 12)):
        request = urllib.request.Request(api, body, {'Content-Length': str(length)})
        try:
            urllib.request.urlopen(request, timeout=5).read()
        except (urllib.error.URLError, OSError):
            pass
    port = int(api.rsplit(':', 1)[1].strip('/'))
    call_update = Endpoint('127.0.0.1', port)
    with pytest.raises(ValueError):
        call(call_update, Stage.MASTER, str, 'publisherUpdate')
    from xmlrpc.client import ServerProxy
    assert ServerProxy(api).publisherUpdate('/master', TOPIC, 7)[0] == -1
    assert ServerProxy(api).publisherUpdate('/master', TOPIC, [robot.uri])[0] == 1
    assert client.is_called


@pytest.fixture(scope='module')
def answering():
    """Return a server that answers each request with the bytes in its attribute body."""
    class Handler(BaseHTTPRequestHandler):

        def do_POST(self):  # noqa: N802
            self.rfile.read(int(self.headers['content-length']))
            self.send_response(200)
            self.send_header('Content-Length', str(len(server.body)))
            self.end_headers()
            self.wfile.write(server.body)

        def log_message(self, *args):
            pass

    server = HTTPServer(('127.0.0.1', 0), Handler)
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    yield server
    server.shutdown()
    server.server_close()


XML = st.sampled_from(['<methodResponse>', '<params>', '<param>', '<value>', '<array>', '<data>',
                       '<int>', '1', 'x', '</int>', '</value>', '</data>', '</array>', '</param>',
                       '</params>', '</methodResponse>', '<string/>', '<double>', '</double>',
                       '<struct>', '<member>', '<base64>', '</base64>', '<dateTime.iso8601/>',
                       '<nil/>', '<fault>', '&amp;', '<boolean>7</boolean>'])


@given(st.binary(max_size=100) | st.lists(XML, max_size=12).map(lambda tags: ''.join(
    ['<methodResponse><params><param>', *tags, '</param></params></methodResponse>']).encode()))
@settings(max_examples=150, deadline=None)
def test_arbitrary_answers_are_reported_as_no_master(answering, body):
    answering.body = body
    with pytest.raises(Ros1Error) as error:
        Master(f'http://127.0.0.1:{answering.server_address[1]}', '/test').topic_types()
    assert error.value.stage == Stage.MASTER


def test_an_answer_that_is_too_long_is_refused(answering):
    answering.body = b' ' * (MAX_ANSWER + 1)
    with pytest.raises(Ros1Error, match='an answer of more than'):
        Master(f'http://127.0.0.1:{answering.server_address[1]}', '/test').system_state()
