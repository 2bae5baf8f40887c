"""The evaluation report's figures, read back from their SVG, and its sentences."""

from dataclasses import replace
import re
from xml.etree import ElementTree

from baxter_dynamics_ros.recordings.evaluation_results import ESTIMATORS, METHODS
import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

PANEL = 126.0  # height of the effort's and the acceleration's panel [pt]


@pytest.fixture
def figures():
    """Return the module that draws."""
    from baxter_dynamics_ros.report import figures
    return figures


@pytest.fixture
def lines(figures):
    """Return a function that returns the paths by which a picture draws a signal's lines."""
    def find(picture, signal):
        color = figures.STROKES[signal].color
        paths = re.findall(rf'<path d="([^"]*)" clip-path="[^"]*" style="fill: none; '
                           rf'stroke: {color}', picture.svg.decode())
        return [path for path in paths if 'L' in path]
    return find


@pytest.fixture
def areas(figures):
    """Return a function that returns the paths by which a picture shades what a signal spans."""
    def find(picture, signal):
        svg, color = picture.svg.decode(), figures.STROKES[signal].color
        direct = re.findall(rf'<path d="([^"]*)"[^>]*style="fill: {color}; fill-opacity', svg)
        shapes = dict(re.findall(r'<path id="([^"]*)" d="([^"]*)"', svg))
        used = re.findall(rf'<use xlink:href="#([^"]*)"[^>]*style="fill: {color}; fill-opac', svg)
        return direct + [shapes[name] for name in used]
    return find


def height(path):
    """Return how high a path is [pt]."""
    y = [float(value) for value in re.findall(r'-?[\d.]+ (-?[\d.]+)', path)]
    return max(y) - min(y)


def test_figures_stand_alone(figures, evaluate):
    one = evaluate()
    for picture in (figures.effort_picture('x', one, 1, figures.FINE),
                    figures.estimator_picture('x', one, 1, figures.FINE),
                    figures.terms_picture('x', one.shares)):
        root = ElementTree.fromstring(picture.svg)
        assert root.tag == '{http://www.w3.org/2000/svg}svg'
        addresses = [value for element in root.iter() for name, value in element.attrib.items()
                     if name.endswith('href')]
        assert addresses and all(address.startswith('#') for address in addresses)
        assert b'DOCTYPE' not in picture.svg
        assert b'<text' not in picture.svg  # letters are shapes: no font is asked for
        assert picture.description


def test_lines_break_at_gaps_and_not_where_samples_are_sparse(figures, lines, evaluate):
    gap = figures.effort_picture('x', evaluate(), 0, figures.FINE)
    # 40 ms from sample to sample, and too few intervals to be merged
    sparse = evaluate(n=400, empty=slice(1, None, 2))
    sparse = figures.effort_picture('x', sparse, 0, figures.FINE)
    for signal, panels in (('measured', 1), ('lagrange_euler', 2), ('newton_euler', 2)):
        assert [path.count('M') for path in lines(gap, signal)] == [2] * panels
        assert [path.count('M') for path in lines(sparse, signal)] == [1] * panels


def test_a_sample_between_two_gaps_is_a_dot(figures, lines, evaluate):
    empty = np.ones(1000, bool)
    empty[[0, 500, 999]] = False
    picture = figures.effort_picture('x', evaluate(empty=empty), 0, figures.FINE)
    assert not lines(picture, 'measured')
    color = figures.STROKES['measured'].color
    assert len(re.findall(rf'<use [^>]*style="fill: {color}; stroke: {color}',
                          picture.svg.decode())) == 3


def test_a_signal_that_is_a_line_is_not_shaded(figures, lines, areas, evaluate):
    one = evaluate()
    shaded = areas(figures.effort_picture('x', one, 0, figures.FINE), 'lagrange_euler')
    assert len(shaded) == 2 * 2  # panels, and parts before and after the gap
    thin = {name: band._replace(high=band.low) for name, band in one.bands.items()}
    picture = figures.effort_picture('x', replace(one, bands=thin), 0, 1000)
    assert not areas(picture, 'lagrange_euler')
    assert len(lines(picture, 'lagrange_euler')) == 2


@pytest.mark.parametrize('quality', ['FINE', 'COARSE'])
def test_pictures_are_bounded(figures, lines, evaluate, quality):
    intervals = getattr(figures, quality)
    picture = figures.effort_picture('x', evaluate(n=5000, empty=slice(0)), 1, intervals)
    drawn = [path for signal in ('measured', *METHODS) for path in lines(picture, signal)]
    assert len(drawn) == 5
    assert all(0.3 * intervals < path.count('L') < intervals for path in drawn)
    assert len(picture.svg) < 200_000


def test_merging_loses_no_peak(figures, areas, evaluate):
    one = evaluate(empty=slice(0))
    one.bands['measured'].high[777, 0] = 1000.0
    picture = figures.effort_picture('x', one, 0, figures.COARSE)
    assert height(areas(picture, 'measured')[0]) > 0.8 * PANEL
    assert height(areas(picture, 'lagrange_euler')[0]) < 0.02 * PANEL


def test_both_methods_are_seen(figures, evaluate):
    """They coincide, so the one below must be wider."""
    svg = figures.effort_picture('x', evaluate(), 0, figures.FINE).svg.decode()
    width, where = {}, {}
    for method in METHODS:
        found = re.search(rf'stroke: {figures.STROKES[method].color}; stroke-width: ([\d.]+)', svg)
        width[method], where[method] = float(found[1]), found.start()
    assert width['newton_euler'] > 3 * width['lagrange_euler']
    assert where['newton_euler'] < where['lagrange_euler']


def test_the_scale_is_the_aligned_ones_and_the_cut_is_said(figures, lines, evaluate):
    one = evaluate()
    picture = figures.estimator_picture('x', one, 0, figures.FINE)
    drawn = {estimator: height(lines(picture, estimator)[0]) for estimator in ESTIMATORS}
    assert 0.35 * PANEL < drawn['butterworth_aligned'] < PANEL < drawn['first_difference']
    said = re.search(r'<!-- cut off; reaches: first difference ([\d.]+) N m -->',
                     picture.svg.decode())
    band = one.bands['error_first_difference']
    assert float(said[1]) == pytest.approx(np.nanmax(np.abs(band)[..., 0]), rel=0.01)
    calm = replace(one, estimators={name: one.estimators[name] for name in ESTIMATORS[1:]})
    assert b'cut off' not in figures.estimator_picture('x', calm, 0, figures.FINE).svg


def test_without_effort_a_picture_shows_the_predictions_alone(figures, lines, evaluate):
    picture = figures.effort_picture('x', evaluate(effort=False), 0, figures.FINE)
    assert not lines(picture, 'measured')
    assert [len(lines(picture, method)) for method in METHODS] == [1, 1]
    assert b'error [N m]' not in picture.svg
    assert b'error [N m]' in figures.effort_picture('x', evaluate(), 0, figures.FINE).svg


def test_a_perfect_prediction_does_not_show_the_noise_of_rounding(figures, lines, evaluate):
    one = evaluate(empty=slice(0))
    band = one.bands['error_lagrange_euler']
    noise = np.random.default_rng(5).normal(0.0, 1e-13, band.low.shape)
    perfect = dict.fromkeys(['error_' + method for method in METHODS], type(band)(noise, noise))
    picture = figures.effort_picture('x', replace(one, bands={**one.bands, **perfect}), 0, 1000)
    assert height(lines(picture, 'lagrange_euler')[1]) < 0.1


def test_the_same_is_drawn_the_same_each_time(figures, evaluate):
    assert figures.effort_picture('x', evaluate(), 2, 500) == figures.effort_picture(
        'x', evaluate(), 2, 500)


def test_findings(evaluate):
    from baxter_dynamics_ros.report.findings import findings
    one = evaluate()
    text = {topic: text.replace('\u00a0', ' ') for topic, text in findings(one)}
    assert '0.14 N m RMS at' in text['Agreement']
    assert '0.52 N m at s0, the worst' in text['Agreement']
    assert 'by 0.9 and more at s0, s1, e0, e1' in text['Agreement']
    assert 'w2 (–)' in text['Agreement']
    assert text['Worst joint'].startswith(
        's0, with 0.52 N m RMS: 10 % of the greatest term there, inertial (5.00 N m)')
    assert 'offset of 0.50 N m makes 93 %' in text['Worst joint']
    assert 's0 (0.50 N m), s1 (−0.25 N m)' in text['Offset']
    assert 'at w2:' in text['Not in the model']
    assert 'Friction and bias' not in text
    zero = {**one.shares, 'friction': np.zeros(7), 'other': np.zeros(7)}
    assert 'Friction and bias' in dict(findings(replace(one, shares=zero)))


def test_remarks(evaluate, too_short):
    from baxter_dynamics_ros.report.findings import findings, remarks
    same, apart = dict(remarks(evaluate())), dict(remarks(evaluate(apart=0.1)))
    assert 'have the same errors' in same['Two methods']
    assert 'should not' in apart['Two methods']
    assert 'first difference' in same['Acceleration']
    assert [topic for topic, _ in findings(too_short)] == ['Agreement']
    assert remarks(too_short) == []
