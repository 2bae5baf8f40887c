"""The calibration report: its page, tables and sentences, from known calibrations."""

from dataclasses import replace

from baxter_dynamics_ros.calibration.calibration_results import Fitted, Judged, Selection
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.recordings.contact_intervals import Contact
import numpy as np
import pytest
from report.pages import HOSTILE, Page

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')


@pytest.fixture(scope='module')
def rich(calibration_page):
    """Return the page with everything."""
    assert [path.name for path in calibration_page.parent.iterdir()] == ['my robot.html']
    return Page(calibration_page)


@pytest.fixture(scope='module')
def nothing_kept(calibration):
    """Return a calibration of a perfect model: no term is kept, one recording, no spring."""
    off = calibration.before.replace({'effort_model.enabled': False})
    return replace(calibration, before=off, after=off, parameters=[], notices=(), by_time=True,
                   steps=[Selection(term, (), np.zeros(7)) for term in ('', 'bias')], lag=None,
                   judged=[Judged(f'run, part {i}', 5.0, np.zeros(7), np.zeros(7))
                           for i in range(5)])


@pytest.fixture(scope='module')
def poor(nothing_kept, tmp_path_factory):
    """Return the page on a calibration with nothing to show."""
    from baxter_dynamics_ros.report.calibration_report import write_calibration
    path = tmp_path_factory.mktemp('poor') / 'report.html'
    write_calibration(path, nothing_kept, 'calibrate', 'their.yml')
    return Page(path)


def sentences(calibration):
    from baxter_dynamics_ros.report.calibration_findings import RULES
    from baxter_dynamics_ros.report.findings import findings
    return {topic: text.replace('\u00a0', ' ') for topic, text in findings(RULES, calibration)}


def cells(of):
    """Return name of the row -> cells, of a table as data."""
    return {row: [column.text(i) for column in of.columns] for i, row in enumerate(of.rows)}


def test_pages_are_self_contained_and_escape_names(rich, poor):
    for page in (rich, poor):
        page.check_self_contained()
    assert rich.text.count(HOSTILE.replace('\udcff', '?')) >= 3


@pytest.mark.parametrize('kind, figures, words', [
    ('rich', {'gain', 'parameters', 'spring'}, [
        'Left arm of a Baxter robot · 30 recordings · 40.0 s · 4,000 samples · 39 parameters',
        "torque_predictor --ros-args --params-file 'my robot.yaml'",
        "baxter_dynamics evaluate BAG --params 'my robot.yaml'",
        '22 warnings s1 sweeps w2: never moves =<script>']),
    ('poor', {'gain'}, ['1 recording in 5 parts · 40.0 s ·', '0 parameters', 'No warnings',
                        '--params-file their.yml', 'No parameter was fitted',
                        'Each part, left out of the fit'])])
def test_contents_of_pages(request, kind, figures, words):
    page = request.getfixturevalue(kind)
    assert {attributes['id'] for tag, attributes in page.elements
            if attributes.get('class') == 'figure'} == figures
    assert ('Spring at s1' in page.text) == ('spring' in figures)
    for text in words:
        assert text in page.text


def test_tables_of_pages(rich, poor):
    left_out = 'RMS of the residual on left-out data [N m]'
    rows = rich.table(f'{left_out}; bars')
    assert set(rows) == {'', 'joint', *JOINTS}
    assert rows['w1'] == ['0.400', '0.200', '−50 %', '0.200', '0.200']
    assert poor.table(f'{left_out}; bars')['s0'] == ['0', '0', '–', '0', '0']
    assert rich.table(f'{left_out} with')['+ Dahl'] == ['0.400', '0.600', *'–––––']
    rows = rich.table('RMS of the residual [N m] on each recording')
    assert len(rows) == 2 + 30 + 1
    assert rows[HOSTILE.replace('\udcff', '?')][:3] == ['1', '1.000', '0.500']
    assert rows['together'][:2] == ['40', '1.000']
    rows = rich.table('Fitted parameters')
    assert rows['gravity y'] == ['0', '−0.086', '0.034', '−2.5', 'm/s²']
    assert 'link 3 mass' not in rows
    assert rich.table('Masses of the links')['3'][:2] == ['4.000', '4.250']


def test_tables(calibration, links):
    from baxter_dynamics_ros.report.calibration_tables import (
        gain_table, links_table, parameters_table, recordings_table, steps_table)
    # e0: (30 (0.8 / 2)^2 + 10 (0.8 1.5)^2) / 40 = 0.48
    assert cells(gain_table(calibration))['e0'] == [
        '0.800', '0.693', '−13\u00a0%', '0.400', '1.200']
    rows = cells(steps_table(calibration))
    assert list(rows) == ['before', '+ bias', '+ viscous', '+ Dahl', '+ tilt', 'after']
    assert rows['before'] == [f'{value:.3f}' for value in calibration.steps[0].rms]
    assert (rows['+ viscous'], rows['after'][2]) == (['–'] * 7, '0.693')
    of = recordings_table(calibration)
    assert cells(of)['laps'][:7] == ['10', '1.000', '0.250', '2.000', '1.000', '0.800', '1.200']
    assert [column.foot for column in of.columns][5:7] == pytest.approx([0.8, np.sqrt(0.48)])
    of = links_table(links)
    assert cells(of)['3'] == ['4.000', '4.250', '0.050', '0.500', '0.750', '0.050',
                              '0', '0.250', '0.050', '−0.500', '−0.250', '0.050']
    assert [group for group, _ in of.groups] == ['mass [kg]', 'moment x [kg m]',
                                                 'moment y [kg m]', 'moment z [kg m]']
    rows = cells(parameters_table(calibration.parameters))
    assert rows['bias s0'] == ['0', '0.50', '0.10', '5.0', 'N m']
    assert rows['Dahl s1'] == ['0', '1.5000', '0.0071', '211.3', 'N m']
    for unknown in (0.0, np.nan):
        one = Fitted('added_inertia', 0, '', 'kg m^2', 0.0, 0.5, unknown)
        assert cells(parameters_table([one]))['added inertia s0'][1] == '0.5000'


def test_expected_deviation_and_crosstalk(calibration):
    from baxter_dynamics_ros.report.calibration_tables import deviation_table
    from baxter_dynamics_ros.report.term_names import parameter_name
    after = calibration.after.replace({'effort_model.deviation': np.arange(1.0, 8.0),
                                       'effort_model.deviation_velocity': [0.5] * 7})
    assert cells(deviation_table(replace(calibration, after=after)))['w2'] == [
        '7.000', '0.500', '0']
    rigid = calibration.after.replace({'effort_model.deviation': [0.0] * 7})
    assert deviation_table(replace(calibration, after=rigid)) is None
    fitted = Fitted('crosstalk', 3, 'of e0', '-', 0.0, -0.037, 0.002)
    assert parameter_name(fitted) == 'crosstalk at e1 of e0'


def test_findings(calibration):
    found = sentences(calibration)
    assert found['Improvement'].startswith(
        'On recordings left out of the fit, the residual is smaller at every joint: s0 −55 %, s1 '
        '−50 %, e0 −13 %')
    assert found['Remaining residual'].startswith(
        's1 has the largest residual, 1.00 N m RMS; it was 2.00 N m.')
    # Bias: six times 50 % and once -10 %.
    assert found['Best terms'].endswith(': bias 41 %, Dahl 13 %.')
    assert found['Worse than before'] == (
        '1 of 2 recordings, at e0; most laps at e0: 0.80 before, 1.20 N m after.')
    assert 'by a fit to the other.' in found['Cross-validation']
    assert found['Uncertain parameters'].startswith(
        'bias e1 (0 ± 0.10 N m), bias w0 (0 ± 0.10 N m), bias w1 (0 ± 0.10 N m), '
        'bias w2 (0.06 ± 0.10 N m): ')
    for words in ('another recording', 's1 from −1.9 to 1.0 rad', 'joints named in the warnings'):
        assert words in found['Record next']
    assert found['Velocity lag'] == (
        '13.300 ± 0.030 ms measured, 14.0 ms used; 14 ms are usual on Baxter. Different: w1 '
        '(20.0 ms).')
    assert found['Tilt of the base'] == '1.1°: 1.0 ± 0.1° forward and 0.5 ± 0.2° to the right.'
    assert 'Contact' not in found


def test_findings_of_other_calibrations(calibration, nothing_kept):
    sure = [one for one in calibration.parameters
            if one.term != 'tilt' and abs(one.value) > one.deviation]
    moment = Fitted('inertial', 0, 'moment y', 'kg m', 0.0, 0.01, 0.02)
    wide = sentences(replace(calibration, judged=2 * calibration.judged, notices=(),
                             s1_range=(-2.0, 0.9), parameters=[*sure, moment]))
    assert not {'Record next', 'Uncertain parameters', 'Tilt of the base'} & wide.keys()
    found = sentences(nothing_kept)
    assert found['Improvement'].startswith('On parts left out')
    assert found['Velocity lag'].startswith('Not measured')
    assert 'the parts are alike' in found['Cross-validation']
    contact = Contact('e0', 123.3, 124.4, 8.1, True, 'laps')
    judged = [calibration.judged[0],
              replace(calibration.judged[1], with_contact=2.0 * calibration.judged[1].after)]
    assert sentences(replace(calibration, contacts=[contact], judged=judged))['Contact'] == (
        'e0 at its stop, 8 N m, from 123.3 to 124.4 s of laps. It is left out of the fit and of '
        'the errors on this page: e0 0.69 N m without it and 1.25 N m with it.')


@pytest.mark.parametrize('factors, text', [
    ((0.5, 1.2, 0.5, 0.5, 0.5, 0.5, 0.999), 'smaller at s0 −50 %, e0 −50 %, e1 −50 %, w0 −50 %, '
     'w1 −50 %, and not at s1 +20 %, w2 0 %.'),
    ((1.2,) * 6 + (30.0,), 'w2 × 30. Keep your present parameters.'),
    ((1.0,) * 7, 'unchanged at every joint.')])
def test_improvement(calibration, factors, text):
    judged = [replace(one, after=one.before * factors) for one in calibration.judged]
    assert sentences(replace(calibration, judged=judged))['Improvement'].endswith(text)


def test_written_whole_or_not_at_all(nothing_kept, tmp_path):
    from baxter_dynamics_ros.report.calibration_report import write_calibration
    (tmp_path / 'folder.html').mkdir()
    with pytest.raises(BaxterDynamicsError, match='folder.html'):
        write_calibration(tmp_path / 'folder.html', nothing_kept, '')
    assert [path.name for path in tmp_path.iterdir()] == ['folder.html']


@pytest.mark.parametrize('value, text', [
    (1.23456, '1.235'), (-0.5, '−0.500'), (0.0, '0'), (-0.0001, '0.000'), (float('nan'), '–'),
    (float('-inf'), '–')])
def test_numbers(value, text):
    from baxter_dynamics_ros.report.number_text import number
    assert number(value) == text


@pytest.mark.parametrize('before, after, text', [
    (2.0, 1.0, '−50 %'), (2.0, 2.001, '0 %'), (2.0, 3.0, '+50 %'), (0.1, 2.0, '× 20'),
    (0.0, 1.0, '–'), (1.0, float('nan'), '–')])
def test_changes(before, after, text):
    from baxter_dynamics_ros.report.number_text import change
    assert change(before, after).replace('\u00a0', ' ') == text
