"""Failures of the connection to a robot: each names its stage, and none ends the client."""

from contextlib import suppress
import socket
import struct
import threading
import time
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer

from baxter_dynamics_ros.ros1.subscriber import REST, Subscriber
from baxter_dynamics_ros.ros1.wire import (call, encode_header, Master, MAX_ANSWER, MD5SUM,
                                           Ros1Error, TYPE)
from hypothesis import given, settings, strategies as st
import pytest

TOPIC = '/robot/joint_states'
HEADER = {'callerid': '/robot', 'topic': TOPIC, 'type': TYPE, 'md5sum': MD5SUM}
LONG = struct.pack('<I', 2 ** 31)


def message(seq):
    """Return a joint state without joints, with its length."""
    return struct.pack('<I', 32) + struct.pack('<8I', seq, 1500000000 + seq, 0, 0, 0, 0, 0, 0)


class Robot:
    """A ROS 1 master and publisher in one: answers are as given, a connection gets given bytes."""

    def __init__(self, replies, answers):
        self.replies, self.answers = replies, answers
        self.calls, self.registered, self.connections = [], [], 0
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
        self.calls.append(method)
        if method == 'registerSubscriber':
            self.registered.append(arguments)
        subscribers = [arguments[0] for arguments in self.registered]
        value = {'getSystemState': [[[TOPIC, ['/robot']]], [[TOPIC, subscribers]], []],
                 'registerSubscriber': [], 'unregisterSubscriber': 1, 'lookupNode': self.uri,
                 'requestTopic': ['TCPROS', '127.0.0.1', self._tcp.getsockname()[1]]}[method]
        answer = self.answers.get(method) or value
        return answer(*arguments) if callable(answer) else (1, '', answer)

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
                with suppress(OSError):
                    peer.sendall(reply)
                    if reply.endswith(message(3)):
                        peer.recv(1)  # until the client closes


@pytest.fixture
def serve(monkeypatch):
    """Return a function that subscribes to a robot with these replies: robot, client, messages."""
    monkeypatch.delenv('ROS_IP', raising=False)
    monkeypatch.delenv('ROS_HOSTNAME', raising=False)
    ends = []

    def serve_(*replies, **answers):
        robot = Robot(replies, answers)
        received = []

        def take(topic, source, state, arrival):
            received.append(state.seq)
            assert state.seq != 13  # an error of the receiver must not end the client
        client = Subscriber(robot.uri, [TOPIC], take, print)
        ends.extend((client.close, robot.close))
        return robot, client, received
    yield serve_
    for end in ends:
        end()


def until(condition):
    """Wait until a condition holds."""
    limit = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.02)


@pytest.mark.parametrize('reply, answers, stage, found', [
    (encode_header({'error': 'no such topic here'}), {}, 'publisher', 'no such topic here'),
    (encode_header({**HEADER, 'type': 'std_msgs/String'}), {}, 'type', 'std_msgs/String'),
    (encode_header({**HEADER, 'md5sum': 'f00'}), {}, 'type', 'checksum f00'),
    (encode_header({}), {}, 'type', 'has the type nothing'),
    (b'', {'requestTopic': 7}, 'publisher', 'is not a ROS 1 publisher'),
    (b'', {'requestTopic': 'x'}, 'publisher', '/robot at http://127.0.0.1:'),
    (b'', {'requestTopic': ['UDPROS', '127.0.0.1', 1]}, 'publisher', 'does not offer TCPROS'),
    (b'', {'requestTopic': ['TCPROS', 'x', 10 ** 6]}, 'port', 'port 1000000 of 127.0.0.1 is'),
    (b'', {'requestTopic': ['TCPROS', '127.0.0.1', 1]}, 'port', 'is closed: if the publisher was'),
    (b'', {'lookupNode': 'rosrpc://x:1'}, 'name', "'rosrpc://x:1' is not the URI"),
    (b'', {'getSystemState': lambda caller: time.sleep(1.0)}, 'master', 'no answer from http'),
    (b'', {'getSystemState': [3]}, 'master', 'is not a ROS 1 master'),
    (b'', {'getSystemState': [[[TOPIC, 7]], [], []]}, 'master', 'is not a ROS 1 master'),
    (b'', {'getSystemState': [[], [], []]}, 'topic', f'{TOPIC} is not published'),
    (encode_header(HEADER), {}, 'stream', 'ended (ConnectionError: closed by the publisher)'),
    (encode_header(HEADER) + LONG, {}, 'stream', 'malformed message on /robot/joint'),
    (encode_header(HEADER) + message(3), {}, 'address', 'does not reach this machine'),
    (encode_header(HEADER) + message(3), {}, 'stream', 'nothing has arrived'),
])
def test_each_failure_names_its_stage_and_a_remedy(serve, reply, answers, stage, found):
    _, client, received = serve(reply, **answers)
    assert client.is_called is None  # the probe has not ended
    until(lambda: any(error.stage == stage and found in str(error) and error.remedy
                      for error in client.problems(TOPIC)))
    assert received or client.is_silent(TOPIC)
    assert stage != 'address' or client.is_called is False


def test_unusable_hosts_ports_and_uris(monkeypatch):
    with socket.create_server(('127.0.0.1', 0)) as silent:  # accepts, and never answers
        monkeypatch.setattr('baxter_dynamics_ros.ros1.wire.TIMEOUT', 0.2)
        cases = {
            f'http://127.0.0.1:{silent.getsockname()[1]}': 'port',
            'http://no-such-robot.invalid': 'name', 'http://127.0.0.1:1': 'port',
            'http://x:99999999': 'name', 'robot:11311': 'name', f'http://{"a" * 70}.local': 'name'}
        for uri, stage in cases.items():
            with pytest.raises(Ros1Error) as error:
                Master(uri, '/test').system_state()
            assert error.value.stage == stage and error.value.remedy


def test_closing_does_not_wait_for_a_name_that_resolves_slowly(monkeypatch):
    monkeypatch.setattr('baxter_dynamics_ros.ros1.wire.resolve', lambda host: time.sleep(20.0))
    client = Subscriber('http://robot:11311', [TOPIC], print, print)
    begin = time.monotonic()
    client.close()
    assert time.monotonic() - begin < 5.0  # ROS 2 kills a node that takes longer


def test_own_address_follows_the_environment(monkeypatch):
    with socket.create_server(('127.0.0.1', 0)) as server:
        master = Master(f'http://127.0.0.1:{server.getsockname()[1]}', '/test')
        assert master.locate() == '127.0.0.1'
        for name, value in (('ROS_IP', '10.0.0.7'), ('ROS_HOSTNAME', 'me')):
            monkeypatch.setenv(name, value)
            assert master.locate() == value


def test_client_is_read_only():
    for method in ('setParam', 'registerPublisher', 'registerService', 'deleteParam', 'shutdown'):
        with pytest.raises(ValueError, match='read-only'):
            call('127.0.0.1', 1, 'master', str, method)


def test_malformed_streams_are_counted_and_reconnected(serve):
    good = encode_header(HEADER) + message(1) + message(2)
    _, client, received = serve(
        LONG, struct.pack('<I', 5) + b'\xff' * 5, good + LONG,
        good + message(2) + b'\x04\0\0\0abcd',
        good + struct.pack('<I', 33) + message(1)[4:] + b'x', encode_header(HEADER) + message(13),
        encode_header(HEADER) + message(3))
    until(lambda: 3 in received)
    assert (client.malformed, client.reconnections) == (5, 4)
    source, = client.sources(TOPIC)
    assert source.repeated >= 1 and source.publisher == '/robot'


def test_publishers_are_followed_when_the_master_calls(serve):
    robot, client, received = serve(encode_header(HEADER) + message(3))
    until(lambda: received)
    _, topic, kind, api = robot.registered[-1]
    assert (topic, kind) == (TOPIC, '*') and len(client.connections(TOPIC)) == 1
    robot.answers['getSystemState'] = [[], [[TOPIC, [client.name]]], []]
    until(lambda: not client.connections(TOPIC))
    address = '127.0.0.1', int(api.split(':')[2].strip('/'))
    for length, code in ((10 ** 12, 413), ('x', 413), (-1, 413), (12, 200)):
        with socket.create_connection(address) as peer:
            peer.sendall(b'POST / HTTP/1.1\r\nContent-Length: %b\r\n\r\n<methodCall>'
                         % str(length).encode())
            assert str(code).encode() in peer.recv(20)
    assert not client.is_called and robot.connections == 1
    del robot.answers['getSystemState']
    assert ServerProxy(api).setParam('/master', 'x', 1)[0] == -1
    assert ServerProxy(api).getPid('/rosnode') == [1, '', 0]
    assert ServerProxy(api).publisherUpdate('/master', TOPIC, 7)[0] == 1
    until(lambda: robot.connections == 2)
    assert client.is_called

    begin, before = time.monotonic(), robot.calls.count('getSystemState')
    while time.monotonic() < begin + 0.5:  # a flood of calls is none on the robot's master
        ServerProxy(api).publisherUpdate('/master', TOPIC, [])
    polls = robot.calls.count('getSystemState') - before
    assert polls <= 3 + (time.monotonic() - begin) / REST


def test_publishers_are_bounded_and_one_that_has_just_gone_does_not_hide_the_others(serve):
    names = ['/gone', '/robot', *(f'/{k}' for k in range(98))]

    def look_up(caller, name):
        if name == '/gone':
            return -1, 'unknown node', 0
        return 1, '', robot_uri if name == '/robot' else f'http://127.0.0.1:1{name}'
    robot, client, received = serve(
        encode_header(HEADER) + message(3), lookupNode=look_up,
        getSystemState=lambda caller: (1, '', [[[TOPIC, names]], [], []]))
    robot_uri = robot.uri
    until(lambda: received and client.problem is None)
    assert len(client.connections(TOPIC)) == 63
    robot.answers['lookupNode'] = lambda *given: time.sleep(3.0)
    until(lambda: client.problem)
    assert len(client.connections(TOPIC)) == 63 and 'does not answer' in client.problem.cause


@pytest.fixture(scope='module')
def answering():
    """Return a server that answers each request with the bytes in its attribute body."""
    server = SimpleXMLRPCServer(('127.0.0.1', 0), logRequests=False)
    server._marshaled_dispatch = lambda *given: server.body
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
@settings(max_examples=60, deadline=None)
def test_arbitrary_answers_are_reported_as_no_master(answering, body):
    answering.body = body
    with pytest.raises(Ros1Error) as error:
        Master(f'http://127.0.0.1:{answering.server_address[1]}', '/test').system_state()
    assert error.value.stage == 'master'


def test_an_answer_that_is_too_long_is_refused(answering):
    answering.body = b' ' * (MAX_ANSWER + 1)
    with pytest.raises(Ros1Error, match='an answer of more than'):
        Master(f'http://127.0.0.1:{answering.server_address[1]}', '/test').system_state()
