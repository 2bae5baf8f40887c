"""The command ros2 where there is none, as far as the documents use it: over real DDS, strict."""

import argparse
import importlib
import os
import shutil
import sys
import time

from document_launch import launch, LaunchError
from document_setup import executables, PACKAGE, REPOSITORY
import yaml

# [s] for what has been started just now to be found
WAIT = float(os.environ.get('ROS2_STAND_IN_WAIT', '20.0'))


class Refused(Exception):
    """A command line, or what it asks for, is wrong."""


def main() -> int:
    """Run a command; return its exit code: 2 for a command that ros2 would not know."""
    options = parser().parse_args()
    try:
        return options.run(options) or 0
    except (Refused, LaunchError) as error:
        print(f'ros2: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of all that the stand-in can do."""
    root = argparse.ArgumentParser(prog='ros2', allow_abbrev=False)
    groups, verbs = root.add_subparsers(required=True), {}

    def verb(group, name, function, *names, **options):
        if group not in verbs:
            verbs[group] = groups.add_parser(group, allow_abbrev=False).add_subparsers(
                required=True)
        _fill(verbs[group].add_parser(name, allow_abbrev=False), function, names, options)

    for name, function, what in (('run', run, 'executable'), ('launch', run_launch, 'file')):
        _fill(groups.add_parser(name, allow_abbrev=False), function,
              ('package', what, 'arguments...'), {})
    waiting = {'--no-daemon': None, '--spin-time': float}
    verb('topic', 'echo', echo, 'topic', 'type?', **waiting, **{
        '--once': None, '--field': str, '--timeout': float, '--full-length': None,
        '--flow-style': None})
    verb('topic', 'hz', hz, 'topic', **waiting, **{'--window': int})
    verb('topic', 'info', info, 'topic', **waiting, **{'--verbose': None, '-v': None})
    verb('topic', 'list', list_topics, **waiting, **{'--show-types': None})
    verb('service', 'call', call, 'service', 'type', 'request?')
    verb('service', 'list', list_services, **waiting)
    verb('node', 'list', list_nodes, **waiting)
    verb('param', 'set', set_parameter, 'node', 'name', 'value', **waiting)
    verb('param', 'get', get_parameter, 'node', 'name', **waiting)
    verb('pkg', 'prefix', prefix, 'package', **{'--share': None})
    return root


def _fill(command, function, names, options):
    command.set_defaults(run=function)
    for name in names:
        many = {'?': '?', '.': argparse.REMAINDER}.get(name[-1])
        command.add_argument(name.rstrip('?.'), nargs=many)
    for name, kind in options.items():
        how = {'action': 'store_true'} if kind is None else {'type': kind}
        command.add_argument(name, **how)


def run(options):
    """Become the executable."""
    _own(options.package)
    if options.executable not in executables():
        raise Refused(f'no executable {options.executable}; there are {executables()}')
    path = shutil.which(options.executable)
    if path is None:
        raise Refused(f'{options.executable} is not on the PATH')
    sys.stdout.flush()
    os.execv(path, [path, *options.arguments])


def run_launch(options):
    """Start what a launch file says."""
    _own(options.package)
    file = REPOSITORY / 'launch' / options.file
    given = dict(argument.split(':=', 1) for argument in options.arguments)
    return launch(file, given)


def prefix(options):
    """Print the folder of a package's shared files; an installed one is laid out the same."""
    _own(options.package)
    if not options.share:
        raise Refused('the prefix itself holds nothing here: say --share')
    print(REPOSITORY)


def _own(package):
    if package != PACKAGE:
        raise Refused(f'package {package} is not {PACKAGE}')


class Wire:
    """A node that asks others."""

    def __init__(self):
        import rclpy
        rclpy.init(args=[])
        self.rclpy = rclpy
        self.node = rclpy.create_node(f'_ros2cli_{os.getpid()}')

    def until(self, found, what, seconds=WAIT):
        """Return what a function finds, as soon as it does."""
        limit = time.monotonic() + seconds
        while not (result := found()):
            if time.monotonic() > limit:
                raise Refused(f'{what}: nothing within {seconds:.0f} s')
            self.rclpy.spin_once(self.node, timeout_sec=0.05)
        return result

    def types(self, topic):
        """Return the types of a topic that somebody publishes."""
        if self.node.count_publishers(topic):
            return dict(self.node.get_topic_names_and_types()).get(topic)

    def subscribe(self, topic, kind, callback):
        """Hear a topic by any quality of service, once it is there."""
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        (found, *_) = self.until(lambda: self.types(topic), topic)
        if kind not in (None, found):
            raise Refused(f'{topic} is {found}, not {kind}')
        best_effort = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.node.create_subscription(_type(found), topic, callback, best_effort)

    def ask(self, kind, name, request):
        """Call a service, once it is there."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, name)
        future = client.call_async(request)
        self.until(future.done, name)
        return future.result()


def echo(options):
    """Print what comes, and fail where nothing does."""
    wire, heard = Wire(), []
    wire.subscribe(options.topic, options.type, heard.append)
    while True:
        wire.until(lambda: heard, options.topic, options.timeout or WAIT)
        message = heard.pop(0)
        for name in options.field.split('.') if options.field else ():
            message = getattr(message, name)
        print(_text(message), '---', sep='\n', flush=True)
        if options.once:
            return


def hz(options):
    """Print how many messages come in a second."""
    wire, heard = Wire(), []
    wire.subscribe(options.topic, None, lambda message: heard.append(time.monotonic()))
    while True:
        heard.clear()
        wire.until(lambda: len(heard) > 10, options.topic)
        print(f'average rate: {(len(heard) - 1) / (heard[-1] - heard[0]):.3f}', flush=True)


def info(options):
    """Print who publishes and who hears a topic."""
    wire = Wire()
    print(f'Type: {wire.until(lambda: wire.types(options.topic), options.topic)[0]}')
    for kind, ends in (('Publisher', wire.node.get_publishers_info_by_topic(options.topic)),
                       ('Subscription', wire.node.get_subscriptions_info_by_topic(options.topic))):
        print(f'{kind} count: {len(ends)}')
        for end in ends if options.verbose or options.v else ():
            print(f'Node name: {end.node_name}', end.qos_profile, sep='\n')


def list_topics(options):
    """Print the topics there are, once nothing new has come for a while."""
    _list(lambda node: node.get_topic_names_and_types(), options.show_types)


def list_services(options):
    """Print the services there are."""
    _list(lambda node: node.get_service_names_and_types())


def list_nodes(options):
    """Print the nodes there are."""
    _list(lambda node: [(f'{namespace.rstrip("/")}/{name}', ()) for name, namespace in
                        node.get_node_names_and_namespaces() if not name.startswith('_')])


def _list(names_and_types, types=False):
    wire = Wire()
    end = time.monotonic() + 2.0  # [s]
    while time.monotonic() < end:
        wire.rclpy.spin_once(wire.node, timeout_sec=0.1)
    for name, kinds in names_and_types(wire.node):
        print(name, *(kinds if types else ()))


def call(options):
    """Call a service and print the answer."""
    kind = _type(options.type)
    request = kind.Request()
    try:
        _fill_in(request, yaml.safe_load(options.request or '{}'))
    except (AssertionError, AttributeError, TypeError) as error:
        raise Refused(f'{options.request}: {error}') from None
    print('response:', _text(Wire().ask(kind, options.service, request)), sep='\n')


def set_parameter(options):
    """Set a parameter of a node."""
    from rcl_interfaces.msg import Parameter
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import get_parameter_value
    parameter = Parameter(name=options.name, value=get_parameter_value(options.value))
    (result,) = Wire().ask(SetParameters, f'{options.node}/set_parameters',
                           SetParameters.Request(parameters=[parameter])).results
    if not result.successful:
        raise Refused(f'Setting parameter failed: {result.reason}')
    print('Set parameter successful')


def get_parameter(options):
    """Print a parameter of a node."""
    from rcl_interfaces.srv import GetParameters
    from rclpy.parameter import parameter_value_to_python
    (value,) = Wire().ask(GetParameters, f'{options.node}/get_parameters',
                          GetParameters.Request(names=[options.name])).values
    if not value.type:
        raise Refused(f'Parameter not set: {options.name}')
    print(f'{options.name}: {parameter_value_to_python(value)}')


def _type(name):
    package, folder, name = name.split('/')
    return getattr(importlib.import_module(f'{package}.{folder}'), name)


def _text(value):
    return yaml.safe_dump(_plain(value), sort_keys=False, default_flow_style=None)


def _plain(value):
    if hasattr(value, 'get_fields_and_field_types'):
        return {name: _plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, str) or not hasattr(value, '__iter__'):
        return value
    return [_plain(each) for each in (value.tolist() if hasattr(value, 'tolist') else value)]


def _fill_in(message, values):
    for name, value in values.items():
        inner = getattr(message, name)
        if hasattr(inner, 'get_fields_and_field_types'):
            _fill_in(inner, value)
        else:
            setattr(message, name, value)


if __name__ == '__main__':
    sys.exit(main())
