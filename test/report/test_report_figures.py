"""The figures of the reports, read back from their SVG."""

from dataclasses import replace
import re
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

from baxter_dynamics_ros.report import calibration_contents, drawing  # noqa: E402, I100
from baxter_dynamics_ros.report.evaluation_report import effort_picture  # noqa: E402


@pytest.fixture(scope='module', autouse=True)
def styled():
    """Draw in the style of the reports."""
    with drawing.styled():
        yield


@pytest.fixture
def draw(evaluate):
    """Return a function that draws s0 of an evaluation, with other bands if there are some."""
    def draw_with(bands={}, **options):
        one = evaluate(**options)
        return effort_picture('x', replace(one, bands={**one.bands, **bands}), 0)
    return draw_with


def lines(picture, color):
    """Return the paths of the lines of a signal."""
    paths = re.findall(rf'<path d="([^"]*)" clip-path="[^"]*" style="fill: none; stroke: {color}',
                       picture.svg.decode())
    return [path for path in paths if 'L' in path]


def extent(path, axis=1):
    """Return width (0) or height (1) of a path [pt]."""
    values = [float(pair[axis]) for pair in re.findall(r'(-?[\d.]+) (-?[\d.]+)', path)]
    return max(values) - min(values)


@pytest.mark.parametrize('kind', ['effort', 'gain', 'parameters', 'spring'])
def test_figures_stand_alone_and_follow_the_dark_mode(draw, calibration, kind):
    picture = draw() if kind == 'effort' else getattr(
        calibration_contents, f'{kind}_picture')(calibration)
    root = ElementTree.fromstring(picture.svg)
    assert root.tag == '{http://www.w3.org/2000/svg}svg' and picture.description
    addresses = [value for element in root.iter() for name, value in element.attrib.items()
                 if name.endswith('href')]
    assert addresses and all(address.startswith('#') for address in addresses)
    assert b'DOCTYPE' not in picture.svg and b'<text' not in picture.svg  # letters are shapes
    style, _, shapes = picture.svg.decode().rpartition('</style>')
    dark = set(re.findall(r'\[style\*="((?:fill|stroke): #\w+)"\]', style))
    readable_on_both = {'stroke: #6f9bc4', 'fill: #6f9bc4'}
    assert set(re.findall(r'(?:fill|stroke): #\w+', shapes)) <= dark | readable_on_both


def test_figures_are_reproducible(draw):
    assert draw() == draw()


@pytest.mark.parametrize('empty, pieces', [(slice(100, 113), 2), (slice(1, None, 2), 1)])
def test_lines_break_at_gaps_and_not_where_samples_are_sparse(draw, empty, pieces):
    picture = draw(empty=empty)
    for color, panels in ((drawing.MEASURED, 1), (drawing.MODEL, 2)):
        assert [path.count('M') for path in lines(picture, color)] == [pieces] * panels


def test_a_sample_between_two_gaps_is_a_dot(draw):
    svg = draw(empty=[*range(100, 110), *range(111, 120)]).svg.decode()
    for color, dots in ((drawing.MEASURED, 1), (drawing.MODEL, 2)):
        assert len(re.findall(f'<use [^>]*fill: {color}', svg)) == dots


def test_joints_that_were_not_fitted_are_crosses(calibration):
    svg = calibration_contents.parameters_picture(calibration).svg.decode()
    assert len(re.findall(f'<use [^>]*fill: {drawing.FAINT}', svg)) == 5 + 1  # and in the legend


def test_the_expected_range_is_shaded_but_does_not_dwarf_the_error(draw):
    def drawn(deviation):
        picture = draw({'deviation': drawing.Band(*2 * [np.full((250, 7), deviation)])})
        return (drawing.SHADE in picture.svg.decode().rpartition('</style>')[2],
                extent(lines(picture, drawing.MODEL)[1]))

    is_shaded, height = zip(*map(drawn, (0.0, 0.1, 100.0)))
    assert is_shaded == (False, True, True)
    assert height[0] > height[1] > height[2] > 10.0


def test_prediction_alone_without_effort(draw):
    picture = draw(effort=False)
    assert not lines(picture, drawing.MEASURED)
    assert len(lines(picture, drawing.MODEL)) == 1


def test_rounding_errors_are_not_enlarged(draw):
    noise = np.random.default_rng(5).normal(0.0, 1e-13, (250, 7))
    picture = draw({'error_lagrange_euler': drawing.Band(noise, noise)}, empty=slice(0))
    assert extent(lines(picture, drawing.MODEL)[1]) < 0.1
    labels = re.findall(r'translate\(([\d.]+) [\d.]+\) rotate', picture.svg.decode())
    assert len(labels) == 2 and min(map(float, labels)) > 7.0  # not cut beside long numbers [pt]


def test_spring_is_shaded_where_it_was_measured(calibration):
    svg = calibration_contents.spring_picture(calibration).svg.decode()
    panels, shaded = (re.findall(rf'<path d="([^"]*)"[^>]*style="fill: {color}', svg)
                      for color in ('#ffffff', drawing.SHADE))
    for panel, shade in zip(panels[1:], shaded[:2]):
        assert extent(shade, 0) / extent(panel, 0) == pytest.approx(1.45 / 2.9, abs=0.01)
    off = calibration.after.replace({'effort_model.enabled': False})
    assert calibration_contents.spring_picture(replace(calibration, before=off, after=off)) is None
