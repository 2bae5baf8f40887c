"""The commands that record the fake Baxter: the bag, the report, refusals, and Table V."""

import csv
import json

from baxter_dynamics_ros.model.joints import joint_names
from calibration.known_robot import Recording
import numpy as np
import pytest

for module in ('mujoco', 'pinocchio', 'matplotlib', 'jinja2', 'rosbags', 'rich'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')

from baxter_dynamics_ros.cli import calibrate, experiment  # noqa: E402, I100
from baxter_dynamics_ros.cli.main import main  # noqa: E402
from baxter_dynamics_ros.estimation.settings import PredictorSettings  # noqa: E402
from baxter_dynamics_ros.model.paper_tables import TABLE_V  # noqa: E402
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator  # noqa: E402
from baxter_dynamics_ros.simulation.plant import COULOMB  # noqa: E402
from baxter_dynamics_ros.simulation.robot import FakeBaxter, record  # noqa: E402
from baxter_dynamics_ros.simulation.trajectories import PERIODS  # noqa: E402

FLOOR = 0.03  # [N m]; some of the paper's figures are below the noise of the sensors
SUM = 0.1  # [N m]
SETTINGS = PredictorSettings.from_parameters({'effort_model.coulomb': COULOMB})


def test_experiment_records_what_the_fake_baxter_publishes(tmp_path, capsys, read_bag):
    output = tmp_path / 'switch'
    output.mkdir()  # an empty folder is accepted
    command = (f'baxter_dynamics experiment switch -o {output} --rate 50 --duration 2 --arm left '
               '--seed 3')
    assert main(command.split()[1:]) == 0
    ((topic, found),) = read_bag(output / 'bag').items()
    assert topic == '/robot/joint_states'
    robot = FakeBaxter('left', 'switch', seed=3)
    robot.advance(3.0)  # once the trajectory has come up to speed
    expected = list(record(robot, 2.0, 50.0, 3))
    assert sum(len(message.name) == 17 for _, message in found) == 100
    for (received, message), (stamp, names, *fields) in zip(found, expected, strict=True):
        sent = message.header.stamp
        assert (sent.sec * 10 ** 9 + sent.nanosec, tuple(message.name)) == (stamp, names)
        assert received == stamp
        np.testing.assert_array_equal([message.position, message.velocity, message.effort], fields)
    first, *_, last = capsys.readouterr().out.strip().splitlines()
    assert first.startswith('recorded 100 joint states of 2.0 s on /robot/joint_states: ')
    assert first.endswith(f'{output}/bag')
    assert last == f'report: {output}/report/report.html'
    assert sorted(path.name for path in output.iterdir()) == ['bag', 'report']
    report = output / 'report'
    assert command in (report / 'report.html').read_text()
    numbers = json.loads((report / 'summary.json').read_text())
    assert (numbers['arm'], numbers['command']) == ('left', command)
    assert numbers['lagrange_euler']['count'] == numbers['newton_euler']['count'] == 100 - 11


def test_by_default_whole_periods_are_recorded_about_a_minute():
    for trajectory, duration in experiment.DURATIONS.items():
        assert 60.0 < duration < 66.0
        assert (duration - 0.3) / PERIODS[trajectory] % 1.0 == pytest.approx(0.0, abs=1e-9)


def test_plan_is_written_and_tried_on_the_fake_baxter(tmp_path, capsys, monkeypatch, read_bag):
    monkeypatch.setattr(calibrate, '_REST', -55.0)  # the first 5 s are enough
    output = tmp_path / 'plan'
    assert main(['calibrate', '--plan', '-o', str(output), '--arm', 'left']) == 0
    assert sorted(path.name for path in output.iterdir()) == ['bag', 'plan.csv', 'trajectory.json']
    with open(output / 'plan.csv') as file:
        table = list(csv.DictReader(file))
    found = [(received, dict(zip(message.name, message.position))) for received, message in
             read_bag(output / 'bag')['/robot/joint_states'] if len(message.name) == 17]
    assert len(found) == 500
    time = np.array([received - 10 ** 18 for received, _ in found]) * 1e-9
    for i, name in enumerate(joint_names('left')):
        planned = np.interp(time, [float(line['time']) for line in table],
                            [float(line[name]) for line in table])
        actual = np.array([position[name] for _, position in found])
        assert np.abs(actual - planned).max() < 0.2  # the controller's lag
        assert np.ptp(actual) > 0.3
    printed = capsys.readouterr().out
    assert all(name in printed for name in joint_names('left'))
    assert f'{output}/plan.csv' in printed


@pytest.mark.parametrize('number, trajectory', list(enumerate(['circle', 'switch', 'lift'])))
def test_signed_means_are_no_greater_than_those_of_table_five(number, trajectory):
    # The predictor knows the fake arm's friction, which is not part of the paper's model. It would
    # cancel over a period, were no joint slower in one direction than in the other.
    robot = FakeBaxter('right', trajectory)
    robot.advance(experiment.START_UP)
    duration = (3 if trajectory == 'switch' else 1) * PERIODS[trajectory]
    found = Evaluator(SETTINGS).evaluate(Recording(trajectory, 'right', [
        (*state, state[0]) for state in record(robot, 0.3 + duration, 100.0)]))
    paper = np.array(TABLE_V['lagrange_euler'][number])
    errors = found.methods['lagrange_euler']
    assert errors.count > 1000 and not found.notices
    assert (np.abs(errors.signed_mean) <= np.maximum(paper, FLOOR)).all()
    assert np.abs(errors.signed_mean.sum()) <= SUM
    recursive = found.methods['newton_euler']
    for ours, theirs in zip(errors, recursive):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)
