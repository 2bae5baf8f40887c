"""The examples run as a reader would run them, and the numbers that they print obey the laws."""

import ast
import os
from pathlib import Path
import re
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory
import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((REPOSITORY / 'examples').glob('*.py'))
# Beside a robot; test/node/test_examples.py runs them.
ROS = ('contact_warning', 'gravity_compensation', 'payload_from_three_poses', 'push')
NUMERICAL = [path for path in EXAMPLES if path.stem not in ROS]
ROS_IMPORTS = {'rclpy', 'sensor_msgs', 'std_msgs', 'baxter_dynamics_interfaces'}
DOCUMENT = REPOSITORY / 'docs' / 'examples.md'
TIME_LIMIT = 60.0  # [s]; each takes one to five on an idle machine
NUMBER = re.compile(r'(?<![\w.^/])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?')
ROUNDING = 1e-5  # numbers below it are rounding errors, which no two machines share


@pytest.fixture(scope='module')
def output(tmp_path_factory):
    """Return a function: what an example prints, run once as a process of its own."""
    printed = {}

    def run(name):
        if name == 'computed_torque':
            for module in ('mujoco', 'baxter_dynamics_ros.simulation.plant'):
                pytest.importorskip(module, reason='needs MuJoCo: pip install ".[demo]"')
        if name not in printed:
            folder = tmp_path_factory.mktemp(name)
            path = os.pathsep.join([str(REPOSITORY), os.environ.get('PYTHONPATH', '')])
            answer = subprocess.run(
                [sys.executable, REPOSITORY / 'examples' / f'{name}.py'], cwd=folder,
                env={**os.environ, 'PYTHONPATH': path},
                stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIME_LIMIT)
            assert (answer.returncode, answer.stderr) == (0, '')
            assert list(folder.iterdir()) == []
            printed[name] = answer.stdout
        return printed[name]

    return run


def numbers(text):
    """Return the numbers in a text."""
    return [float(number) for number in NUMBER.findall(text)]


def table(text, heads):
    """Return the numbers behind each of the first words, one row each."""
    rows = {line.split()[0]: line for line in text.splitlines() if line.split()}
    return np.array([numbers(rows[head].split(maxsplit=1)[1]) for head in heads])


def test_each_kind_of_use_has_its_example():
    assert [path.stem for path in NUMERICAL] == [
        'base_parameters', 'computed_torque', 'linearise', 'manipulability', 'passivity']
    assert sorted(path.stem for path in EXAMPLES if path not in NUMERICAL) == sorted(ROS)


@pytest.mark.parametrize('path', EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_stands_on_what_is_public(path):
    source = path.read_text(encoding='utf-8')
    assert len(source.splitlines()) < 80
    tree = ast.parse(source)
    assert f'Run: python examples/{path.name}' in ast.get_docstring(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            assert node.attr == '__init__' or not node.attr.startswith('_'), node.attr
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            names = [node.module] if isinstance(node, ast.ImportFrom) else [
                alias.name for alias in node.names]
            for name in names:
                top, *rest = name.split('.')
                assert top in sys.stdlib_module_names | {'numpy', 'baxter_dynamics_ros'} | (
                    set() if path in NUMERICAL else ROS_IMPORTS)
                assert top != 'baxter_dynamics_ros' or rest[:1] in ([], ['model'], ['simulation'])


@pytest.mark.parametrize('name', ROS)
def test_an_example_beside_a_robot_is_documented_as_one_block_of_commands(name):
    blocks = re.findall(r'```bash\n(.*?)```', DOCUMENT.read_text(encoding='utf-8'), re.DOTALL)
    (block,) = (block for block in blocks if f'python examples/{name}.py' in block)
    *nodes, last = block.splitlines()
    assert [line.split()[0] for line in nodes[:2]] == ['fake_baxter', 'torque_predictor']
    assert all(line.endswith(' &') for line in nodes) and not last.endswith('&')


@pytest.mark.parametrize('path', NUMERICAL, ids=lambda path: path.stem)
def test_what_an_example_prints_is_what_is_documented(path, output):
    text = DOCUMENT.read_text(encoding='utf-8')
    command, shown = f'python examples/{path.name}', None
    section = text.split(f'```bash\n{command}\n```\n')
    assert len(section) == 2, f'{command} is not in {DOCUMENT.name}'
    shown = re.search(r'```text\n(.*?)```', section[1], re.DOTALL)[1]
    printed = output(path.stem)
    assert NUMBER.sub('0', shown).split() == NUMBER.sub('0', printed).split()
    expected, actual = np.abs(numbers(shown)), np.abs(numbers(printed))  # axes have any sign
    noise = (expected < ROUNDING) & (actual < ROUNDING)
    np.testing.assert_allclose(actual[~noise], expected[~noise], rtol=0.02, atol=0.002)


@pytest.fixture
def errors(output):
    """Return the RMS errors [mrad]: joints, three arms, PD and computed torque."""
    return table(output('computed_torque'), JOINTS).reshape(7, 3, 2)


def test_computed_torque_follows_a_rigid_arm_much_better(errors):
    assert (errors[:, 0, 1] < errors[:, 0, 0] / 10).all()
    assert errors[:, 0, 1].max() < 0.1  # mrad


def test_computed_torque_is_spoiled_by_a_friction_of_which_it_is_not_told(errors):
    assert (errors[:, 1, 1] > 10 * errors[:, 0, 1]).all()


def test_computed_torque_is_mended_by_being_told(errors):
    assert (errors[:, 2, 1] < errors[:, 2, 0] / 10).all()


@pytest.fixture
def sections(output):
    """Return the output's parts: name -> lines."""
    parts = re.split(r'^(hanging|upright|in motion), ', output('linearise'), flags=re.M)
    return dict(zip(parts[1::2], (part.splitlines() for part in parts[2::2])))


def test_the_linearisation_differs_from_finite_differences_by_rounding(sections):
    assert list(sections) == ['hanging', 'upright', 'in motion']
    for lines in sections.values():
        errors = numbers(lines[-1])
        assert len(errors) == 2 and max(errors) < 1e-6


@pytest.mark.parametrize('name, sign, word', [
    ('hanging', -1.0, 'swings'), ('upright', 1.0, 'falls')])
def test_eigenvalues_are_those_of_gravity_against_inertia(sections, name, sign, word):
    head, balance, *modes, _ = sections[name]
    assert numbers(balance)[0] < 1e-12  # N m
    q = np.array(numbers(head))  # two decimals
    arm, step = BaxterArm(mount=mount('right')), 1e-4
    stiffness = np.transpose([(arm.gravity(q + step * unit) - arm.gravity(q - step * unit))
                              / (2 * step) for unit in np.eye(7)])
    squares = np.linalg.eigvals(-np.linalg.solve(arm.mass_matrix(q), stiffness)).real
    sizes = np.array([float(re.search(r'\+-\s*(\S+?)j? ', mode)[1]) for mode in modes])
    np.testing.assert_allclose(np.sort(sign * squares), sizes ** 2, rtol=0.05, atol=0.01)
    assert 'drifts' in modes[0] and all(word in mode for mode in modes[1:])
    assert [' j' in mode or 'j ' in mode for mode in modes[1:]] == [sign < 0] * 6
    for mode, size in zip(modes[1:], sizes[1:]):
        frequency_or_time = size / (2 * np.pi) if sign < 0 else np.log(2) / size
        assert numbers(mode)[-1] == pytest.approx(frequency_or_time, abs=0.01)


def test_only_the_christoffel_matrix_is_skew(output):
    christoffel, other = table(output('passivity'), ('Christoffel', 'another,'))
    assert christoffel[0] < 1e-6 and other[0] > 1.0
    assert max(christoffel[1], other[1]) < 1e-12  # N m: both give the same torques


def test_energy_changes_by_the_work_to_the_fourth_order(output):
    step, change, work, difference = np.array(
        [numbers(line) for line in output('passivity').splitlines()[-4:]]).T
    assert np.abs(work).min() > 5.0  # J: something happens
    np.testing.assert_allclose(change, work, rtol=0.0, atol=2e-5)
    orders = np.diff(np.log(np.abs(difference))) / np.diff(np.log(step))
    np.testing.assert_allclose(orders, 4.0, rtol=0.0, atol=0.1)
    assert np.abs(difference[-1]) < 1e-8


@pytest.fixture
def axes(output):
    """Return rows: half axis, direction x y z, and by forward dynamics."""
    return np.array([numbers(line) for line in output('manipulability').splitlines()[2:5]])


def test_axes_of_the_ellipsoid_are_orthogonal_and_reached(axes):
    np.testing.assert_allclose(axes[:, 1:4] @ axes[:, 1:4].T, np.eye(3), atol=2e-3)
    np.testing.assert_allclose(axes[:, 4], axes[:, 0], rtol=1e-3)
    assert axes[0, 0] > axes[1, 0] > axes[2, 0] > 0.0


def test_no_torque_of_the_ellipsoid_does_more_and_some_do_as_much(axes):
    arm = BaxterArm(mount=mount('right'))
    q = HandTrajectory('right', 'lift').q
    holding = arm.gravity(q)
    left = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0]) - np.abs(holding)  # N m
    u = np.random.default_rng(1).standard_normal((10_000, 7))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    qdd = arm.forward_dynamics(q, np.zeros(7), holding + left * u)
    greatest = np.abs(qdd @ arm.jacobian(q)[:3].T @ axes[:, 1:4].T).max(axis=0)
    assert (greatest < 1.005 * axes[:, 0]).all()  # directions are printed with three decimals
    assert (greatest > 0.9 * axes[:, 0]).all()


def test_the_measures_disagree_on_where_the_arm_is_best(axes, output):
    rows = np.array([numbers(line) for line in output('manipulability').splitlines()[6:]])
    assert rows.shape == (15, 4)
    assert rows[0, 3] == pytest.approx(np.prod(axes[:, 0]), rel=1e-3)
    assert np.argmax(rows[:, 2]) == np.argmin(rows[:, 3])
    assert np.corrcoef(rows[:, 2], rows[:, 3])[0, 1] < -0.9


def test_the_base_parameters_are_printed_and_say_it_all(output):
    lines = output('base_parameters').splitlines()
    inertia, rows = numbers(lines[0])[0], table('\n'.join(lines[2:8]), JOINTS[1:])
    np.testing.assert_allclose([inertia, *rows.ravel()], BaxterArm().base_parameters, rtol=0.0,
                               atol=5.1e-5)  # four decimals
    (error,) = numbers(lines[9])
    assert error < 1e-11  # N m


def test_links_of_other_masses_have_the_same_torques(output):
    *links, differences = (numbers(line) for line in output('base_parameters').splitlines()[10:13])
    assert np.abs(np.subtract(*links))[:7].min() > 0.05  # kg
    assert min(least for *_, least in links) > 0.0  # bodies can have such pseudo-inertias
    assert differences[0] < 1e-11 and differences[1] < 1e-13  # N m; kg m^2 and kg m


def test_only_an_exciting_motion_tells_the_base_parameters_apart(output):
    good, bad = ('random', 'exciting'), ('circle', 'switch', 'lift')
    text = '\n'.join(output('base_parameters').splitlines()[15:])
    assert table(text, good).max() < 10.0
    assert table(text, bad).min() > 1e4
