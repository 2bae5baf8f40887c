"""Verdict and advice of an evaluation, for recordings with a known cause of the residual."""

from dataclasses import replace
from pathlib import Path
import re

from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np
import pytest

pytest.importorskip('pinocchio', reason='needs Pinocchio: pip install pin')
from baxter_dynamics_ros.recordings.advice import assess  # noqa: E402, I100
from baxter_dynamics_ros.recordings.data_check import Notice  # noqa: E402
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator  # noqa: E402
from baxter_dynamics_ros.recordings.recording import ArrayRecording  # noqa: E402

REPOSITORY = Path(__file__).parents[2]
FRICTION = {'effort_model.coulomb': [0.5, 0.6, 0.4, 0.3, 0.1, 0.1, 0.1],
            'effort_model.dahl': [0.5, 0.6, 0.4, 0.3, 0.1, 0.1, 0.1]}
EXPECTED = {'effort_model.deviation': [0.3, 0.4, 0.2, 0.2, 0.1, 0.1, 0.1],
            'effort_model.deviation_velocity': [0.0] * 7,
            'effort_model.deviation_acceleration': [0.0] * 7}


@pytest.fixture
def assessed(moving_arm):
    """Return a function that assesses 11 s of an arm whose true settings are given."""
    def run(truth=None, values=None, change=lambda effort: effort, inputs='run --arm right'):
        settings = PredictorSettings.from_parameters(values or {})
        evaluator = Evaluator(settings)
        stamps, (names, *_), q, qd, effort = zip(*(
            content for _, _, content in moving_arm(1100, truth=truth)))
        evaluation = evaluator.evaluate(ArrayRecording(
            'run', 'right', names, np.array(stamps), [q, qd, [*map(change, effort)]]))
        found = assess(evaluator.total(), [evaluation], settings, inputs)
        return found, evaluation, [advice.kind for advice in found.advice]
    return run


def test_small_residuals_need_no_advice(assessed):
    found, evaluation, kinds = assessed(values=EXPECTED)
    assert (found.verdict.kind, kinds) == ('calibrated', [])
    assert (evaluation.expected.coverage > 0.95).all()
    np.testing.assert_allclose(evaluation.expected.deviation, EXPECTED['effort_model.deviation'])


def test_friction_asks_for_a_calibration(assessed):
    found, _, kinds = assessed(FRICTION)
    assert found.verdict.kind == 'uncalibrated' and kinds[-1] == 'calibrate'
    assert 'friction' in found.advice[-1].text
    assert found.advice[-1].command == 'baxter_dynamics calibrate run --arm right -o my_robot.yaml'
    larger, evaluation, _ = assessed(FRICTION, EXPECTED, inputs='run --params my_robot.yaml')
    assert larger.verdict.kind == 'larger' and 's0' in larger.verdict.joints
    assert larger.advice[-1].command.endswith('--params my_robot.yaml -o my_robot_new.yaml')
    assert (evaluation.expected.coverage[:2] < 0.9).all()
    at_rest = replace(evaluation.check, gain=np.full(7, np.nan))
    for useless in replace(evaluation, duration=9.0), replace(evaluation, check=at_rest):
        *_, advice = assess(useless, [useless], PredictorSettings(), 'run').advice
        assert advice.command == 'baxter_dynamics calibrate --plan --arm right'


@pytest.mark.parametrize('truth, kind, text, command', [
    ({'payload.mass': 0.9, 'payload.center_of_mass': [0.0, 0.0, 0.05]}, 'payload',
     '0.9', '--params .*electric_gripper.yaml'),
    ({'effort_model.bias': [0.0, 34.0, 0.0, 0.0, 0.0, 0.0, 0.0]}, 'zero',
     'offset of s1', 'service call /torque_predictor/zero')])
def test_causes_of_a_residual_are_named(assessed, truth, kind, text, command):
    found, _, kinds = assessed(truth)
    advice = found.advice[kinds.index(kind)]
    assert text in advice.text and re.search(command, advice.command), advice
    again = assessed(truth, inputs='run --params electric_gripper.yaml')[0].advice
    assert not [one for one in again if 'electric' in one.text or 'file:' in one.text]


@pytest.mark.parametrize('change, kind', [
    (lambda effort: -effort, 'effort_sign'), (lambda effort: 0.1 * effort, 'effort_scale')])
def test_wrong_data_are_corrected_before_anything_else(assessed, change, kind):
    found, evaluation, kinds = assessed(change=change)
    assert (found.verdict.kind, kinds) == ('wrong_data', [kind])
    assert found.advice[0].text[0].isupper() and found.advice[0].text not in found.verdict.text
    guided = Notice('moved_by_hand', 'moved by hand', refuses=True, remedy='use the motors')
    left = replace(evaluation, arm='left', notices=(guided,))
    (advice,) = assess(left, [left], PredictorSettings(), 'run').advice
    assert advice.command == 'baxter_dynamics calibrate --plan --arm left'


@pytest.mark.parametrize('truth, values, kind, file', [
    ({'effort_model.enabled': False}, {}, 'no_springs', 'simulation.yaml'),
    ({}, {'effort_model.enabled': False}, 'springs', 'right_arm.yaml')])
def test_robots_and_simulators_need_their_own_parameters(assessed, truth, values, kind, file):
    found, _, kinds = assessed(truth, values)
    assert (found.verdict.kind, kinds) == ('wrong_data', [kind])
    assert found.advice[0].command.endswith(f'--params {REPOSITORY}/config/{file}')


def test_no_effort_is_no_verdict_on_the_model(assessed):
    found, evaluation, kinds = assessed(values=EXPECTED, change=lambda effort: 0.0 * effort)
    assert (found.verdict.kind, kinds, evaluation.expected) == ('no_effort', [], None)
