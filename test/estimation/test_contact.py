"""Contact detector: begin and end of contact, and thresholds learned from free motion."""

from baxter_dynamics_ros.estimation.contact import ContactDetector
from baxter_dynamics_ros.estimation.settings import ContactSettings
import numpy as np
import pytest

PERIOD = 0.01  # [s]
FLOOR, LIMIT = np.array(ContactSettings.floor), np.array(ContactSettings.limit)
SETTLING = np.log(100.0) / 10.0  # of the observer [s]
REST = np.array([0.7, -0.1, 0.6, -0.5, 0.05, -0.3, 0.2])  # in free motion, without noise [N m]
ONE = np.eye(7)
HOME = np.zeros(7)  # [rad]


def new_detector(**settings):
    """Return a detector that has learned nothing."""
    return ContactDetector(ContactSettings(**settings), SETTLING)


def play(detector, rows, period=PERIOD, speed=0.0):
    """Return whether there is contact after each of the rows (n, 7); speed in rad/s."""
    return np.array([detector.update(period, row, np.full(7, speed * period * k))
                     for k, row in enumerate(rows)])


def still(seconds, value=REST, period=PERIOD):
    """Return equal rows (n, 7)."""
    return np.tile(value, (round(seconds / period), 1))


@pytest.fixture
def detector():
    """Return a detector after long rest: thresholds are at their floors."""
    detector = new_detector()
    assert not play(detector, still(2.0)).any()
    assert not play(detector, still(300.0, period=0.5), 0.5).any()
    np.testing.assert_allclose(detector.bias, REST, atol=1e-9)
    np.testing.assert_array_equal(detector.threshold, FLOOR)
    return detector


def test_threshold_is_the_larger_of_floor_and_k_sigma(rng):
    sd = np.array([0.1, 1.0, 0.1, 0.5, 0.01, 0.3, 0.02])
    detector = new_detector(sigmas=4.0)
    play(detector, REST + rng.uniform(-1.7, 1.7, (12000, 7)) * sd)
    np.testing.assert_allclose(detector.sigma, sd, rtol=0.15)
    np.testing.assert_allclose(detector.threshold, np.maximum(FLOOR, 4.0 * detector.sigma))
    assert (detector.threshold > FLOOR).tolist() == [False, True, False, True, False, True, False]
    np.testing.assert_allclose(detector.bias, REST, atol=0.7)


@pytest.mark.parametrize('joint', range(7))
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_push_on_a_joint_is_contact_of_that_joint(detector, joint, sign):
    push = sign * 1.1 * FLOOR[joint] * ONE[joint]
    assert not play(detector, [REST + 0.9 * push] * 100).any()
    detector.bias = REST
    assert play(detector, [REST + push] * 2).tolist() == [False, True]
    assert detector.joints.tolist() == (ONE[joint] == 1.0).tolist()


def test_one_sample_is_contact_only_if_far_above_the_threshold(detector):
    for _ in range(5):
        assert not play(detector, [REST + 1.2 * FLOOR, REST]).any()
    assert detector.update(PERIOD, REST + 1.3 * FLOOR, HOME)


def test_required_number_of_samples(detector):
    detector.configure(ContactSettings(samples=5, floor=0.2 * FLOOR))
    assert play(detector, [REST + 0.9 * FLOOR] * 6).tolist() == [False] * 4 + [True] * 2


def test_consecutive_samples_must_be_of_one_joint(detector):
    rows = [REST + 1.2 * FLOOR * ONE[k % 2] for k in range(20)]
    assert not play(detector, rows).any()


@pytest.mark.parametrize('size', [1.1, 2.0])
def test_close_samples_must_span_eight_milliseconds(detector, size):
    rows = [REST + size * FLOOR] * 20
    assert play(detector, rows, 0.001).tolist() == [False] * 8 + [True] * 12


@pytest.mark.parametrize('rate', [38.0, 100.0, 1000.0])
def test_push_is_found_equally_fast_at_any_rate(rate):
    period, detector = 1.0 / rate, new_detector()
    play(detector, still(3.0, period=period), period)
    t = period * np.arange(round(0.5 / period))[:, None]
    push = 4.0 * FLOOR * (1.0 - np.exp(-10.0 * t))  # over the threshold after 29 ms
    found = t[np.argmax(play(detector, REST + push, period)), 0]
    assert 0.029 < found <= 0.029 + 2.5 * max(period, 0.008)


def test_contact_lasts_until_all_joints_are_back(detector):
    assert play(detector, [REST + 1.5 * FLOOR] * 10)[-1]
    assert play(detector, [REST + 0.75 * FLOOR] * 10).all()  # within the hysteresis
    assert play(detector, [REST + FLOOR * np.where(ONE[2], 0.8, 0.6)] * 10).all()
    assert detector.joints.tolist() == (ONE[2] == 1.0).tolist()
    assert play(detector, [REST + 0.6 * FLOOR] * 6).tolist() == [True] * 4 + [False] * 2
    assert not detector.joints.any()


def test_nothing_is_learned_during_contact_or_suspected_contact(detector, rng):
    before = detector.bias, detector.sigma, detector.threshold
    rows = [REST + 1.1 * FLOOR * ONE[1], *(REST + 1.5 * FLOOR * rng.uniform(1.0, 1.3, (100, 7)))]
    for row in rows:
        detector.update(PERIOD, row, HOME)
        np.testing.assert_array_equal((detector.bias, detector.sigma, detector.threshold), before)
    assert detector.in_contact


def test_pushes_hardly_change_what_was_learned(detector):
    before = detector.sigma
    shape = np.concatenate([1.0 - np.exp(-np.arange(0.0, 0.8, PERIOD) / 0.1),
                            np.exp(-np.arange(0.0, 1.2, PERIOD) / 0.1)])
    for _ in range(10):
        found = play(detector, REST + np.multiply.outer(shape, 3.0 * FLOOR))
        assert found.any() and not found[-1]
    assert (detector.sigma - before < 0.1 * FLOOR).all()
    np.testing.assert_array_equal(detector.threshold, FLOOR)


def test_bias_follows_free_motion_more_slowly_near_the_threshold(detector):
    time = {}
    for part in (0.1, 0.6, 0.9):
        moved, k = REST + part * FLOOR, 0
        while (moved - detector.bias > 0.5 * part * FLOOR).any():
            assert not detector.update(PERIOD, moved, HOME)
            k += 1
        time[part] = k * PERIOD
        play(detector, still(3.0))
    assert time[0.1] == pytest.approx(0.15 * np.log(2.0), abs=0.015)
    assert time[0.1] < 0.9 * time[0.6] < 0.7 * time[0.9]


def test_slow_push_is_found_once_it_exceeds_the_largest_model_error(detector):
    t = np.arange(0.0, 30.0, PERIOD)[:, None]
    push = 2.0 * LIMIT * ONE[3] * t / 30.0
    first = np.argmax(play(detector, push))
    assert LIMIT[3] < push[first, 3] < LIMIT[3] + 1.1 * FLOOR[3]


def test_contact_within_the_limit_is_dropped_and_learned_if_the_arm_moves(detector):
    step = 0.8 * LIMIT * ONE[1]
    found = play(detector, still(6.0, REST + step), speed=0.1)
    assert 1.5 < PERIOD * np.count_nonzero(found) < 3.0
    assert not found[-100:].any()
    np.testing.assert_allclose(detector.bias, REST + step, atol=1e-6)
    assert detector.threshold[1] > 0.7 * LIMIT[1]
    assert not play(detector, still(3.0, REST + 0.15 * step)).any()  # an error of that size
    assert (detector.threshold <= LIMIT).all()


def test_push_within_the_limit_on_a_resting_arm_is_found_again(detector):
    step = 0.8 * LIMIT * ONE[1]
    assert not play(detector, still(6.0, REST + step))[-1]  # given up
    np.testing.assert_array_equal(detector.threshold, FLOOR)
    play(detector, still(5.0))
    assert play(detector, still(0.1, REST + step)).any()


def test_contact_beyond_the_limit_lasts(detector):
    found = play(detector, still(20.0, REST + 1.5 * LIMIT * ONE[1]))
    assert found[1:].all()
    assert not play(detector, still(1.0))[-1]
    np.testing.assert_array_equal(detector.threshold, FLOOR)


def test_no_contact_and_no_learning_while_the_observer_settles():
    detector, t = new_detector(), np.arange(0.0, SETTLING - 0.02, PERIOD)[:, None]
    assert not play(detector, 3.0 * LIMIT * (1.0 - np.exp(-10.0 * t))).any()
    np.testing.assert_array_equal(detector.bias, 0.0)
    np.testing.assert_allclose(detector.threshold, np.minimum(2.0 * FLOOR, LIMIT))


@pytest.mark.parametrize('scale', [0.3, 1.0])  # of the limit: calibrated or not
def test_contact_from_the_start_beyond_the_limit_is_reported(scale):
    for joint, limit in enumerate(np.maximum(FLOOR, scale * LIMIT)):
        detector = new_detector(limit=scale * LIMIT)
        assert play(detector, still(20.0, 1.1 * limit * ONE[joint]))[-1]


def test_contact_from_the_start_within_the_limit_is_overcome_when_it_ends():
    detector, push = new_detector(), 0.9 * LIMIT * ONE[5]
    assert not play(detector, still(20.0, push)).any()
    after = play(detector, still(6.0, 0.0 * REST))
    assert after.any() and not after[-1]
    np.testing.assert_allclose(detector.bias, 0.0, atol=1e-3)


def test_reset_forgets_everything():
    used, new = new_detector(), new_detector()
    play(used, still(20.0))
    play(used, still(1.0, REST + 2.0 * LIMIT))
    used.reset()
    rows = np.concatenate([still(2.0, 0.5 * REST), still(0.5, 2.0 * LIMIT), still(1.0)])
    for row in rows:
        assert used.update(PERIOD, row, HOME) == new.update(PERIOD, row, HOME)
        for name in ('bias', 'sigma', 'threshold', 'joints'):
            np.testing.assert_array_equal(getattr(used, name), getattr(new, name))


def test_contact_is_unknown_after_a_restart_and_then_continues_or_ends(detector):
    for push in (0.8 * LIMIT, 0.0 * LIMIT):
        assert play(detector, still(0.5, REST + 0.8 * LIMIT))[-1]
        detector.restart()
        play(detector, still(SETTLING - 0.02, REST + push))
        assert detector.is_settling
        found = play(detector, still(0.1, REST + push))
        assert not detector.is_settling
        assert found[-1] == (push > 0.0).any()


def test_contact_is_unknown_until_the_first_samples_after_settling_are_decided():
    detector, period = new_detector(), 0.002
    for row in still(1.0, 2.0 * LIMIT, period):
        assert detector.update(period, row, HOME) or detector.is_settling
    assert not detector.is_settling


def test_a_changed_model_shifts_the_bias_only_in_free_motion(detector):
    detector.rebase(0.5 * FLOOR)
    np.testing.assert_allclose(detector.bias, REST + 0.5 * FLOOR)
    assert not play(detector, still(0.5, REST + 0.5 * FLOOR)).any()
    assert play(detector, still(0.5, REST + 3.0 * LIMIT))[-1]  # a load, added to the model next
    detector.rebase(-3.0 * LIMIT)
    np.testing.assert_allclose(detector.bias, REST + 0.5 * FLOOR)
    assert not play(detector, still(0.1, REST + 0.5 * FLOOR))[-1]


def test_a_dt_of_zero_changes_nothing(detector):
    for row in (REST + 0.5 * FLOOR, REST + 2.0 * FLOOR):
        before = detector.in_contact, detector.bias.tolist(), detector.threshold.tolist()
        for _ in range(5):
            detector.update(0.0, row, HOME)
        assert before == (detector.in_contact, detector.bias.tolist(), detector.threshold.tolist())
    fresh = ContactDetector(ContactSettings(), 0.0)
    assert not fresh.update(0.0, REST, HOME)
    assert not play(fresh, still(1.0)).any()
