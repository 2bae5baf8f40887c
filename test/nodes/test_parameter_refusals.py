"""Parameters out of range, of the wrong type or length, or not finite: refused with the reason."""

import gc
import math
from threading import Timer

from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.estimation.settings import SETTINGS
from baxter_dynamics_ros.nodes.torque_predictor import main
import pytest
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
import rclpy
from rclpy.parameter import Parameter


def bad_values(setting) -> list:
    """Return values that the setting must refuse, of the kinds that a parameter can have."""
    default, lower, upper = setting.default, setting.lower, setting.upper
    if isinstance(default, bool):
        return [1, 1.0, 'magic', [True], []]
    if isinstance(default, str) and not setting.choices:
        return [True, 1, 1.0]
    if isinstance(default, str):
        wrong = ['magic', default.upper()] if setting.choices else []
        return [True, 1, 1.0, *wrong, [default], []]
    if isinstance(default, int):
        return [lower - 1, upper + 1, 2 ** 62, True, float(lower), math.nan, 'magic', [lower], []]
    margin = 1e-3 * (upper - lower)
    beyond = [lower - margin, upper + margin, 1e308, math.nan, math.inf, -math.inf]
    if isinstance(default, float):
        return [*beyond, True, 1, 'magic', [default], []]
    n, rest = len(default), list(default[1:])
    return [*([x, *rest] for x in beyond[:4]), *([*rest, x] for x in beyond[4:]),
            rest, [*default, 0.0], [], [True] * n, [0] * n, ['magic'] * n, 'magic', 1.0]


def text(value) -> str:
    """Write a value as it stands on a command line."""
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(map(text, value))}]'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return '.nan' if math.isnan(value) else f'{value:+}'.replace('inf', '.inf')
    return str(value)


def expected(setting) -> str:
    """Return what the reason must say of a value of another type or length."""
    default = setting.default
    if isinstance(default, bool):
        return 'true or false'
    if isinstance(default, str):
        return ', '.join(setting.choices) or 'text'
    if isinstance(default, tuple):
        return str(len(default))
    return 'whole number' if isinstance(default, int) else 'decimal point'


def is_of_its_kind(setting, value) -> bool:
    """Tell whether only the size of the value is wrong."""
    if isinstance(setting.default, tuple):
        return (isinstance(value, list) and len(value) == len(setting.default)
                and type(value[0]) is float)
    return type(value) is type(setting.default)


def assert_reason(setting, name, value, reason):
    """Assert that a refusal is one line that names the parameter, and says what it should be."""
    assert len(reason.splitlines()) == 1, reason
    assert name in reason
    if not is_of_its_kind(setting, value):
        assert expected(setting) in reason, (value, reason)


@pytest.fixture
def start_here(domain, capfd):
    """Return a function that starts a node in this process, where it must end at once."""
    def start_(*arguments) -> str:
        watch = Timer(10.0, rclpy.try_shutdown)  # it runs: nothing was refused
        watch.start()
        try:
            code = main(['torque_predictor', '--ros-args', *(
                part for argument in arguments for part in ('-p', argument))])
        finally:
            watch.cancel()
            rclpy.try_shutdown()
        out, err = capfd.readouterr()
        assert code == 1, arguments
        assert len(err.splitlines()) == 1 and not out, (arguments, out, err)
        assert err.startswith('torque_predictor: ')
        return err[len('torque_predictor: '):]
    yield start_
    gc.collect()  # nodes that failed are still there, and would not answer for later ones


@pytest.mark.parametrize('setting', SETTINGS, ids=lambda setting: setting.name)
def test_at_the_start_every_bad_value_is_one_line_and_exit_code_1(start_here, setting):
    for value in bad_values(setting):
        reason = start_here(f'{setting.name}:={text(value)}')
        assert_reason(setting, setting.name, value, reason)


@pytest.mark.parametrize('arguments, problem', [
    (['payload.inertia:=[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]'], 'payload.mass is zero'),
    (['arm:=both'], "arm: expected one of right, left, got 'both'"),
    (['payload.mass:=11.0'], 'payload.mass: expected a value in [0, 10] kg, got 11'),
    (['acceleration.cutoff:=1'], 'a number with a decimal point, such as 1.0, got 1'),
    (['effort_model.spring_range:=[1.0, -1.0]'], 'spring_range: expected lower < upper'),
    (['payload.mas:=1.0'], 'payload.mas: no such parameter; did you mean payload.mass?'),
    (['acceleration.cutoff:='], 'acceleration.cutoff'),
    (['gravity:=[0.0, 0.0, "g"]'], 'gravity'),
    (['qos_overrides./robot/joint_states.subscription.reliability:=foo'], 'foo'),
])
def test_what_fits_to_nothing_else_is_refused_at_the_start(start_here, arguments, problem):
    assert problem in start_here(*arguments)


@pytest.mark.parametrize('argument, problem', [
    ('acceleration.cutoff:=-1.0', 'acceleration.cutoff'),
    ('effort_model.bias:=[1.0]', 'effort_model.bias: expected shape (7,)'),
    ('links.mass:=[0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]', 'links'),
])
def test_a_process_that_is_refused_a_value_ends(refuses, argument, problem):
    refuses('torque_predictor', argument, problem)


def test_another_nodes_parameter_is_logged_and_a_plain_argument_refused(robot, start):
    process = start('torque_predictor', '-p', 'camera_frame:=wrist')
    robot.wait_for_node()
    robot.until(lambda: 'camera_frame is given, but this node has none' in process.output)
    with NodeProcess('torque_predictor', ['--arm', 'left']) as process:
        assert process.wait(20.0) == 2
        assert 'unrecognized arguments: --arm left' in process.output
    with NodeProcess('torque_predictor', ['-p', 'align:=false']) as process:
        assert process.wait(20.0) == 2
        assert 'torque_predictor --ros-args -p align:=false' in process.output


def test_at_run_time_every_bad_value_is_refused_and_nothing_changes(robot, start):
    process = start('torque_predictor')
    changeable = [setting for setting in SETTINGS if not setting.read_only]
    get = GetParameters.Request(names=[setting.name for setting in changeable])
    before = robot.call(GetParameters, 'get_parameters', get).values
    bad = [(setting, value) for setting in changeable for value in bad_values(setting)]
    results = robot.call(SetParameters, 'set_parameters', SetParameters.Request(parameters=[
        Parameter(setting.name, value=value).to_parameter_msg() for setting, value in bad])
    ).results
    assert len(results) == len(bad) > 200
    for (setting, value), result in zip(bad, results):
        assert not result.successful, (setting.name, value)
        assert_reason(setting, setting.name, value, result.reason)
    assert robot.call(GetParameters, 'get_parameters', get).values == before
    assert process.exit_code is None
    assert 'Traceback' not in process.output


SET_AT_ONCE = [
    ({'arm': 'left'}, 'arm: is fixed when the node starts'),
    ({'arm': 1}, 'arm'),
    ({'effort_model.spring_range': [1.0, -1.0]}, 'spring_range: expected lower < upper'),
    ({'payload.inertia': [0.1] * 3 + [0.0] * 3}, 'payload.inertia: expected zero where'),
    ({'payload.mass': 1.0, 'align': False, 'contact.samples': 0}, 'contact.samples'),
    ({'payload.mass': 1.0, 'align': 'no', 'contact.samples': 5}, 'align: expected true or false'),
    ({'payload.mass': 1.0, 'payload.mas': 1.0},
     'payload.mas: no such parameter; did you mean payload.mass?'),
]


def test_what_is_set_at_once_is_refused_as_a_whole(robot, predictor):
    get = GetParameters.Request(names=[setting.name for setting in SETTINGS])
    before = robot.call(GetParameters, 'get_parameters', get).values
    for values, problem in SET_AT_ONCE:
        result = robot.call(
            SetParametersAtomically, 'set_parameters_atomically',
            SetParametersAtomically.Request(parameters=[
                Parameter(name, value=value).to_parameter_msg()
                for name, value in values.items()])).result
        assert not result.successful, values
        assert problem in result.reason
        assert robot.call(GetParameters, 'get_parameters', get).values == before
