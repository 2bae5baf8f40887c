"""The pages, tables, sentences and numbers of both reports, from known results."""

import base64
import csv
from dataclasses import replace
import json
import re

from baxter_dynamics_ros.calibration.calibration_results import Fitted, Judged, Selection
from baxter_dynamics_ros.model import JOINTS
from baxter_dynamics_ros.model.paper_tables import TABLE_V, TABLE_V_SUM
from baxter_dynamics_ros.recordings.evaluation_results import (ESTIMATORS, Expected, METHODS,
                                                               TERMS)
from baxter_dynamics_ros.recordings.playback import Contact
import numpy as np
import pytest
from report.pages import HOSTILE, Page

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

from baxter_dynamics_ros.report import calibration_contents as contents  # noqa: E402, I100
from baxter_dynamics_ros.report import calibration_report, evaluation_report  # noqa: E402
from baxter_dynamics_ros.report.page import change, findings, number  # noqa: E402

SHOWN = HOSTILE.replace('\udcff', '?')


@pytest.fixture(scope='module')
def nothing_kept(calibration):
    """Return a calibration of a perfect model: no term is kept, one recording, no spring."""
    off = calibration.before.replace({'effort_model.enabled': False})
    return replace(calibration, before=off, after=off, parameters=[], notices=(), fold='part',
                   steps=[Selection(term, (), np.zeros(7)) for term in ('', 'bias')], lag=None,
                   judged=[Judged(f'run, part {i}', 5.0, *np.zeros((3, 7))) for i in range(5)])


@pytest.fixture(scope='module')
def pages(evaluation_folder, calibration_page, nothing_kept, tmp_path_factory):
    """Return the pages: evaluation, rich, and poor, of a calibration with nothing to show."""
    path = tmp_path_factory.mktemp('poor') / 'report.html'
    calibration_report.write_calibration(path, nothing_kept, 'calibrate', 'their.yml')
    return {'evaluation': Page(evaluation_folder / 'report.html'), 'rich': Page(calibration_page),
            'poor': Page(path)}


def sentences(module, of):
    return {topic: text.replace('\u00a0', ' ')
            for topic, text in findings(module.RULES, of).items()}


@pytest.mark.parametrize('kind', ['evaluation', 'rich', 'poor'])
def test_pages_fetch_nothing_and_escape_names(pages, kind):
    pages[kind].check_self_contained()
    assert kind == 'poor' or SHOWN in pages[kind].text


@pytest.mark.parametrize('kind, figures, words', [
    ('rich', {'gain', 'parameters', 'spring'}, [
        'Left arm of a Baxter robot · 30 recordings · 30.0 s · 4,000 samples · 39 parameters',
        "torque_predictor --ros-args --params-file 'my robot.yaml'",
        "evaluate BAG --params 'my robot.yaml'", 'calibrate --plan --arm left',
        '22 warnings s1 sweeps w2: never moves =<script>']),
    ('poor', {'gain'}, ['1 recording in 5 parts · 25.0 s ·', '0 parameters', 'No warnings',
                        '--params-file their.yml', 'No parameter was fitted',
                        'Each part, left out of the fit'])])
def test_contents_of_the_calibration_page(pages, kind, figures, words):
    page = pages[kind]
    assert {attributes['id'] for tag, attributes in page.elements
            if attributes.get('class') == 'figure'} == figures
    assert ('Spring at s1' in page.text) == ('spring' in figures)
    for text in words:
        assert text in page.text


def test_tables_of_the_calibration_page(pages):
    left_out = 'RMS of the residual on left-out data [N m]'
    rows = pages['rich'].table(f'{left_out}; bars')
    assert set(rows) == {'', 'joint', *JOINTS}
    assert rows['w1'] == ['0.400', '0.200', '−50 %', '0.200', '0.200']
    assert pages['poor'].table(f'{left_out}; bars')['s0'] == ['0', '0', '–', '0', '0']
    assert pages['rich'].table(f'{left_out} with')['+ Dahl'] == ['0.400', '0.600', *'–––––']
    rows = pages['rich'].table('RMS of the residual [N m] on each recording')
    assert len(rows) == 2 + 30 + 1
    assert rows[SHOWN][:3] == ['1', '1.000', '0.500']
    assert rows['together'][:2] == ['30', '1.000']
    rows = pages['rich'].table('Fitted parameters')
    assert rows['gravity y'] == ['0', '−0.086', '0.034', '−2.5', 'm/s²']
    assert rows['bias s0'] == ['0', '0.50', '0.10', '5.0', 'N m'] and 'links mass' not in rows
    assert pages['rich'].table('Masses of the links')['3'] == [
        '4.000', '4.250', '0.050', '0.500', '0.750', '0.050', '0', '0.250', '0.050', '−0.500',
        '−0.250', '0.050']


def test_means_over_recordings_and_names_of_parameters(calibration):
    # e0: (30 (0.8 / 2)^2 + 10 (0.8 1.5)^2) / 40 = 0.48
    assert [column.text(2) for column in contents.gain_table(calibration).columns] == [
        '0.800', '0.693', '−13\u00a0%', '0.400', '1.200']
    shared = Fitted('crosstalk', 3, 'of e0', '-', 0.0, -0.037, 0.002)
    assert contents.parameter_name(shared) == 'crosstalk at e1 of e0'


def test_findings_of_a_calibration(calibration):
    found = sentences(calibration_report, calibration)
    for topic, text in {
            'Improvement': 'On recordings left out of the fit, the residual is smaller at every '
            'joint: s0 −55 %, s1 −50 %, e0 −13 %',
            'Worse than before':
            '1 of 2 recordings, at e0; largest increase: e0 in laps, 0.80 before, 1.20 N m after.',
            'Cross-validation': 'Each of 2 recordings was predicted by a fit to the other.',
            'Uncertain parameters': 'bias e1 (0 ± 0.10 N m), bias w0 (0 ± 0.10 N m), bias w1 '
            '(0 ± 0.10 N m), bias w2 (0.06 ± 0.10 N m): ',
            'Velocity lag': '13.300 ± 0.030 ms measured, 14.0 ms used; 14 ms are usual on Baxter. '
            'Joints that differ: w1 (20.0 ms).',
            'Tilt of the base': '1.1°: 1.0 ± 0.1° forward and 0.5 ± 0.2° to the right.',
            'Record next': 'Useful: another recording of a different motion; a motion of s1 from '
            '−1.9 to 1.0 rad, for the spring (now −1.10 to 0.35); a motion in which the joints '
            'named in the warnings move back and forth.'}.items():
        assert found.pop(topic).startswith(text)
    assert not found


def test_findings_of_other_calibrations(calibration, nothing_kept):
    sure = [one for one in calibration.parameters
            if one.term != 'tilt' and abs(one.value) > one.deviation]
    moment = Fitted('inertial', 0, 'moment y', 'kg m', 0.0, 0.01, 0.02)
    wide = sentences(calibration_report, replace(
        calibration, judged=2 * calibration.judged, notices=(), s1_range=(-2.0, 0.9),
        parameters=[*sure, moment]))
    assert not {'Record next', 'Uncertain parameters', 'Tilt of the base'} & wide.keys()
    found = sentences(calibration_report, nothing_kept)
    assert found['Improvement'].startswith('On parts of the recording left out')
    assert found['Velocity lag'].startswith('Not measured')
    assert 'the parts are alike' in found['Cross-validation']
    contact = Contact('e0', 123.3, 124.4, 8.1, True, 'laps')
    judged = [calibration.judged[0],
              calibration.judged[1]._replace(with_contact=2.0 * calibration.judged[1].after)]
    assert sentences(calibration_report, replace(calibration, contacts=[contact], judged=judged))[
        'Contact'] == (
        'e0 at its stop, 8 N m, from 123.3 to 124.4 s of laps. It is left out of the fit and of '
        'the errors on this page: e0 0.69 N m without it and 1.25 N m with it.')


@pytest.mark.parametrize('factors, text', [
    ((0.5, 1.2, 0.5, 0.5, 0.5, 0.5, 0.999), 'smaller at s0 −50 %, e0 −50 %, e1 −50 %, w0 −50 %, '
     'w1 −50 %, and not at s1 +20 %, w2 0 %.'),
    ((1.2,) * 6 + (30.0,), 'w2 × 30. Keep your present parameters.'),
    ((1.0,) * 7, 'unchanged at every joint.')])
def test_improvement(calibration, factors, text):
    judged = [one._replace(after=one.before * factors) for one in calibration.judged]
    assert sentences(calibration_report, replace(calibration, judged=judged))[
        'Improvement'].endswith(text)


@pytest.mark.parametrize('function, arguments, text', [
    (number, (1.23456,), '1.235'), (number, (-0.5,), '−0.500'), (number, (0.0,), '0'),
    (number, (-0.0001,), '0.000'), (number, (float('-inf'),), '–'),
    (change, (2.0, 1.0), '−50 %'), (change, (2.0, 2.001), '0 %'), (change, (2.0, 3.0), '+50 %'),
    (change, (0.1, 2.0), '× 20'), (change, (0.0, 1.0), '–'), (change, (1.0, np.nan), '–')])
def test_numbers(function, arguments, text):
    assert function(*arguments).replace('\u00a0', ' ') == text


def test_files_of_an_evaluation(evaluation_folder, pages):
    assert {path.name for path in evaluation_folder.iterdir()} == {
        'figures', 'notes.txt', 'report.html', 'summary.csv', 'summary.json'}
    figures = {path.name: path.read_bytes() for path in (evaluation_folder / 'figures').iterdir()}
    assert figures.keys() == {f'{start}_effort_{joint}.svg' for joint in JOINTS
                              for start in ('01_script_alert_x_script_a_b', '02_no_effort')}
    inline = [base64.b64decode(address.partition(',')[2])
              for address in pages['evaluation'].addresses if address.startswith('data:')]
    assert sorted(inline) == sorted(figures.values())


def test_summary_json(evaluation_folder, evaluate):
    first = evaluate()
    summary = json.loads((evaluation_folder / 'summary.json').read_text(encoding='utf-8'),
                         parse_constant=lambda constant: pytest.fail(f'{constant} is not JSON'))
    one, two, three = summary['recordings']
    assert (summary['arm'], summary['command']) == ('right', 'evaluate "a&b" <c>')
    assert summary['verdict']['kind'] == 'uncalibrated'
    assert summary['advice'][0]['text'] == 'Calibrate:'
    assert one['notices'] == [{'kind': 'test', 'joints': [], 'text': one['warnings'][0]}]
    assert (one['counts']['not_this_arm'], one['duration'], one['rate']) == (5, 20.0, 12.5)
    for found in (summary, one):
        for method in METHODS:
            errors = first.methods[method]
            assert found[method] == {
                'count': 237, 'rms': errors.rms.tolist(), 'mean_abs': errors.mean_abs.tolist(),
                'signed_mean': errors.signed_mean.tolist(),
                'correlation': [*errors.correlation[:6], None]}
        assert {name: errors['rms'] for name, errors in found['estimators'].items()} == {
            name: first.estimators[name].rms.tolist() for name in ESTIMATORS}
        assert found['shares'] == {term: first.shares[term].tolist() for term in TERMS}
    assert two['newton_euler']['rms'] == three['shares']['gravity'] == [None] * 7


def test_summary_csv(evaluation_folder, evaluate):
    path = evaluation_folder / 'summary.csv'
    assert path.read_bytes().startswith(b'\xef\xbb\xbf')
    with path.open(encoding='utf-8-sig', newline='') as file:
        rows = list(csv.reader(file))
    assert rows[0] == ['recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
                       'mean_abs [N m]', 'signed_mean [N m]', 'correlation']
    assert len(rows) == 1 + 3 * len(METHODS) * len(JOINTS)
    s1 = rows[1 + len(JOINTS) + 1]
    assert s1[:6] == ["'" + SHOWN, '/robot/joint_states', 'right', 'newton_euler', 's1', '237']
    assert [float(cell) for cell in s1[6:]] == [
        column[1] for column in evaluate().methods['newton_euler'][1:]]
    assert rows[7][-1] == ''  # no correlation at w2
    assert rows[-1] == ['too short', '/robot/joint_states', 'right', 'newton_euler', 'w2', '0',
                        '', '', '', '']


def test_tables_of_the_evaluation_page(pages, evaluate):
    first, table = evaluate(), pages['evaluation'].table
    size, five, terms = table('Error e = '), table('|signed mean|'), table('RMS of each term')
    accelerations, recordings = table('RMS of e [N m] by'), table('RMS of e per recording')
    assert size['joint'] == ['RMS', 'mean |e|', 'correlation']
    assert terms['joint'] == ['inertial', 'Coriolis', 'gravity', 'spring', 'friction', 'other']
    assert accelerations['joint'] == ['first difference', 'live', 'aligned']
    ours = first.methods['lagrange_euler']
    for i, joint in enumerate(JOINTS):
        correlation = '–' if joint == 'w2' else f'{ours.correlation[i]:.3f}'
        assert size[joint] == [f'{ours.rms[i]:.3f}', f'{ours.mean_abs[i]:.3f}', correlation]
        paper = [f'{TABLE_V[method][k][i]:.4f}' for k in range(3) for method in METHODS]
        assert five[joint] == [f'{abs(ours.signed_mean[i]):.4f}', *paper]
        assert terms[joint] == [f'{first.shares[term][i]:.3f}' for term in TERMS]
        assert accelerations[joint] == [f'{first.estimators[name].rms[i]:.3f}'
                                        for name in ESTIMATORS]
    assert five['sum'] == [f'{ours.signed_mean.sum():.4f}', *(
        f'{TABLE_V_SUM[method][k]:.4f}' for k in range(3) for method in METHODS)]
    assert recordings['no effort'] == ['20.0', *'–––––––']


def test_verdict_advice_and_warnings_come_first(pages):
    before, _, after = pages['evaluation'].text.partition('Summary')
    assert before.index('Larger than <calibrated>.') < before.index(
        'What to do next Calibrate: baxter_dynamics calibrate "a&b"') < before.index('2 warnings')
    assert 'too short: nothing could be predicted' in before
    assert 'no valid measured effort, so the figures show the prediction alone' in after
    assert 'Nothing could be predicted' in after
    assert 'differ by up to 0.002 N m, which they should not' in after
    assert re.search(r'not_this_arm\s*5', after)


def test_findings_of_an_evaluation(evaluate):
    one = evaluate()
    found = sentences(evaluation_report, one)
    assert 's0 (0.50 N m), s1 (−0.25 N m)' in found['Offset']
    assert found['Not in the model'].endswith('at w2.')
    expected = Expected(np.array([0.2, 0.2, *5 * [0.01]]), np.ones(7))
    found = sentences(evaluation_report, replace(one, expected=expected))
    assert 'offset at s0 (0.50 N m). ' in found['Offset']  # that of s1 is expected
