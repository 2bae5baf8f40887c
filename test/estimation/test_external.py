"""External torque and contact: sign, time, interruptions, and settings changed in mid-stream."""

from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.external import contact_settings
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import perfect_robot
import pytest

MS = 1_000_000  # [ns]
START = 10 ** 18  # [ns]
RIGHT = joint_names('right')
PUSH = np.array([6.0, -9.0, 3.0, 4.5, -1.5, 1.2, 0.6])  # [N m]
LOAD = {'payload.mass': 1.5, 'payload.center_of_mass': (0.02, -0.01, 0.1),
        'payload.inertia': (3e-3, 2e-3, 2.5e-3, 0.0, 0.0, 0.0)}

pytestmark = pytest.mark.filterwarnings('error')


def measured(settings, seconds=4.0, period=0.01, external=None, velocity=True) -> list:
    """Return stamp, position, velocity, effort of a perfect robot that is pushed from 1 s on."""
    t = np.arange(0.0, seconds, period)
    q, late, effort = perfect_robot.measured(settings, t)
    if external is not None:  # the motors supply less
        effort[t >= 1.0] -= settings.model.effort_model.coupled(external)
    stamps = [START + round(x * 1e9) for x in t]
    return list(zip(stamps, q, late if velocity else [np.empty(0)] * len(t), effort))


def play(predictor, messages) -> tuple:
    """Return, for each message, the residual and the External, or None."""
    residuals, externals = [], []
    for stamp, *arrays in messages:
        step = predictor.handle(stamp, RIGHT, *arrays)
        residuals.append(None if step.prediction is None else step.prediction.residual)
        externals.append(step.external)
    return residuals, externals


def efforts(externals) -> np.ndarray:
    return np.array([external.effort for external in externals])


def test_a_push_is_external_effort_and_its_negative_is_residual():
    settings = PredictorSettings()
    residuals, externals = play(
        Predictor(settings, external=True), measured(settings, external=PUSH))
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.05)
    expected = settings.model.effort_model.coupled(-PUSH)
    np.testing.assert_allclose(residuals[-1], expected, atol=0.05)
    contact = [external is not None and external.contact for external in externals]
    assert not any(contact[:100]) and all(contact[115:])
    assert externals[-1].joints[:4].all() and not externals[99].joints.any()


def test_stamp_is_earlier_by_the_lag_of_the_velocity():
    settings = PredictorSettings()
    messages = measured(settings, 1.0)
    _, externals = play(Predictor(settings, external=True), messages)
    assert externals[0] is externals[1] is None  # 14 ms earlier is before the first sample
    for message, external in zip(messages[2:], externals[2:]):
        assert external.stamp_ns == message[0] - 14 * MS
    then = perfect_robot.trajectory([(externals[-1].stamp_ns - START) * 1e-9])
    np.testing.assert_allclose(externals[-1].q, then[0][0], atol=1e-3)
    np.testing.assert_allclose(externals[-1].qd, then[1][0], atol=1e-12)


def test_terms_of_the_effort_model_are_not_external_effort():
    settings = PredictorSettings.from_parameters({
        'effort_model.coulomb': [0.5] * 7, 'effort_model.coulomb_velocity': 0.3,
        'effort_model.viscous': [0.2] * 7, 'effort_model.bias': [1.0, -2.0, 0.5, 0.3, 0, 0, 0],
        'effort_model.stiffness': [0.3] * 7, 'effort_model.added_inertia': [0.4] * 7, **LOAD,
        'base.roll': 0.1, 'base.pitch': -0.2})
    _, externals = play(Predictor(settings, external=True), measured(settings))
    assert np.abs(efforts(externals[-300:])).max() < 0.15
    _, externals = play(Predictor(PredictorSettings(), external=True), measured(settings))
    assert np.abs(efforts(externals[-300:])).max() > 2.0


def test_a_new_payload_steps_the_residual_by_its_torque_only():
    empty, after = PredictorSettings(), PredictorSettings.from_parameters(LOAD)
    messages = measured(after)
    predictor, fresh = (Predictor(settings, external=True) for settings in (empty, after))
    first, externals = play(predictor, messages[:200])
    predictor.configure(after)
    then, externals_then = play(predictor, messages[200:])
    expected, externals_expected = play(fresh, messages)
    # With the new payload from the next message on, and no settling in between.
    np.testing.assert_array_equal(then, expected[200:])
    assert np.abs(np.array(first[-1]) - expected[199]).max() > 2.0
    # So does external effort, except for the inertial torque of the payload, which fades.
    error = np.abs(efforts(externals_then) - efforts(externals_expected[200:])).max(axis=1)
    before = np.abs(externals[-1].effort - externals_expected[199].effort).max()
    assert error[0] < 0.25 * before and (error[150:] < 1e-4).all()


@pytest.mark.parametrize('change', [
    {'payload.mass': 0.2}, {'base.roll': 0.05}, {'effort_model.bias': [0.5] * 7},
    {'external_effort.gain': 5.0}, {'contact.sigmas': 4.0}, {'acceleration.cutoff': 4.0},
    {'acceleration.velocity_lag': 0.03}],
    ids=str)
def test_a_changed_setting_keeps_the_learned_thresholds(change):
    settings, new = PredictorSettings(), PredictorSettings.from_parameters(change)
    messages, predictor = measured(settings), Predictor(settings, external=True)
    play(predictor, messages[:200])
    learned = predictor.external.detector.sigma
    predictor.configure(new)
    np.testing.assert_array_equal(predictor.external.detector.sigma, learned)
    _, externals = play(predictor, messages[200:])
    assert not any(external is not None and external.contact for external in externals[:50])
    predictor.reset()
    assert np.abs(predictor.external.detector.sigma - learned).min() > 0.0


def stray(message, others=False):
    """Return a copy of a message that is 0.6 s old, or one of another publisher."""
    stamp, q, qd, effort = message
    return (stamp, q + 0.7, 0.0 * qd, effort) if others else (stamp - 600 * MS, q, qd, effort)


INTERRUPTIONS = {
    'gap of 0.27 s': (lambda messages: messages[27:], None, 50),
    'stray message 0.6 s old': (lambda messages: [stray(messages[0]), *messages[1:]], None, 1),
    'message from another publisher': (
        lambda messages: [stray(messages[0], True), *messages[1:]], None, 1),
    'position alone from another publisher': (
        lambda messages: [(*messages[0][:2], np.empty(0), np.empty(0)), *messages[1:]], None, 1),
    'missing effort': (lambda messages: [(*messages[0][:3], np.empty(0)), *messages[1:]], None, 3),
    'reset': (None, {}, 50),
    **{f'{name} -> {value}': (None, {name: value}, 0) for name, value in {
        'payload.mass': 0.01, 'acceleration.cutoff': 6.0, 'contact.memory': 31.0,
        'external_effort.gain': 12.0}.items()}}


@pytest.mark.parametrize('name', INTERRUPTIONS)
def test_a_lasting_push_remains_contact_after_an_interruption(name):
    change_messages, change_settings, unknown = INTERRUPTIONS[name]
    settings = PredictorSettings()
    messages = measured(settings, external=3.0 * PUSH)
    predictor = Predictor(settings, external=True)
    _, before = play(predictor, messages[:200])
    assert before[-1].contact
    if change_settings:
        predictor.configure(PredictorSettings.from_parameters(change_settings))
    elif change_settings is not None:
        predictor.reset()
    _, externals = play(predictor, (change_messages or list)(messages[200:]))
    contact = [None if external is None else external.contact for external in externals]
    assert False not in contact
    assert contact.count(None) <= unknown and None not in contact[60:]


def test_a_stray_message_every_0_4_s_does_not_disturb_contact():
    settings = PredictorSettings()
    jacobian = settings.model.arm.jacobian(perfect_robot.trajectory(np.arange(1.0, 4.0, 0.01))[0])
    predictor = Predictor(settings, external=True)
    for k, message in enumerate(measured(settings, external=60.0 * jacobian[:, 1])):  # 60 N
        if k % 40 == 39:
            assert play(predictor, [stray(message, others=k % 80 == 39)])[1] == [None]
            assert predictor.counts[Event.UNCONFIRMED] == (k + 1) // 40
        _, (external,) = play(predictor, [message])
        assert k < 115 or external.contact


@pytest.mark.parametrize('rate', [10.0, 5.0])
def test_no_contact_is_reported_at_a_rate_too_low_for_it(rate):
    settings = PredictorSettings()
    predictor = Predictor(settings, external=True)
    _, externals = play(predictor, measured(settings, 10.0, 1.0 / rate, 3.0 * PUSH))
    externals = [external for external in externals if external is not None]
    assert len(externals) > 40 and not any(external.contact for external in externals)
    assert all(external.contact is None for external in externals)
    assert predictor.external.is_too_slow


def test_no_external_torque_without_effort_and_a_restart_after_it():
    settings = PredictorSettings()
    messages = measured(settings, external=PUSH)
    for i in range(200, 250):
        messages[i] = (*messages[i][:3], np.empty(0))
    _, externals = play(Predictor(settings, external=True), messages)
    assert externals[199] and not any(externals[202:250])
    again = next(external for external in externals[250:] if external)
    np.testing.assert_array_equal(again.effort, 0.0)
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.05)


def test_without_velocity_it_uses_the_slope_of_the_positions():
    settings = PredictorSettings()
    _, externals = play(
        Predictor(settings, external=True), measured(settings, external=PUSH, velocity=False))
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.1)


def test_dahl_friction_restarts_when_it_is_enabled_again():
    without = PredictorSettings()
    with_ = without.replace({'effort_model.dahl': [3.0] * 7})
    messages = measured(with_, 3.0)
    predictor = Predictor(with_, external=True)
    play(predictor, messages[:100])
    predictor.configure(without)
    play(predictor, messages[100:200])
    predictor.configure(with_)
    stamp, *arrays = messages[200]
    step = predictor.handle(stamp, RIGHT, *arrays)
    np.testing.assert_array_equal(step.estimate.presliding, 0.0)  # forgotten


def test_expected_deviation_bounds_the_model_errors_of_contact():
    default = PredictorSettings()
    assert contact_settings(default).limit == default.contact.limit  # an uncalibrated robot
    calibrated = default.replace({'effort_model.deviation': (0.3, 0.4, 0.4, 0.3, 0.1, 0.1, 0.1),
                                  'effort_model.deviation_velocity': (0.0,) * 7,
                                  'effort_model.deviation_acceleration': (0.0,) * 7})
    np.testing.assert_allclose(contact_settings(calibrated).limit,
                               [2.5, 1.4, 1.4, 1.05, 0.35, 0.4, 0.35])  # floor, or 3.5 deviations
    predictor = Predictor(default, external=True)
    predictor.configure(calibrated)
    assert predictor.external.detector.settings == contact_settings(calibrated)
    simulated = default.replace({'effort_model.enabled': False})  # nothing is known
    assert contact_settings(simulated).limit == default.contact.limit
