"""What pushes the arm: its sign beside the residual's, and what changes in mid-stream."""

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


def trajectory(t: np.ndarray) -> tuple:
    """Return q, qd, qdd (n, 7) at times t (n,) in s: gentler than the perfect robot's own."""
    amplitude = np.array([0.4, 0.3, 0.4, 0.4, 0.5, 0.5, 0.5])  # [rad]
    w = 2 * np.pi * np.array([0.3, 0.25, 0.35, 0.3, 0.4, 0.45, 0.5])  # [rad/s]
    angle = w * np.asarray(t)[:, None] + np.arange(7)
    centre = np.array([0.0, -0.5, 0.0, 1.2, 0.0, 0.6, 0.0])
    return (centre + amplitude * np.sin(angle), amplitude * w * np.cos(angle),
            -amplitude * w ** 2 * np.sin(angle))


def measured(settings, seconds=4.0, period=0.01, external=None, velocity=True) -> list:
    """Return stamp, position, velocity, effort of a perfect robot that is pushed from 1 s on."""
    t = np.arange(0.0, seconds, period)
    q, late, effort = perfect_robot.measured(settings, t, trajectory)
    if external is not None:  # the motors supply the less
        effort[t >= 1.0] -= external
    stamps = [START + round(x * 1e9) for x in t]
    return list(zip(stamps, q, late if velocity else [np.empty(0)] * len(t), effort))


def play(predictor, messages) -> tuple:
    """Return, for each message, the residual and the External, or None."""
    residuals, externals = [], []
    for stamp, *arrays in messages:
        prediction = predictor.handle(stamp, RIGHT, *arrays)
        residuals.append(None if prediction is None else prediction.residual)
        externals.append(predictor.external.latest)
    return residuals, externals


def efforts(externals) -> np.ndarray:
    return np.array([external.effort for external in externals])


def test_a_push_is_external_effort_and_its_negative_is_residual():
    settings = PredictorSettings()
    residuals, externals = play(
        settings.predictor(external=True), measured(settings, external=PUSH))
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.05)
    np.testing.assert_allclose(residuals[-1], -PUSH, atol=0.05)
    contact = [external is not None and external.contact for external in externals]
    assert not any(contact[:100]) and all(contact[115:])


def test_it_follows_a_push_in_the_time_of_the_gain():
    settings = PredictorSettings({'external_effort.gain': 4.0})
    _, externals = play(settings.predictor(external=True), measured(settings, 2.0, 0.002, PUSH))
    stamps = np.array([external.stamp_ns for external in externals if external])
    r = efforts(filter(None, externals))
    since = (stamps - START) * 1e-9 - 1.0
    after = since > 0.0
    expected = np.outer(1 - np.exp(-4.0 * since[after]), PUSH)
    assert np.abs(r[after] - expected).max() < 0.01 * np.abs(PUSH).max()


def test_its_stamp_is_as_much_earlier_as_the_velocity_lags():
    settings = PredictorSettings()
    messages = measured(settings, 1.0)
    _, externals = play(settings.predictor(external=True), messages)
    assert externals[0] is externals[1] is None  # nothing is known of 14 ms before the first
    for message, external in zip(messages[2:], externals[2:]):
        assert external.stamp_ns == message[0] - 14 * MS
    then = trajectory([(externals[-1].stamp_ns - START) * 1e-9])
    np.testing.assert_allclose(externals[-1].q, then[0][0], atol=1e-3)
    np.testing.assert_allclose(externals[-1].qd, then[1][0], atol=1e-12)


def test_what_the_effort_model_has_is_no_external_effort():
    settings = PredictorSettings({
        'effort_model.coulomb': [0.5] * 7, 'effort_model.coulomb_velocity': 0.3,
        'effort_model.viscous': [0.2] * 7, 'effort_model.bias': [1.0, -2.0, 0.5, 0.3, 0, 0, 0],
        'effort_model.stiffness': [0.3] * 7, 'effort_model.added_inertia': [0.4] * 7, **LOAD,
        'base.roll': 0.1, 'base.pitch': -0.2})
    _, externals = play(settings.predictor(external=True), measured(settings))
    assert np.abs(efforts(externals[-300:])).max() < 0.15
    told_nothing = PredictorSettings().predictor(external=True)
    _, externals = play(told_nothing, measured(settings))
    assert np.abs(efforts(externals[-300:])).max() > 2.0


def test_wrench_of_a_push_at_the_hand():
    settings = PredictorSettings()
    wrench = np.array([5.0, -8.0, 3.0, 0.4, -0.3, 0.6])  # [N], [N m]
    t = np.arange(0.0, 3.0, 0.01)
    external = settings.arm.jacobian(trajectory(t)[0]).swapaxes(-1, -2) @ wrench
    messages = measured(settings, 3.0)
    messages = [(stamp, q, qd, effort - push)
                for (stamp, q, qd, effort), push in zip(messages, external)]
    predictor = settings.predictor(external=True)
    _, externals = play(predictor, messages)
    found = predictor.external.wrench(externals[-1])
    np.testing.assert_allclose(np.concatenate([found.force, found.torque]), wrench, atol=0.7)


def test_a_new_payload_steps_the_residual_by_its_own_torque_and_no_more():
    empty, after = PredictorSettings(), PredictorSettings(LOAD)
    messages = measured(after)
    predictor, fresh = (settings.predictor(external=True) for settings in (empty, after))
    first, externals = play(predictor, messages[:200])
    after.configure(predictor, empty)
    then, externals_then = play(predictor, messages[200:])
    expected, externals_expected = play(fresh, messages)
    # With the new payload from the next message on, and no settling in between.
    np.testing.assert_array_equal(then, expected[200:])
    assert np.abs(np.array(first[-1]) - expected[199]).max() > 2.0
    # External effort goes on from where it was, to where it would be, as the gain has it.
    error = efforts(externals_then) - efforts(externals_expected[200:])
    before = externals[-1].effort - externals_expected[199].effort
    n = np.arange(1, 201)[:, None]
    np.testing.assert_allclose(error, before * (1 + 10.0 * 0.01) ** -n, atol=1e-9)


def test_a_new_model_is_learnt_anew_and_another_gain_too():
    settings = PredictorSettings()
    for change in (LOAD, {'base.roll': 0.1}, {'effort_model.bias': [0.5] * 7},
                   {'external_effort.gain': 5.0}, {'contact.sigmas': 4.0}):
        predictor = settings.predictor(external=True)
        start = predictor.external.detector.sigma
        play(predictor, measured(settings))
        learnt = predictor.external.detector.sigma
        assert np.abs(learnt - start).min() > 0.0
        PredictorSettings(change).configure(predictor, settings)
        assert (predictor.external.detector.sigma != learnt).all()
        assert not predictor.external.detector.in_contact


def test_filter_settings_keep_what_was_learnt_and_a_reset_forgets_it():
    settings = PredictorSettings()
    predictor = settings.predictor(external=True)
    start = predictor.external.detector.sigma
    play(predictor, measured(settings))
    learnt = predictor.external.detector.sigma
    PredictorSettings({'acceleration.cutoff': 4.0}).configure(predictor, settings)
    np.testing.assert_array_equal(predictor.external.detector.sigma, learnt)
    predictor.reset()
    np.testing.assert_array_equal(predictor.external.detector.sigma, start)


def test_without_effort_there_is_none_and_then_it_begins_anew():
    settings = PredictorSettings()
    messages = measured(settings, external=PUSH)
    for i in range(200, 250):
        messages[i] = (*messages[i][:3], np.empty(0))
    _, externals = play(settings.predictor(external=True), messages)
    assert externals[199] and not any(externals[202:250])
    again = next(external for external in externals[250:] if external)
    np.testing.assert_array_equal(again.effort, 0.0)
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.05)


def test_without_velocity_it_uses_the_slope_of_the_positions():
    settings = PredictorSettings()
    _, externals = play(
        settings.predictor(external=True), measured(settings, external=PUSH, velocity=False))
    np.testing.assert_allclose(externals[-1].effort, PUSH, atol=0.1)


def test_messages_that_are_dropped_give_none():
    settings = PredictorSettings()
    predictor = settings.predictor(external=True)
    messages = measured(settings, 1.0)
    play(predictor, messages)
    assert predictor.external.latest is not None
    predictor.handle(messages[-1][0], joint_names('left'), *messages[-1][1:])
    assert predictor.external.latest is None
    assert predictor.counts['external'] == len(messages) - 2


def test_it_is_not_asked_for_unless_wanted():
    predictor = PredictorSettings().predictor()
    assert predictor.external is None
    assert 'external' not in predictor.counts


def test_settings_of_contact_leave_external_effort_as_it_is():
    settings = PredictorSettings()
    messages = measured(settings, external=PUSH)
    changed, left_alone = (settings.predictor(external=True) for _ in range(2))
    play(changed, messages[:250])
    PredictorSettings({'contact.hysteresis': 0.6}).configure(changed, settings)
    _, externals = play(changed, messages[250:])
    _, expected = play(left_alone, messages)
    np.testing.assert_array_equal(efforts(externals), efforts(expected[250:]))


def test_friction_with_a_memory_begins_anew_when_it_is_switched_on_again():
    with_, without = PredictorSettings({'effort_model.dahl': [3.0] * 7}), PredictorSettings()
    messages = measured(with_, 3.0)
    predictor = with_.predictor(external=True)
    play(predictor, messages[:100])
    without.configure(predictor, with_)
    play(predictor, messages[100:200])
    with_.configure(predictor, without)
    np.testing.assert_array_equal(predictor.presliding, 0.0)
    play(predictor, messages[200:201])
    np.testing.assert_array_equal(predictor.presliding, 0.0)  # nothing is known of before
