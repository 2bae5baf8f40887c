"""The figures of the reports, read back from their SVG."""

from dataclasses import replace
import re
from xml.etree import ElementTree

from baxter_dynamics_ros.recordings.evaluation_results import METHODS
import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

PANEL = 126.0  # height of the effort's panel [pt]


@pytest.fixture(scope='module')
def figures():
    """Return the module that draws."""
    from baxter_dynamics_ros.report import evaluation_figures
    from baxter_dynamics_ros.report.drawing import styled
    with styled():
        yield evaluation_figures


@pytest.fixture(scope='module')
def apart(evaluate, figures):
    """Return the figure of a joint where the methods differ, with a gap."""
    return figures.effort_picture('x', evaluate(apart=0.1), 0, figures.FINE)


@pytest.fixture
def lines(figures):
    """Return a function that returns the paths of a signal's lines."""
    def find(picture, signal):
        color = figures.STROKES[signal].color
        paths = re.findall(rf'<path d="([^"]*)" clip-path="[^"]*" style="fill: none; '
                           rf'stroke: {color}', picture.svg.decode())
        return [path for path in paths if 'L' in path]
    return find


@pytest.fixture
def areas(figures):
    """Return a function that returns the paths of a signal's shaded ranges."""
    def find(picture, signal):
        svg, color = picture.svg.decode(), figures.STROKES[signal].color
        direct = re.findall(rf'<path d="([^"]*)"[^>]*style="fill: {color}; fill-opacity', svg)
        shapes = dict(re.findall(r'<path id="([^"]*)" d="([^"]*)"', svg))
        used = re.findall(rf'<use xlink:href="#([^"]*)"[^>]*style="fill: {color}; fill-opac', svg)
        return direct + [shapes[name] for name in used]
    return find


def extent(path, axis=1):
    """Return width (0) or height (1) of a path [pt]."""
    values = [float(pair[axis]) for pair in re.findall(r'(-?[\d.]+) (-?[\d.]+)', path)]
    return max(values) - min(values)


def test_figures_stand_alone(figures, apart, calibration):
    from baxter_dynamics_ros.report import calibration_figures as of
    for picture in (apart, of.gain_picture(calibration), of.parameters_picture(calibration),
                    of.spring_picture(calibration)):
        root = ElementTree.fromstring(picture.svg)
        assert root.tag == '{http://www.w3.org/2000/svg}svg'
        addresses = [value for element in root.iter() for name, value in element.attrib.items()
                     if name.endswith('href')]
        assert addresses and all(address.startswith('#') for address in addresses)
        assert b'DOCTYPE' not in picture.svg
        assert b'<text' not in picture.svg  # letters are shapes: no font is needed
        assert picture.description


def test_every_color_has_a_counterpart_in_dark_mode(apart, calibration):
    from baxter_dynamics_ros.report import calibration_figures as of
    for picture in (apart, of.gain_picture(calibration), of.spring_picture(calibration)):
        svg = picture.svg.decode()
        dark = set(re.findall(r'\[style\*="((?:fill|stroke): #\w+)"\]', svg))
        used = set(re.findall(r'(?:fill|stroke): #\w+', svg[svg.index('</style>'):]))
        assert used - dark <= {'stroke: #6f9bc4', 'fill: #6f9bc4'}  # readable on both


def test_lines_break_at_gaps_and_not_where_samples_are_sparse(figures, lines, evaluate, apart):
    # 40 ms from sample to sample, and too few intervals to be merged
    sparse = evaluate(n=400, empty=slice(1, None, 2), apart=0.1)
    sparse = figures.effort_picture('x', sparse, 0, figures.FINE)
    for signal, panels in (('measured', 1), ('lagrange_euler', 2), ('newton_euler', 2)):
        assert [path.count('M') for path in lines(apart, signal)] == [2] * panels
        assert [path.count('M') for path in lines(sparse, signal)] == [1] * panels


def test_a_sample_between_two_gaps_is_a_dot(figures, lines, evaluate):
    empty = np.ones(1000, bool)
    empty[[0, 500, 999]] = False
    picture = figures.effort_picture('x', evaluate(empty=empty), 0, figures.FINE)
    assert not lines(picture, 'measured')
    color = figures.STROKES['measured'].color
    assert len(re.findall(rf'<use [^>]*style="fill: {color}; stroke: {color}',
                          picture.svg.decode())) == 3


def test_only_ranges_are_shaded(figures, lines, areas, evaluate, apart):
    assert len(areas(apart, 'lagrange_euler')) == 2 * 2  # panels, before and after the gap
    one = evaluate()
    thin = {name: band._replace(high=band.low) for name, band in one.bands.items()}
    picture = figures.effort_picture('x', replace(one, bands=thin), 0, 1000)
    assert not areas(picture, 'lagrange_euler')
    assert len(lines(picture, 'lagrange_euler')) == 2


@pytest.mark.parametrize('quality', ['FINE', 'COARSE'])
def test_size_is_bounded_and_no_peak_is_lost(figures, lines, areas, evaluate, quality):
    intervals = getattr(figures, quality)
    one = evaluate(n=5000, empty=slice(0), apart=0.1)
    one.bands['measured'].high[777, 0] = 1000.0
    picture = figures.effort_picture('x', one, 0, intervals)
    drawn = [path for signal in ('measured', *METHODS) for path in lines(picture, signal)]
    assert len(drawn) == 5
    assert 0.3 * intervals < max(path.count('L') for path in drawn) < intervals
    assert len(picture.svg) < 200_000
    assert extent(areas(picture, 'measured')[0]) > 0.8 * PANEL
    assert extent(areas(picture, 'lagrange_euler')[0]) < 0.02 * PANEL


def test_methods_are_drawn_both_only_where_they_differ(figures, lines, evaluate, apart):
    svg, width, where = apart.svg.decode(), {}, {}
    for method in METHODS:
        found = re.search(rf'stroke: {figures.STROKES[method].color}; stroke-width: ([\d.]+)', svg)
        width[method], where[method] = float(found[1]), found.start()
    assert width['newton_euler'] > 3 * width['lagrange_euler']
    assert where['newton_euler'] < where['lagrange_euler']
    same = figures.effort_picture('x', evaluate(), 0, figures.FINE)
    assert [len(lines(same, method)) for method in METHODS] == [2, 0]


def test_the_expected_range_is_shaded_but_does_not_dwarf_the_error(figures, evaluate, lines):
    one = evaluate()

    def draw(deviation):
        band = type(one.bands['deviation'])(*2 * [np.full((1000, 7), deviation)])
        picture = figures.effort_picture(
            'x', replace(one, bands={**one.bands, 'deviation': band}), 0, figures.FINE)
        shades = re.findall(r'#e6eef6', picture.svg.decode().partition('</style>')[2])
        return bool(shades), extent(lines(picture, 'lagrange_euler')[1])

    is_shaded, height = zip(*map(draw, (0.0, 0.1, 100.0)))
    assert is_shaded == (False, True, True)
    assert height[0] > height[1] > height[2] > 10.0


def test_prediction_alone_without_effort(figures, lines, evaluate):
    picture = figures.effort_picture('x', evaluate(effort=False), 0, figures.FINE)
    assert not lines(picture, 'measured')
    assert len(lines(picture, 'lagrange_euler')) == 1
    assert b'error [N m]' not in picture.svg


def test_rounding_errors_are_not_enlarged(figures, lines, evaluate):
    one = evaluate(empty=slice(0))
    band = one.bands['error_lagrange_euler']
    noise = np.random.default_rng(5).normal(0.0, 1e-13, band.low.shape)
    perfect = {'error_lagrange_euler': type(band)(noise, noise)}
    picture = figures.effort_picture('x', replace(one, bands={**one.bands, **perfect}), 0, 1000)
    assert extent(lines(picture, 'lagrange_euler')[1]) < 0.1


def test_figures_are_reproducible(figures, evaluate, apart):
    assert apart == figures.effort_picture('x', evaluate(apart=0.1), 0, figures.FINE)


def test_spring_is_shaded_where_it_was_measured(figures, calibration):
    from baxter_dynamics_ros.report.calibration_figures import spring_picture
    svg = spring_picture(calibration).svg.decode()
    panels, shaded = (re.findall(rf'<path d="([^"]*)"[^>]*style="fill: {color}', svg)
                      for color in ('#ffffff', '#e6eef6'))
    for panel, shade in zip(panels[1:], shaded[:2]):
        assert extent(shade, 0) / extent(panel, 0) == pytest.approx(1.45 / 2.9, abs=0.01)
    off = calibration.after.replace({'effort_model.enabled': False})
    assert spring_picture(replace(calibration, before=off, after=off)) is None
