"""The evaluation report: its page, its files and its numbers, from signals that are known."""

import base64
import csv
from dataclasses import replace
from html.parser import HTMLParser
import json
import re

from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.model.paper_tables import TABLE_V, TABLE_V_SUM
from baxter_dynamics_ros.recordings.evaluation_results import ESTIMATORS, METHODS, TERMS
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

HOSTILE = '=<script>alert("x")</script> & \'../a b\'\udcff'
WARNING = 'stamps <look> like times of arrival'


@pytest.fixture(scope='module')
def one(evaluate):
    """Return the evaluation of one recording, whose name means harm."""
    return evaluate(HOSTILE, warnings=[WARNING])


@pytest.fixture(scope='module')
def single(one, tmp_path_factory):
    """Return the folder of the report on it."""
    from baxter_dynamics_ros.report.evaluation_report import write_evaluation
    folder = tmp_path_factory.mktemp('single') / 'new' / 'report'
    write_evaluation(folder, [one], one, 'evaluate "a&b" <c>', 'my.yaml')
    return folder


@pytest.fixture(scope='module')
def several(evaluate, too_short, tmp_path_factory):
    """Return the folder of the report on three recordings, written over what was there."""
    from baxter_dynamics_ros.report.evaluation_report import Total, write_evaluation
    folder = tmp_path_factory.mktemp('several')
    (folder / 'notes.txt').write_text('mine')
    (folder / 'report.html').write_text('old')
    first = evaluate('first')
    total = Total('right', first.methods, first.estimators, first.shares)
    write_evaluation(folder, [first, evaluate('no effort', effort=False), too_short], total,
                     'evaluate', 'defaults of the package')
    return folder


class Page(HTMLParser):
    """What a page holds: its elements, addresses, tables, and text with single spaces."""

    def __init__(self, folder):
        super().__init__()
        self.html = (folder / 'report.html').read_text(encoding='utf-8')
        self.elements, self.tables, self.text, self._cell = [], [], '', None
        self.feed(self.html)
        self.text = ' '.join(self.text.split())
        self.addresses = [attributes[name] for _, attributes in self.elements
                          for name in ('src', 'href') if name in attributes]

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag in ('caption', 'tr'):
            self.tables += [[]] if tag == 'caption' else []
            self.tables[-1].append([])
        if tag in ('caption', 'td', 'th'):
            self._cell = ''

    def handle_endtag(self, tag):
        if tag in ('caption', 'td', 'th'):
            self.tables[-1][-1].append(self._cell.strip())
            self._cell = None

    def handle_data(self, data):
        if self.elements and self.elements[-1][0] != 'style':
            self.text += data
        if self._cell is not None:
            self._cell += data

    def table(self, caption):
        """Return row's name -> its other cells, of the table whose caption begins so."""
        (_, *rows), = (table for table in self.tables if table[0][0].startswith(caption))
        return {row[0]: row[1:] for row in rows}


def loads(path):
    def refuse(constant):
        raise AssertionError(f'{constant} is not JSON')
    return json.loads(path.read_text(encoding='utf-8'), parse_constant=refuse)


def csv_rows(path):
    with path.open(encoding='utf-8-sig', newline='') as file:
        return list(csv.reader(file))


def test_the_files(single):
    kinds = ['terms', *(f'{kind}_{joint}' for kind in ('effort', 'acceleration')
                        for joint in JOINTS)]
    expected = {f'figures/01_script_alert_x_script_a_b_{kind}.svg' for kind in kinds}
    expected |= {'report.html', 'summary.csv', 'summary.json'}
    assert {path.relative_to(single).as_posix() for path in single.rglob('*')
            if path.is_file()} == expected
    assert [path.name for path in single.parent.iterdir()] == ['report']
    assert (single / 'report.html').stat().st_size < 3e6


def test_the_page_refers_to_nothing_outside_its_folder(single, several):
    for folder in (single, several):
        page = Page(folder)
        ids = [attributes.get('id') for _, attributes in page.elements]
        assert len(page.addresses) >= 30
        for address in page.addresses:
            if address.startswith('#'):
                assert address[1:] in ids
            elif not address.startswith('data:image/svg+xml;base64,'):
                assert (folder / address).is_file(), address
        assert "default-src 'none'" in page.html
        assert not re.search(r'url\(|@import|https?:', page.html)


def test_the_figures_of_the_page_are_the_files(single):
    inlined = [base64.b64decode(address.partition(',')[2]) for address in Page(single).addresses
               if address.startswith('data:')]
    assert sorted(inlined) == sorted(p.read_bytes() for p in (single / 'figures').iterdir())


def test_names_are_text_and_never_markup(single):
    page = Page(single)
    assert '&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt; &amp; ' in page.html
    assert [tag for tag, _ in page.elements].count('script') == 1
    for text in (HOSTILE.replace('\udcff', '?'), WARNING, 'evaluate "a&b" <c>', 'my.yaml'):
        assert text in page.text


def test_summary_json(single, one):
    summary = loads(single / 'summary.json')
    recording, = summary['recordings']
    assert summary['joints'] == list(JOINTS)
    assert (summary['arm'], summary['command']) == ('right', 'evaluate "a&b" <c>')
    assert recording['name'] == HOSTILE.replace('\udcff', '?')
    assert recording['warnings'] == [WARNING]
    assert recording['counts']['not_this_arm'] == 5
    assert (recording['duration'], recording['rate']) == (20.0, 50.0)
    for found in (summary, recording):
        for method in METHODS:
            errors = one.methods[method]
            assert found[method]['count'] == errors.count == 950
            for name in ('rms', 'mean_abs', 'signed_mean'):
                assert found[method][name] == getattr(errors, name).tolist()
            assert found[method]['correlation'] == [*errors.correlation[:6], None]
        for estimator in ESTIMATORS:
            assert found['estimators'][estimator]['rms'] == one.estimators[estimator].rms.tolist()
        assert found['shares'] == {term: one.shares[term].tolist() for term in TERMS}


def test_summary_csv(single, several, evaluate):
    rows = csv_rows(several / 'summary.csv')
    assert rows[0] == ['recording', 'topic', 'arm', 'method', 'joint', 'samples', 'rms [N m]',
                       'mean_abs [N m]', 'signed_mean [N m]', 'correlation']
    assert len(rows) == 1 + 3 * len(METHODS) * len(JOINTS)
    errors = evaluate().methods['newton_euler']
    s1 = rows[1 + len(JOINTS) + 1]
    assert s1[:6] == ['first', '/robot/joint_states', 'right', 'newton_euler', 's1', '950']
    assert [float(cell) for cell in s1[6:]] == [column[1] for column in errors[1:]]
    assert rows[-1] == ['too short', '/robot/joint_states', 'right', 'newton_euler', 'w2', '0',
                        '', '', '', '']
    assert {row[0][:2] for row in csv_rows(single / 'summary.csv')[1:]} == {"'="}  # no formula
    assert (single / 'summary.csv').read_bytes().startswith(b'\xef\xbb\xbf')


def test_what_is_no_number_is_null_an_empty_cell_and_a_dash(several):
    summary = loads(several / 'summary.json')
    assert summary['recordings'][1]['newton_euler']['rms'] == [None] * 7
    assert summary['recordings'][2]['shares']['gravity'] == [None] * 7
    assert csv_rows(several / 'summary.csv')[7][-1] == ''
    page = Page(several)
    assert page.table('Size of the error, measured − predicted effort [N m], all')['w2'][-1] == '–'
    assert page.table('RMS of the error per recording')['no effort'] == ['20.0', *'–––––––']


def test_table_five_and_the_size_of_the_error_are_two_tables(single, one):
    page = Page(single)
    five, size = page.table('|signed mean|'), page.table('Size of the error')
    assert 'says nothing of noise' in page.text
    ours = one.methods['lagrange_euler']
    for i, joint in enumerate(JOINTS):
        papers = [f'{TABLE_V[method][k][i]:.4f}' for k in range(3) for method in METHODS]
        assert five[joint] == [f'{abs(ours.signed_mean[i]):.4f}'] * 2 + papers
        assert size[joint][:4] == [f'{ours.rms[i]:.3f}'] * 2 + [f'{ours.mean_abs[i]:.3f}'] * 2
        if joint != 'w2':
            assert size[joint][4:] == [f'{ours.correlation[i]:.3f}'] * 2
    papers = [f'{TABLE_V_SUM[method][k]:.4f}' for k in range(3) for method in METHODS]
    assert five['sum'] == [f'{ours.signed_mean.sum():.4f}'] * 2 + papers


def test_tables_of_terms_accelerations_and_counts(single, one):
    page = Page(single)
    terms, accelerations = page.table('RMS of each term'), page.table('RMS of the error')
    assert terms['joint'] == ['inertial', 'Coriolis', 'gravity', 'spring', 'friction', 'other']
    assert accelerations['joint'] == ['first difference', 'live', 'aligned']
    for i, joint in enumerate(JOINTS):
        assert terms[joint] == [f'{one.shares[term][i]:.3f}' for term in TERMS]
        assert accelerations[joint] == [f'{one.estimators[name].rms[i]:.3f}'
                                        for name in ESTIMATORS]
    assert page.table('Messages counted')['not_this_arm'] == ['5']


def test_warnings_come_first_or_none_are_said(single, several):
    text, before, _ = Page(single).text.partition('In short')
    assert '1 warning ' + WARNING in text
    text, _, after = Page(several).text.partition('In short')
    assert '1 of 3 recordings with warnings too short: nothing could be predicted' in text
    assert after.count('Warnings: none') == 2
    assert after.count('1 warning nothing could be predicted') == 1


def test_several_recordings(several, evaluate):
    page = Page(several)
    recordings = [attributes for tag, attributes in page.elements
                  if tag == 'details' and attributes['class'] == 'recording']
    assert ['open' in attributes for attributes in recordings] == [True, False, False]
    table = page.table('RMS of the error per recording')
    rms = evaluate().methods['lagrange_euler'].rms
    assert table['first'] == ['20.0', *(f'{value:.3f}' for value in rms)]
    assert 'This recording holds no valid measured effort' in page.text
    assert 'Nothing could be predicted, so there is nothing to show' in page.text
    assert len(list((several / 'figures').glob('01_first_*.svg'))) == 15
    assert len(list((several / 'figures').glob('02_no_effort_*.svg'))) == 8  # no errors
    assert len(list((several / 'figures').iterdir())) == 15 + 8


def test_a_recording_judged_without_alignment_has_two_accelerations(tmp_path, one):
    from baxter_dynamics_ros.report.evaluation_report import write_evaluation
    live = replace(one, estimators={name: one.estimators[name] for name in ESTIMATORS[:2]})
    write_evaluation(tmp_path, [live], live, '', '')
    assert Page(tmp_path).table('RMS of the error')['joint'] == ['first difference', 'live']
    assert loads(tmp_path / 'summary.json')['estimators']['butterworth_aligned']['count'] == 0


def test_an_existing_folder_keeps_what_else_is_in_it(several):
    assert (several / 'notes.txt').read_text() == 'mine'
    assert Page(several).html.startswith('<!DOCTYPE html>')
    assert {path.name for path in several.iterdir()} == {
        'figures', 'notes.txt', 'report.html', 'summary.csv', 'summary.json'}


@pytest.mark.parametrize('value, text', [
    (1.23456, '1.235'), (-0.5, '−0.500'), (0.0, '0'), (-0.0001, '0.000'), (float('nan'), '–'),
    (float('-inf'), '–')])
def test_numbers(value, text):
    from baxter_dynamics_ros.report.page import number
    assert number(value) == text
