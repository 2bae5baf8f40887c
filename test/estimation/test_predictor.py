"""Predictor: residual of known motion, missing fields, and changes of settings."""

from baxter_dynamics_ros.estimation.events import Event, RESETS
from baxter_dynamics_ros.estimation.predictor import Predictor, Step
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import joint_names, rms
import numpy as np
import perfect_robot
import pytest

MS = 1_000_000  # [ns]
START = 1_700_000_000_000_000_000  # [ns]
DELAY = 59_015_816  # 0.014 s + sqrt(2) / (2 pi 5 Hz) [ns]
RIGHT = joint_names('right')
EMPTY = np.empty(0)
CALIBRATED = {'effort_model.coulomb': [0.5] * 7, 'effort_model.coulomb_velocity': 0.3,
              'effort_model.viscous': [0.2] * 7, 'payload.mass': 0.7,
              'effort_model.bias': [1.0, -2.0, 0.5, 0.3, 0.1, -0.1, 0.05]}

pytestmark = pytest.mark.filterwarnings('error')


def measured(settings: PredictorSettings, n: int = 300, extra: float = 0.0) -> list:
    """Return stamp, position, velocity and effort of n messages of a perfect robot at 100 Hz."""
    q, qd, effort = perfect_robot.measured(settings, np.arange(n) * 0.01)
    stamps = [START + 10 * MS * i for i in range(n)]
    return list(zip(stamps, q, qd, effort + extra))


def play(predictor, messages, names=RIGHT) -> list:
    """Return the prediction of each message, or None."""
    return [predictor.handle(stamp, names, *arrays).prediction for stamp, *arrays in messages]


@pytest.mark.parametrize('values', [{}, CALIBRATED, {'effort_model.enabled': False}],
                         ids=['default', 'calibrated', 'rigid'])
def test_a_perfect_robot_has_no_residual(values):
    settings = PredictorSettings.from_parameters(values)
    messages = measured(settings)
    residuals = [p.residual for p in play(Predictor(settings), messages) if p is not None]
    assert np.std([message[3] for message in messages], axis=0)[:4].min() > 0.3  # there is effort
    assert (rms(residuals) < 0.02).all()


@pytest.mark.parametrize('extra', [1.0, -1.0])
def test_residual_is_measured_minus_predicted(extra):
    settings = PredictorSettings()
    predictions = play(Predictor(settings), measured(settings, extra=extra))
    np.testing.assert_allclose(predictions[-1].residual, extra, atol=0.05)


def test_fields_of_a_prediction_are_consistent():
    settings = PredictorSettings.from_parameters({
        **CALIBRATED, 'effort_band': 'raw', 'effort_model.deviation': [0.3] * 7,
        'effort_model.deviation_velocity': [0.2] * 7,
        'effort_model.deviation_acceleration': [0.1] * 7})
    messages = measured(settings)
    prediction = play(Predictor(settings), messages)[-1]
    np.testing.assert_allclose(prediction.tau, settings.model.arm.inverse_dynamics(
        prediction.q, prediction.qd, prediction.qdd), rtol=1e-12)
    np.testing.assert_allclose(prediction.effort, settings.model.effort_model.effort(
        prediction.tau, prediction.q, prediction.qd, prediction.qdd), rtol=1e-12)
    t = np.array([(stamp - START) * 1e-9 for stamp, *_ in messages])
    then = (prediction.stamp_ns - START) * 1e-9
    effort = [np.interp(then, t, joint) for joint in np.array([m[3] for m in messages]).T]
    np.testing.assert_allclose(prediction.residual, effort - prediction.effort, atol=1e-6)
    np.testing.assert_allclose(prediction.deviation, np.sqrt(
        0.09 + (0.2 * prediction.qd) ** 2 + (0.1 * prediction.qdd) ** 2), rtol=1e-12)


@pytest.mark.parametrize('effort, event', [
    (EMPTY, Event.EFFORT_MISSING), (np.zeros(7), Event.EFFORT_ALL_ZERO)], ids=['none', 'zero'])
def test_no_effort_means_no_residual(effort, event):
    settings = PredictorSettings()
    messages = [(stamp, q, qd, effort) for stamp, q, qd, _ in measured(settings, 60)]
    predictor = Predictor(settings)
    predictions = [p for p in play(predictor, messages) if p is not None]
    assert len(predictions) == predictor.counts['predicted'] == 39
    assert all(p.residual is None and np.isfinite(p.effort).all() for p in predictions)
    assert predictor.counts[event] == 60


def test_spring_held_is_counted():
    settings = PredictorSettings.from_parameters({'effort_model.spring_range': [-0.5, 1.0]})
    predictor = Predictor(settings)
    predictions = [p for p in play(predictor, measured(settings)) if p is not None]
    held = sum(p.q[1] < -0.5 for p in predictions)
    assert predictor.counts[Event.SPRING_HELD] == held
    assert 0 < held < len(predictions)
    predictor = Predictor(PredictorSettings())
    play(predictor, measured(settings))
    assert predictor.counts[Event.SPRING_HELD] == 0


def test_a_step_holds_all_results_of_a_message():
    settings = PredictorSettings.from_parameters({'stamps': 'header'})
    predictor = Predictor(settings, external=True)
    for k, (stamp, *arrays) in enumerate(measured(settings, 40)):
        step = predictor.handle(stamp, RIGHT, *arrays)
        assert step.dropped is None and step.begins == (k == 0)
        assert step.state.stamp_ns == stamp
        np.testing.assert_array_equal(step.state.q, arrays[0])
        assert (step.external is None) == (k < 2) and (step.prediction is None) == (k < 21)
    assert step.delay_of(step.estimate) == pytest.approx(DELAY * 1e-9, abs=1e-9)
    assert step.delay_of(step.external) == pytest.approx(0.014, abs=1e-9)
    assert predictor.estimate(stamp + 10 * MS, RIGHT, *arrays).prediction is None
    for after, names, event in ((9, RIGHT, Event.OUT_OF_ORDER),
                                (20, joint_names('left'), Event.NOT_THIS_ARM)):
        assert predictor.handle(stamp + after * MS, names, *arrays) == Step(dropped=event)


def test_handled_arrays_are_not_aliased():
    settings = PredictorSettings()
    messages = measured(settings, 60)
    wanted = play(Predictor(settings), messages)[-1]
    predictor, buffers = Predictor(settings), [np.empty(7) for _ in range(3)]
    for stamp, *arrays in messages:  # a publisher that reuses its arrays
        for buffer, array in zip(buffers, arrays):
            buffer[:] = array
        found = predictor.handle(stamp, RIGHT, *buffers).prediction
        for buffer in buffers:
            buffer[:] = 0.0
    np.testing.assert_array_equal(found.residual, wanted.residual)


def test_results_are_read_only_and_do_not_change():
    settings = PredictorSettings.from_parameters(CALIBRATED)
    predictor, messages = Predictor(settings, external=True), measured(settings, 80)
    for stamp, *fields in messages:
        step = predictor.handle(stamp, RIGHT, *fields)
        if stamp == messages[60][0]:
            arrays = [x for result in step[2:] for x in result if isinstance(x, np.ndarray)]
            copies = [array.copy() for array in arrays]
    assert len(arrays) == 20 and not any(array.flags.writeable for array in arrays)
    for array, copy in zip(arrays, copies):
        np.testing.assert_array_equal(array, copy)


def test_reset_restarts_the_stream_and_keeps_the_counts():
    settings = PredictorSettings()
    messages = measured(settings, 60)
    predictor = Predictor(settings)
    first = play(predictor, messages)
    predictor.reset()
    once = {'received': 60, 'taken': 60, 'predicted': 39, Event.RESET_REQUESTED: 1}
    assert predictor.counts == once
    again = play(predictor, messages)  # the same stamps, which now run back
    assert predictor.counts == once | {'received': 120, 'taken': 120, 'predicted': 78}
    assert [p is None for p in again] == [p is None for p in first]
    np.testing.assert_array_equal(again[-1].residual, first[-1].residual)


@pytest.mark.parametrize('change', [{'acceleration.cutoff': 8.0}, {'align': False},
                                    {'acceleration.velocity_lag': 0.0}], ids=str)
def test_changed_filter_settles_again_and_keeps_the_counts(change):
    before, after = PredictorSettings(), PredictorSettings.from_parameters(change)
    messages = measured(before, 100)
    predictor = Predictor(before)
    play(predictor, messages[:50])
    predictor.configure(after)
    found = play(predictor, messages[50:])
    wanted = play(Predictor(after), messages[50:])
    assert [p is None for p in found] == [p is None for p in wanted]
    assert found[-1].stamp_ns == wanted[-1].stamp_ns
    np.testing.assert_allclose(found[-1].residual, wanted[-1].residual, atol=1e-7)
    assert predictor.counts['taken'] == 100 and not any(predictor.counts[e] for e in RESETS)
