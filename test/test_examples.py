"""Examples and notebook run, the notebook as stored, and their numbers obey the laws."""

from contextlib import redirect_stdout
from functools import cache
import io
import json
from pathlib import Path
import re
from runpy import run_path
import warnings

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
# Those with ROS are run by test/nodes/test_examples.py.
NUMERICAL = sorted(path.stem for path in (REPOSITORY / 'examples').glob('*.py')
                   if 'rclpy' not in path.read_text(encoding='utf-8'))
NUMBER = re.compile(r'(?<![\w.^/])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?')
ROUNDING = 1e-5  # numbers below it are rounding errors, which no two machines share
NOTEBOOK = json.loads((REPOSITORY / 'examples' / 'baxter_arm.ipynb').read_text('utf-8'))


@cache
def output(name):
    """Return the output of an example, run once."""
    if name == 'computed_torque':
        pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
    with redirect_stdout(io.StringIO()) as printed:
        run_path(REPOSITORY / 'examples' / f'{name}.py', run_name='__main__')
    return printed.getvalue()


def assert_same(shown, printed):
    """Assert that two outputs have the same words, and numbers within their rounding."""
    assert NUMBER.sub('0', shown).split() == NUMBER.sub('0', printed).split()
    expected, actual = np.abs(numbers(shown)), np.abs(numbers(printed))  # axes have any sign
    noise = (expected < ROUNDING) & (actual < ROUNDING)
    np.testing.assert_allclose(actual[~noise], expected[~noise], rtol=0.02, atol=0.002)


def numbers(text):
    """Return the numbers in a text."""
    return [float(number) for number in NUMBER.findall(text)]


def table(text, heads):
    """Return the numbers in the lines that begin with a word, one row per word."""
    rows = {line.split()[0]: line for line in text.splitlines() if line.split()}
    return np.array([numbers(rows[head].split(maxsplit=1)[1]) for head in heads])


@pytest.mark.parametrize('name', NUMERICAL)
def test_an_example_runs(name):
    assert output(name)


def test_the_notebook_prints_its_stored_output_and_has_its_figures(monkeypatch):
    pytest.importorskip('matplotlib', reason='needs matplotlib: pip install ".[demo]"')
    monkeypatch.setenv('MPLBACKEND', 'Agg')
    names = {}
    for cell in NOTEBOOK['cells']:
        if cell['cell_type'] == 'code':
            source, stored = ''.join(cell['source']), cell['outputs']
            with redirect_stdout(io.StringIO()) as printed, warnings.catch_warnings():
                warnings.simplefilter('ignore')  # Agg shows no figure
                exec(source, names)
            assert_same(''.join(''.join(output['text']) for output in stored
                                if output['output_type'] == 'stream'), printed.getvalue())
            assert source.count('plt.show()') == sum(
                output['output_type'] == 'display_data' for output in stored)


def test_computed_torque_follows_an_arm_whose_friction_it_knows():
    errors = table(output('computed_torque'), JOINTS).reshape(7, 3, 2)  # joints, arms, controllers
    rigid, unknown, known = np.moveaxis(errors, 1, 0)  # [mrad] PD, computed torque
    assert (rigid[:, 1] < rigid[:, 0] / 10).all() and rigid[:, 1].max() < 0.1
    assert (unknown[:, 1] > 10 * rigid[:, 1]).all()
    assert (known[:, 1] < known[:, 0] / 10).all()


@pytest.mark.parametrize('name, sign', [('hanging', -1.0), ('upright', 1.0)])
def test_eigenvalues_are_those_of_gravity_against_inertia(name, sign):
    parts = re.split(r'^(hanging|upright|in motion), ', output('linearise'), flags=re.M)
    head, balance, *modes, errors = dict(zip(parts[1::2], map(str.splitlines, parts[2::2])))[name]
    assert numbers(balance)[0] < 1e-12  # N m
    assert max(numbers(errors)) < 1e-6  # to finite differences
    q = np.array(numbers(head))  # two decimals
    arm, step = BaxterArm(mount=mount('right')), 1e-4
    stiffness = np.transpose([(arm.gravity(q + step * unit) - arm.gravity(q - step * unit))
                              / (2 * step) for unit in np.eye(7)])
    squares = np.linalg.eigvals(-np.linalg.solve(arm.mass_matrix(q), stiffness)).real
    sizes = np.array([float(re.search(r'\+-\s*(\S+?)j? ', mode)[1]) for mode in modes])
    np.testing.assert_allclose(np.sort(sign * squares), sizes ** 2, rtol=0.05, atol=0.01)


def test_only_the_christoffel_matrix_is_skew():
    christoffel, other = table(output('passivity'), ('Christoffel', 'another,'))
    assert christoffel[0] < 1e-6 and other[0] > 1.0
    assert max(christoffel[1], other[1]) < 1e-12  # N m: both give the same torques


def test_energy_changes_by_the_work_to_the_fourth_order():
    step, change, work, difference = np.array(
        [numbers(line) for line in output('passivity').splitlines()[-4:]]).T
    assert np.abs(work).min() > 5.0  # J: something happens
    np.testing.assert_allclose(change, work, rtol=0.0, atol=2e-5)
    orders = np.diff(np.log(np.abs(difference))) / np.diff(np.log(step))
    np.testing.assert_allclose(orders, 4.0, rtol=0.0, atol=0.1)
    assert np.abs(difference[-1]) < 1e-8


def test_axes_of_the_ellipsoid_are_orthogonal_and_reached():
    axes = np.array([numbers(line) for line in output('manipulability').splitlines()[2:5]])
    np.testing.assert_allclose(axes[:, 1:4] @ axes[:, 1:4].T, np.eye(3), atol=2e-3)
    np.testing.assert_allclose(axes[:, 4], axes[:, 0], rtol=1e-3)  # by forward dynamics


def test_only_an_exciting_motion_tells_the_base_parameters_apart():
    good, bad = ('random', 'exciting'), ('circle', 'switch', 'lift')
    text = '\n'.join(output('base_parameters').splitlines()[15:])
    assert table(text, good).max() < 10.0
    assert table(text, bad).min() > 1e4
