"""The evaluation report: its page, figures and numbers, from known signals."""

import base64
import csv
from dataclasses import replace
import json
import re

from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.model.paper_tables import TABLE_V, TABLE_V_SUM
from baxter_dynamics_ros.recordings.advice import Advice, Assessment, Verdict
from baxter_dynamics_ros.recordings.contact_intervals import Contact
from baxter_dynamics_ros.recordings.evaluation_results import (ESTIMATORS, Expected, METHODS,
                                                               TERMS)
import numpy as np
import pytest
from report.pages import HOSTILE, Page

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')


@pytest.fixture(scope='module')
def page(evaluation_folder):
    """Return the page."""
    return Page(evaluation_folder / 'report.html')


@pytest.fixture(scope='module')
def summary(evaluation_folder):
    """Return the contents of summary.json."""
    return loads((evaluation_folder / 'summary.json').read_text(encoding='utf-8'))


@pytest.fixture(scope='module')
def first(evaluate):
    """Return the evaluation of the first recording."""
    return evaluate(HOSTILE)


def loads(text):
    def refuse(constant):
        raise AssertionError(f'{constant} is not JSON')
    return json.loads(text, parse_constant=refuse)


def test_files(evaluation_folder, page):
    assert {path.name for path in evaluation_folder.iterdir()} == {
        'figures', 'notes.txt', 'report.html', 'summary.csv', 'summary.json'}
    assert (evaluation_folder / 'notes.txt').read_text() == 'mine'
    figures = {path.name: path.read_bytes() for path in (evaluation_folder / 'figures').iterdir()}
    assert figures.keys() == {f'{start}_effort_{joint}.svg' for joint in JOINTS
                              for start in ('01_script_alert_x_script_a_b', '02_no_effort')}
    inline = [base64.b64decode(address.partition(',')[2]) for address in page.addresses
              if address.startswith('data:')]
    assert sorted(inline) == sorted(figures.values())


def test_page_is_self_contained_and_escapes_names(page):
    page.check_self_contained()
    assert '&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt; &amp; ' in page.html
    for text in (HOSTILE.replace('\udcff', '?'), 'stamps <look> like', 'evaluate "a&b" <c>',
                 'my.yaml'):
        assert text in page.text


def test_summary_json(summary, first):
    one, two, three = summary['recordings']
    assert summary['joints'] == list(JOINTS)
    assert (summary['arm'], summary['command']) == ('right', 'evaluate "a&b" <c>')
    assert one['name'] == HOSTILE.replace('\udcff', '?')
    assert one['warnings'] == ['stamps <look> like times of arrival']
    assert one['notices'] == [{'kind': 'test', 'joints': [], 'text': one['warnings'][0]}]
    assert (one['counts']['not_this_arm'], one['duration'], one['rate']) == (5, 20.0, 50.0)
    for found in (summary, one):
        for method in METHODS:
            errors = first.methods[method]
            assert found[method]['count'] == errors.count == 950
            for name in ('rms', 'mean_abs', 'signed_mean'):
                assert found[method][name] == getattr(errors, name).tolist()
            assert found[method]['correlation'] == [*errors.correlation[:6], None]
        assert {name: errors['rms'] for name, errors in found['estimators'].items()} == {
            name: first.estimators[name].rms.tolist() for name in ESTIMATORS}
        assert found['shares'] == {term: first.shares[term].tolist() for term in TERMS}
    assert two['newton_euler']['rms'] == three['shares']['gravity'] == [None] * 7


def test_summary_json_has_contacts_and_assessment(first):
    from baxter_dynamics_ros.report.summary import summary_json
    contact = Contact('e0', 1.0, 2.0, 8.1, True)
    assessment = Assessment(Verdict('uncalibrated', 'x'), (Advice('zero', 'y', 'z'),))
    found = loads(summary_json([replace(first, contacts=(contact,))], first, assessment, '', ''))
    assert found['recordings'][0]['contacts'] == [contact._asdict()]
    assert found['verdict']['kind'] == 'uncalibrated' and found['advice'][0]['command'] == 'z'


def test_summary_csv(evaluation_folder, first):
    path = evaluation_folder / 'summary.csv'
    assert path.read_bytes().startswith(b'\xef\xbb\xbf')
    with path.open(encoding='utf-8-sig', newline='') as file:
        rows = list(csv.reader(file))
    assert rows[0] == ['recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
                       'mean_abs [N m]', 'signed_mean [N m]', 'correlation']
    assert len(rows) == 1 + 3 * len(METHODS) * len(JOINTS)
    s1 = rows[1 + len(JOINTS) + 1]
    assert s1[0].startswith("'=")  # not a formula
    assert s1[1:6] == ['/robot/joint_states', 'right', 'newton_euler', 's1', '950']
    assert [float(cell) for cell in s1[6:]] == [
        column[1] for column in first.methods['newton_euler'][1:]]
    assert rows[7][-1] == ''  # no correlation at w2
    assert rows[-1] == ['too short', '/robot/joint_states', 'right', 'newton_euler', 'w2', '0',
                        '', '', '', '']


def test_tables(page, first):
    size, five = page.table('Error e = '), page.table('|signed mean|')
    terms, accelerations = page.table('RMS of each term'), page.table('RMS of e [N m] by')
    recordings = page.table('RMS of e per recording')
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
    assert recordings[HOSTILE.replace('\udcff', '?')][1:] == [f'{x:.3f}' for x in ours.rms]


def test_two_columns_where_the_methods_differ(evaluate):
    from baxter_dynamics_ros.report.evaluation_tables import size_table, table_five
    apart = evaluate(apart=1e-6)
    assert [column.label for column in size_table(apart).columns] == 3 * ['L-E', 'N-E']
    assert [column.group for column in table_five(apart).columns][:3] == [
        'here', 'here', 'paper, set 1']
    assert len(size_table(evaluate(apart=1e-10)).columns) == 3


def test_verdict_advice_and_warnings_come_first(page):
    before, _, _ = page.text.partition('Summary')
    assert before.index('Larger than <calibrated>.') < before.index(
        'What to do next Calibrate: baxter_dynamics calibrate "a&b"') < before.index('2 warnings')
    assert '2 warnings' in before and 'too short: nothing could be predicted' in before


def test_sections_of_recordings(page):
    sections = [attributes for tag, attributes in page.elements
                if tag == 'details' and attributes.get('class') == 'recording']
    assert ['open' in attributes for attributes in sections] == [True, False, False]
    assert 'no valid measured effort, so the figures show the prediction alone' in page.text
    assert 'Nothing could be predicted' in page.text
    assert re.search(r'not_this_arm\s*5', page.text)


def test_findings(evaluate, too_short):
    from baxter_dynamics_ros.report.evaluation_findings import RULES
    from baxter_dynamics_ros.report.findings import findings
    one = evaluate()
    text = {topic: text.replace('\u00a0', ' ') for topic, text in findings(RULES, one)}
    assert 's0 (0.50 N m), s1 (−0.25 N m)' in text['Offset']
    assert text['Not in the model'].endswith('at w2.')
    expected = Expected(np.array([0.2, 0.2, *5 * [0.01]]), np.ones(7))
    text = dict(findings(RULES, replace(one, expected=expected)))
    assert 'offset at s0 (0.50\u00a0N\u00a0m). ' in text['Offset']  # that of s1 is expected
    assert findings(RULES, too_short) == []
