"""The command watch: what is kept of what was heard, and how it is drawn; no ROS is needed."""

import re

from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

pytest.importorskip('rich', reason='needs rich: pip install ".[demo]"')

from baxter_dynamics_ros.cli import watch_words  # noqa: E402, I100
from baxter_dynamics_ros.cli.watch_bars import ASCII, bar, BLOCKS, glyphs, sparkline  # noqa: E402
from baxter_dynamics_ros.cli.watch_data import BIN, Status, Trace, Watched  # noqa: E402
from baxter_dynamics_ros.cli.watch_terminal import save_picture  # noqa: E402
from baxter_dynamics_ros.cli.watch_view import Canvas, STATUSES, view  # noqa: E402

BEHIND = 59_000_000  # [ns]
PREDICTED = np.array([1.0, -20.0, 3.0, -8.0, 0.5, -0.6, 0.07])  # [N m]
RESIDUAL = np.array([0.11, -0.22, 0.33, -0.44, 0.55, -0.66, 0.77])
EFFORTS = {'predicted': PREDICTED, 'residual': RESIDUAL, 'external': -RESIDUAL}


def play(watched, start, seconds, side='right', place='', contact=False, level=0, order=JOINTS,
         leave_out=()):
    """Let everything of one arm come at 100 Hz, and diagnostics once a second; return the end."""
    names = [f'{side}_{joint}' for joint in order]
    pick = [JOINTS.index(joint) for joint in order]
    for k in range(round(seconds * 100)):
        now = start + 0.01 * k
        stamp = round(now * 1e9)
        measured = [] if 'residual' in leave_out else (PREDICTED + RESIDUAL)[pick]
        watched.take_joint_state(names, measured, stamp, now)
        for topic, effort in EFFORTS.items():
            if topic not in leave_out:
                watched.take_effort(place, topic, names, effort[pick], stamp - BEHIND, now)
        watched.take_contact(place, contact, now)
        if k % 100 == 0:
            for name in STATUSES:
                watched.take_status(place, name, Status(level, f'says {name}', {}, now),
                                    f'baxter_{side}_arm')
    return now


def drawn(watched, now, width=80, height=24, glyphs_=BLOCKS, side=None, missing=None):
    """Return the view's lines as plain text; none is longer than the terminal is wide."""
    lines = [line.plain for line in view(
        watched, side, 'title', missing, now, Canvas(width, height, glyphs_))]
    assert max(map(len, lines)) <= width
    assert height is None or len(lines) <= height
    return lines


def row(lines, joint):
    """Return the words of a joint's row."""
    return next(line for line in lines if line.startswith(joint)).split()


@pytest.fixture
def watched():
    """Return what has heard nothing so far."""
    return Watched()


@pytest.mark.parametrize('order', [JOINTS, sorted(JOINTS), JOINTS[::-1]], ids=' '.join)
def test_joints_are_matched_by_name(watched, order):
    now = play(watched, 5.0, 0.1, order=order)
    arm, = watched.shown()
    for ours, expected in zip(arm.instant(), (PREDICTED + RESIDUAL, PREDICTED, RESIDUAL)):
        np.testing.assert_allclose(ours, expected)
    lines = drawn(watched, now)
    for i, joint in enumerate(JOINTS):
        assert row(lines, joint)[1:5] == [f'{value:+.2f}' for value in (
            PREDICTED[i] + RESIDUAL[i], PREDICTED[i], RESIDUAL[i], -RESIDUAL[i])]


def test_measured_and_predicted_are_of_the_residuals_instant(watched):
    names = joint_names('right')
    for stamp in (1, 2):
        watched.take_effort('', 'predicted', names, stamp * PREDICTED, stamp, 5.0)
    watched.take_effort('', 'residual', names, RESIDUAL, 1, 5.0)
    np.testing.assert_allclose(watched.arms[''].instant()[0], PREDICTED + RESIDUAL)


def test_what_is_not_of_the_arm_is_left_alone(watched):
    now = play(watched, 5.0, 2.5)
    watched.take_joint_state(['l_gripper_l_finger_joint'], [1.0], 7, now)
    watched.take_effort('', 'residual', ['right_s0'], [9.0], 7, now)
    assert watched.inputs['right'].stamp_ns == round(now * 1e9)
    assert watched.inputs['left'].heard == -np.inf
    np.testing.assert_allclose(watched.arms[''].residual.values, RESIDUAL)


def test_rates_and_delay_are_told(watched):
    now = play(watched, 5.0, 4.0)
    text = watch_words.rates(watched, watched.shown()[0], now)
    assert text == '100.0 predictions/s, 100.0 joint states/s, residual 59 ms behind, 0.0 s old'


def test_a_rate_fades_when_nothing_comes_and_counts_anew_after_a_pause(watched):
    now = play(watched, 5.0, 4.0)
    series = watched.arms[''].predicted
    assert series.rate(now + 1.0) == pytest.approx(50.0, rel=0.02)
    assert series.rate(now + 2.5) == 0.0
    assert series.rate(play(watched, 20.0, 0.5)) == pytest.approx(100.0)


def test_what_a_day_brings_is_not_kept(watched):
    play(watched, 5.0, 10.0)
    arm = watched.arms['']
    for series in (arm.predicted, arm.residual, arm.external, watched.inputs['right']):
        assert len(series._counts) < 300  # of 1000


@pytest.mark.parametrize('value', [np.inf, -np.inf, np.nan, 1e300])
def test_what_is_no_number_is_drawn_all_the_same(watched, value):
    now = play(watched, 5.0, 0.1)
    for topic in EFFORTS:
        watched.take_effort('', topic, joint_names('right'), np.full(7, value), 7, now)
    assert len(drawn(watched, now, width=120)) > 10


def test_what_is_old_is_marked_and_never_shown_as_live(watched):
    now = play(watched, 5.0, 2.0, contact=True) + 3.2
    lines = drawn(watched, now, height=None)
    assert 'CONTACT' not in ''.join(lines)
    assert any('contact unknown, nothing heard for 3.2 s' in line for line in lines)
    for joint in JOINTS:
        assert all(word.startswith('(') and word.endswith(')') for word in re.findall(
            r'\S*\d\.\d\S*', ' '.join(row(lines, joint)[1:5]).partition('STALE')[0]))
    assert 'STALE: no prediction for 3.2 s' in next(line for line in lines if 's0' in line)
    assert not any(character in ''.join(lines) for character in BLOCKS.levels[:-1])
    statuses = [line for line in lines if 'says' in line]
    assert len(statuses) == 6 and all('OK, 4.2 s ago:' in line for line in statuses)


def test_no_effort_is_said_and_no_zeros_are_shown(watched):
    now = play(watched, 5.0, 2.0, leave_out=('residual', 'external'))
    lines = drawn(watched, now)
    assert any('no measured effort, so no residual' in line for line in lines)
    assert row(lines, 's1')[1:5] == ['-', '-20.00', '-', '-']
    assert 'no measured effort' in watch_words.summary(watched, watched.shown()[0], now)
    watched.take_joint_state(joint_names('left'), np.zeros(7), 1, 5.0)  # no measurement, either
    assert watched.inputs['left'].values is None


def test_effort_that_stops_leaves_no_residual_behind(watched):
    now = play(watched, 5.0, 2.0)
    now = play(watched, now + 0.01, 2.0, leave_out=('residual',))
    lines = drawn(watched, now)
    assert row(lines, 's1')[1:5] == ['-', '-20.00', '-', '+0.22']


def test_contact_is_told_with_its_joints_and_since_when(watched):
    now = play(watched, 5.0, 2.0)
    assert any(' no contact' in line for line in drawn(watched, now))
    began = now + 0.01
    now = play(watched, began, 2.31, contact=True)
    learnt = {f'{joint} {what} [N m]': value for joint in JOINTS
              for what, value in (('bias', '0.0'), ('threshold', '0.6'))}
    watched.take_status('', 'external', Status(0, '', learnt, began - 0.5), 'baxter_right_arm')
    assert any('CONTACT at w1, w2 for 2.3 s' in line for line in drawn(watched, now))
    learnt['joints in contact'] = 's1, e0'  # the node's own word counts, once it has come
    watched.take_status('', 'external', Status(0, '', learnt, now), 'baxter_right_arm')
    banner = next(line for line in drawn(watched, now) if 'CONTACT' in line)
    assert 'CONTACT at s1, e0 for 2.3 s' in banner and len(banner) == 80


def test_contact_that_was_there_before_is_at_least_as_old(watched):
    now = play(watched, 5.0, 1.5, contact=True)
    assert 'for at least 1.5 s' in watch_words.contact(watched.arms[''], now)


def test_both_arms_are_shown_or_one(watched):
    for side in ('right', 'left'):
        now = play(watched, 5.0, 2.0, side=side, place=side)
    lines = drawn(watched, now)
    assert [line.split(':')[0].strip() for line in lines if 'no contact' in line] == [
        'right arm', 'left arm']
    assert sum('OK' in line for line in lines) == 2  # in short: there is no room for twelve
    assert sum('OK' in line for line in drawn(watched, now, height=None)) == 12
    assert not any('right' in line for line in drawn(watched, now, side='left'))


def test_a_predictor_that_starts_again_with_other_arms_leaves_none_behind(watched):
    play(watched, 5.0, 1.0, side='right')
    play(watched, 10.0, 1.0, side='left')
    assert [arm.side for arm in watched.shown()] == ['left']
    for side in ('right', 'left'):
        play(watched, 20.0, 1.0, side=side, place=side)
    assert [arm.side for arm in watched.shown()] == ['right', 'left']


@pytest.mark.parametrize('width', [20, 40, 60, 70, 80, 81, 100, 160, 250])
@pytest.mark.parametrize('height', [5, 12, 24, 40])
def test_nothing_is_wider_or_higher_than_the_terminal(watched, width, height):
    for side in ('right', 'left'):
        now = play(watched, 5.0, 0.2, side=side, place=side, level=1)
    drawn(watched, now, width, height, missing='a remedy that takes more than one line ' * 3)


def test_one_arm_fits_into_80_by_24_whole(watched):
    now = play(watched, 5.0, 1.0, contact=True)
    lines = drawn(watched, now)
    assert sum(any(line.startswith(name) and 'says' in line for name in STATUSES)
               for line in lines) == 6
    assert not any('more lines' in line for line in lines)


def test_levels_are_worded(watched):
    for level, word in enumerate(('OK', 'WARN', 'ERROR', 'STALE')):
        now = play(watched, 5.0 + level, 0.1, level=level)
        assert any(line.split()[:2] == ['input', word] for line in drawn(watched, now))


def test_what_is_wrong_is_said_in_full(watched):
    now = play(watched, 5.0, 0.1)
    message = ' '.join(f'word{k}' for k in range(30))
    watched.take_status('', 'input', Status(1, message, {}, now), 'baxter_right_arm')
    assert message in ' '.join(' '.join(drawn(watched, now)).split())
    drawn(watched, now, width=12, height=None)


def test_ascii_is_ascii(watched):
    now = play(watched, 5.0, 1.0, contact=True)
    text = ''.join(drawn(watched, now, glyphs_=ASCII))
    assert text.isascii() and '#' in text


@pytest.mark.parametrize('encoding, environment, expected', [
    ('utf-8', {'LANG': 'en_GB.UTF-8'}, BLOCKS), ('utf-8', {'LANG': 'C.UTF-8'}, BLOCKS),
    ('utf-8', {'LANG': 'C', 'LC_CTYPE': 'C.UTF-8'}, ASCII), ('utf-8', {}, ASCII),
    ('utf-8', {'LANG': 'en_GB.UTF-8', 'LC_ALL': 'C'}, ASCII),
    ('utf-8', {'LANG': 'C', 'PYTHONIOENCODING': 'utf-8'}, BLOCKS),
    ('ISO-8859-1', {'LANG': 'en_GB.UTF-8'}, ASCII), ('ascii', {'LANG': 'C.UTF-8'}, ASCII)])
def test_ascii_is_chosen_where_the_locale_cannot_more(encoding, environment, expected):
    assert glyphs(encoding, environment) is expected


@pytest.mark.parametrize('drawn_', [BLOCKS, ASCII], ids=['blocks', 'ascii'])
@pytest.mark.parametrize('width', [5, 11, 31])
def test_a_bar_is_as_long_as_its_value_and_on_its_side(drawn_, width):
    half = width // 2
    for value in np.linspace(-1.0, 1.0, 41):
        text = bar(value, 1.0, width, drawn_)
        left, right = text[:half], text[half + 1:]
        assert len(text) == width and text[half] == drawn_.centre
        used, other = (right, left) if value > 0 else (left, right)
        halves = 2 * used.count(drawn_.full) + sum(
            used.count(each) for each in {drawn_.left_half, drawn_.right_half})
        assert halves == round(abs(value) * 2 * half)
        assert set(other) == {drawn_.track}
    assert bar(np.nan, 1.0, width, drawn_).strip(drawn_.track) == drawn_.centre


def test_a_bar_beyond_its_scale_is_marked():
    assert bar(1.01, 1.0, 11, BLOCKS)[-1] == BLOCKS.above
    assert bar(-50.0, 1.0, 11, BLOCKS)[0] == BLOCKS.below
    assert BLOCKS.above not in bar(1.0, 1.0, 11, BLOCKS)
    # ... also where the mark is at the end, or beyond it.
    assert bar(3.0, 1.0, 11, BLOCKS, mark=0.99)[-2:] == BLOCKS.mark + BLOCKS.above
    assert bar(0.0, 1.0, 11, BLOCKS, mark=-2.0)[0] == BLOCKS.below


def test_the_mark_lies_at_its_value():
    for value in (-1.0, -0.4, 0.0, 0.6, 1.0):
        assert bar(0.3, 1.0, 11, BLOCKS, mark=value).index(BLOCKS.mark) == 5 + round(5 * value)


@pytest.mark.parametrize('drawn_', [BLOCKS, ASCII], ids=['blocks', 'ascii'])
def test_a_sparkline_rises_with_its_values(drawn_):
    levels = [drawn_.levels.index(level) for level in sparkline(
        np.linspace(-1.5, 1.5, 61), 1.0, drawn_)]
    assert levels == sorted(levels) and set(levels) == set(range(len(drawn_.levels)))
    assert sparkline([np.nan, -9.0, 9.0], 1.0, drawn_) == (
        ' ' + drawn_.levels[0] + drawn_.levels[-1])


def test_a_trace_keeps_the_extremes_of_each_bin():
    trace, spike = Trace(), np.array([0.0, 0.0, 0.0, -4.0, 0.0, 0.0, 0.0])
    for k in range(8 * 20):  # 20 a bin
        trace.add(spike if k == 50 else np.full(7, 0.1), 100.0 + BIN * k / 20)
    extremes = trace.extremes(10, 100.0 + BIN * 8.5)
    assert extremes.shape == (10, 7)
    assert extremes[3, 3] == -4.0 and np.count_nonzero(extremes == -4.0) == 1
    assert np.isnan(extremes[[0, 9]]).all() and not np.isnan(extremes[1:9]).any()


def test_a_picture_needs_nothing_else(watched, tmp_path):
    now = play(watched, 5.0, 1.0, contact=True)
    picture = tmp_path / 'watch.svg'
    save_picture(picture, view(watched, None, 'a & b', None, now, Canvas(96, None, BLOCKS)), 96,
                 'a & b')
    text = picture.read_text('utf-8')
    assert 'CONTACT' in text.replace('&#160;', ' ') and 'a &amp; b' in text
    assert 'url(http' not in text and '@font-face' not in text
    assert 'fill="#ffffff"' in text  # opaque
    assert [path.name for path in tmp_path.iterdir()] == ['watch.svg']


@pytest.mark.parametrize('arguments, problem', [
    (('--rate', '0'), 'expected 0.2 to 30 Hz, got 0'), (('--arm', 'both'), 'invalid choice'),
    (('--duration', '0'), 'expected 0.5 to 86400 seconds, got 0'),
], ids=lambda value: ' '.join(value) if isinstance(value, tuple) else '')
def test_misuse_is_explained(command, arguments, problem):
    code, out, err = command('watch', *arguments)
    assert (code, out) == (2, '') and problem in err
