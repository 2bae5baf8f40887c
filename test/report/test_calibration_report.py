"""The calibration report: its page, its tables and its figures, from known calibrations."""

import base64
from dataclasses import replace
from html import unescape
import re
from xml.etree import ElementTree

from baxter_dynamics_ros.calibration.calibration_results import Judged, Selection
from baxter_dynamics_ros.calibration.term import Fitted
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

HOSTILE = '=<script>alert("x")</script> & \'../a b\''  # see conftest


@pytest.fixture(scope='module')
def rich(calibration_report):
    """Return the page with all there can be, whose names mean harm."""
    assert [path.name for path in calibration_report.parent.iterdir()] == ['my robot.html']
    return calibration_report.read_text(encoding='utf-8')


@pytest.fixture(scope='module')
def poor(nothing_kept, tmp_path_factory):
    """Return the page where there is least to say, of one recording."""
    from baxter_dynamics_ros.report.calibration_report import write_calibration
    path = tmp_path_factory.mktemp('poor') / 'report.html'
    write_calibration(path, nothing_kept, 'calibrate', 'their.yml')
    return path.read_text(encoding='utf-8')


@pytest.fixture(scope='module')
def nothing_kept(calibration):
    """Return a calibration that kept no term, and judged a perfect prediction by time."""
    off = calibration.before.replace({'effort_model.enabled': False})
    return replace(calibration, before=off, after=off, parameters=[], notices=(), by_time=True,
                   steps=[Selection(term, (), np.zeros(7)) for term in ('', 'bias')], lag=None,
                   judged=[Judged(f'run, part {i}', 5.0, np.zeros(7), np.zeros(7))
                           for i in range(5)])


def text(html):
    """Return what a reader sees of some HTML, with single spaces."""
    html = re.sub(r'<(style|script)>.*?</\1>', '', html, flags=re.DOTALL)
    return ' '.join(unescape(re.sub(r'<[^>]*>', '', html)).split())


def table(html, caption):
    """Return row's name -> its other cells, of the table whose caption begins so."""
    found = [one for one in re.findall(r'<table.*?</table>', html, re.DOTALL)
             if text(re.search(r'<caption>.*?</caption>', one)[0]).startswith(caption)]
    rows = [[text(cell) for cell in re.findall(r'<t[dh][ >].*?</t[dh]>', row, re.DOTALL)]
            for row in re.findall(r'<tr>.*?</tr>', *found, re.DOTALL)]
    return {row[0]: row[1:] for row in rows}


def pictures(html):
    """Return name -> SVG of the figures."""
    found = re.findall(r'<a class="figure" id="(\w+)" href="#\1">\s*'
                       r'<img src="data:image/svg\+xml;base64,([^"]+)" alt="[^"]+">', html)
    return {name: base64.b64decode(data).decode() for name, data in found}


def paths(svg, color):
    """Return the paths that are filled with a color."""
    return re.findall(rf'<path d="([^"]*)"[^>]*style="fill: {color}', svg)


def width(path):
    """Return how wide a path is [pt]."""
    x = [float(value) for value in re.findall(r'[ML]\s*(-?[\d.]+) ', path)]
    return max(x) - min(x)


def cells(of):
    """Return row's name -> its cells, of a table as data."""
    return {row: [column.text(i) for column in of.columns] for i, row in enumerate(of.rows)}


def test_the_page_refers_to_nothing_outside(rich):
    addresses = re.findall(r'(?:href|src)="([^"]*)"', rich)
    ids = re.findall(r' id="([^"]*)"', rich)
    assert len(addresses) == 2 * len(pictures(rich))
    for address in addresses:
        assert address.startswith('data:image/svg+xml;base64,') or address[1:] in ids
    assert len(set(ids)) == len(ids)
    assert "default-src 'none'" in rich
    assert not re.search(r'url\(|@import|https?:', rich)
    assert len(rich) < 1.5e6


def test_the_figures(rich, poor):
    always = {'gain', *(f'steps_{joint}' for joint in JOINTS)}
    assert pictures(poor).keys() == always
    assert pictures(rich).keys() == always | {'parameters', 'spring', 'friction_s0',
                                              'friction_s1', 'masses'}
    for svg in pictures(rich).values():
        root = ElementTree.fromstring(svg)
        assert all(value.startswith('#') for element in root.iter()
                   for name, value in element.attrib.items() if name.endswith('href'))


def test_the_head_says_what_it_was_fitted_to(rich, poor):
    assert ('Left arm of a Baxter robot · 30 recordings · 40.0 s · 4,000 samples · 39 parameters'
            in text(rich))
    assert '· 1 recording, judged in 5 parts · 40.0 s ·' in text(poor)
    assert '0 parameters' in text(poor)


def test_the_tables_of_the_page(rich, poor):
    rows = table(rich, 'RMS of the residual on what was left out [N m]; the bars')
    assert set(rows) == {'', 'joint', *JOINTS}
    assert rows['w1'] == ['0.400', '0.200', '−50 %', '0.200', '0.200']
    rows = table(poor, 'RMS of the residual on what was left out [N m]; the bars')
    assert rows['s0'] == ['0', '0', '–', '0', '0']
    rows = table(rich, 'RMS of the residual on what was left out [N m], with all')
    assert rows['+ Dahl'] == ['0.400', '0.600', *'–––––']
    rows = table(rich, 'RMS of the residual [N m] on each recording')
    assert len(rows) == 2 + 30 + 1
    assert rows[HOSTILE + '?'][:3] == ['1', '1.000', '0.500']
    assert rows['together'][:2] == ['40', '1.000']
    rows = table(rich, 'Parameters that were fitted')
    assert rows['gravity y'] == ['0', '−0.086', '0.034', '−2.5', 'm/s²']
    assert 'link 3 mass' not in rows
    assert table(rich, "The links' masses")['3'][:2] == ['4.000', '4.250']
    assert table(rich, 'Spring and bias at s1')['1.00'][2:] == ['−0.25', '–']


def test_many_recordings_are_folded(rich, poor):
    assert 'All 30 recordings' in re.search(r'<details class="rows">.*?</details>', rich,
                                            re.DOTALL)[0]
    assert '<details class="rows">' not in poor
    assert len(table(poor, 'RMS of the residual [N m] on each part')) == 2 + 5 + 1


def test_warnings_stand_first_and_those_of_all_recordings_before(rich, poor):
    box, _, _ = rich.partition('In short')
    assert '22 warnings s1 sweeps w2: never moves =<script>' in text(box)
    shown, _, folded = box.partition('<details>')
    assert (shown.count('<li>'), folded.count('<li>')) == (8, 14)
    assert '14 more' in folded
    assert 'Warnings: none In short' in text(poor)
    assert '<details>' not in poor


def test_names_are_text_and_never_markup(rich):
    assert rich.count('<script') == 1
    assert text(rich).count(HOSTILE) >= 3


def test_how_to_use_it(rich, poor):
    assert "torque_predictor --ros-args --params-file 'my robot.yaml'" in text(rich)
    assert "baxter_dynamics evaluate BAG --params 'my robot.yaml'" in text(rich)
    assert '--params-file their.yml' in text(poor)


def test_what_is_not_there_is_said(poor):
    assert 'No parameter was fitted' in text(poor)
    assert 'No friction was fitted at any joint' in text(poor)
    assert 'The spring at s1' not in text(poor)
    assert 'Each part, left out of the fit' in text(poor)


def test_written_whole_or_not_at_all(nothing_kept, tmp_path):
    from baxter_dynamics_ros.report.calibration_report import write_calibration
    (tmp_path / 'folder.html').mkdir()
    with pytest.raises(BaxterDynamicsError, match='folder.html'):
        write_calibration(tmp_path / 'folder.html', nothing_kept, '')
    (tmp_path / 'old.html').write_text('old')
    with pytest.raises(AttributeError):
        write_calibration(tmp_path / 'old.html', None, '')
    assert (tmp_path / 'old.html').read_text() == 'old'
    assert {path.name for path in tmp_path.iterdir()} == {'folder.html', 'old.html'}


def test_before_and_after_on_what_was_left_out(calibration):
    from baxter_dynamics_ros.report.calibration_tables import gain_table
    # e0: (30 (0.8 / 2)^2 + 10 (0.8 1.5)^2) / 40 = 0.48
    assert cells(gain_table(calibration))['e0'] == ['0.800', '0.693', '−13\u00a0%', '0.400',
                                                    '1.200']


def test_what_each_term_bought(calibration):
    from baxter_dynamics_ros.report.calibration_tables import steps_table
    rows = cells(steps_table(calibration))
    assert list(rows) == ['before', '+ bias', '+ viscous', '+ Dahl', '+ tilt', 'after']
    assert rows['before'] == [f'{value:.3f}' for value in calibration.steps[0].rms]
    assert rows['+ viscous'] == ['–'] * 7
    assert rows['after'][2] == '0.693'


def test_each_recording(calibration):
    from baxter_dynamics_ros.report.calibration_tables import recordings_table
    of = recordings_table(calibration)
    assert cells(of)['laps'][:7] == ['10', '1.000', '0.250', '2.000', '1.000', '0.800', '1.200']
    assert [column.foot for column in of.columns][5:7] == pytest.approx([0.8, np.sqrt(0.48)])


def test_parameters_have_as_many_digits_as_mean_something(calibration):
    from baxter_dynamics_ros.report.calibration_tables import parameters_table
    rows = cells(parameters_table(calibration.parameters))
    assert rows['bias s0'] == ['0', '0.50', '0.10', '5.0', 'N m']
    assert rows['Dahl s1'] == ['0', '1.5000', '0.0071', '211.3', 'N m']
    assert len(rows) == len(calibration.parameters)
    for unknown in (0.0, np.nan):
        one = Fitted('added_inertia', 0, '', 'kg m^2', 0.0, 0.5, unknown)
        assert cells(parameters_table([one]))['added inertia s0'][1] == '0.5000'


def test_links_have_a_row_each(links):
    from baxter_dynamics_ros.report.calibration_tables import links_table
    of = links_table(links)
    assert cells(of)['3'] == ['4.000', '4.250', '0.050', '0.500', '0.750', '0.050',
                              '0', '0.250', '0.050', '−0.500', '−0.250', '0.050']
    assert [group for group, _ in of.groups] == ['mass [kg]', 'moment x [kg m]',
                                                 'moment y [kg m]', 'moment z [kg m]']


def test_the_spring_in_numbers(calibration):
    from baxter_dynamics_ros.report.calibration_tables import spring_table
    rows = cells(spring_table(calibration))
    assert [row[3] for row in rows.values()] == [*'–––', *(4 * ['yes']), *'––']
    assert {row[2] for row in rows.values()} == {'−0.25'}  # the bias at s1


def test_bars_of_terms_that_were_not_kept_are_grey(calibration):
    from baxter_dynamics_ros.report.gain_figures import steps_picture
    dark, grey, taken, added = '#0b3c68', '#d5dae0', '#bcd9ee', '#f0b79b'

    def bars(joint, color):
        svg = steps_picture('x', calibration, JOINTS.index(joint)).svg.decode()
        found = [width(path) for path in paths(svg, color)]
        return [x for x in found if x > 0.1]

    assert (len(bars('w2', dark)), len(bars('w2', grey))) == (3, 2)
    before, bias, dahl, tilt = bars('s1', dark)
    assert len(bars('s1', grey)) == 1
    assert [x / before for x in (bias, dahl, tilt)] == pytest.approx([1.0, 0.3, 0.3], abs=0.01)
    assert [x / before for x in bars('s1', taken)] == pytest.approx([0.8], abs=0.01)
    assert [x / before for x in bars('s1', added)] == pytest.approx([0.1, 0.1], abs=0.01)


def test_the_spring_is_shaded_where_it_was_measured(calibration):
    from baxter_dynamics_ros.report.model_figures import spring_picture
    svg = spring_picture('x', calibration).svg.decode()
    panels, shaded = paths(svg, '#ffffff')[1:], paths(svg, '#e6eef6')
    for panel, shade in zip(panels, shaded[:2]):
        assert width(shade) / width(panel) == pytest.approx(1.45 / 2.9, abs=0.01)
    off = calibration.after.replace({'effort_model.enabled': False})
    assert spring_picture('x', replace(calibration, before=off, after=off)) is None


def test_friction_with_a_memory_is_a_loop(calibration):
    from baxter_dynamics_ros.report.model_figures import friction_loop
    angle, friction = friction_loop(calibration.after.model.effort_model, 1)
    assert (angle.min(), angle.max()) == pytest.approx((-0.1, 0.1), abs=1e-3)
    # Over 0.2 rad z goes from -a to a = tanh(0.2 / (2 0.05)).
    assert friction.max() == pytest.approx(1.5 * np.tanh(2.0), abs=0.01)
    assert friction.min() == pytest.approx(-friction.max(), abs=0.01)
    upward = np.gradient(angle) > 1e-4
    assert friction[upward & (np.abs(angle) < 0.03)].min() > 0.3


def test_the_same_is_drawn_the_same_each_time(calibration):
    from baxter_dynamics_ros.report.gain_figures import gain_picture
    assert gain_picture('x', calibration) == gain_picture('x', calibration)


@pytest.mark.parametrize('before, after, said', [
    (2.0, 1.0, '−50 %'), (2.0, 2.001, '0 %'), (2.0, 3.0, '+50 %'), (0.1, 2.0, '× 20'),
    (0.0, 1.0, '–'), (1.0, float('nan'), '–')])
def test_changes(before, after, said):
    from baxter_dynamics_ros.report.page import change
    assert change(before, after).replace('\u00a0', ' ') == said
