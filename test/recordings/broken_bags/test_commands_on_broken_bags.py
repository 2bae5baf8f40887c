"""Commands given broken bags: one line, exit code 1, and no output."""

import re

import pytest


def test_a_broken_bag_is_one_line_and_nothing_is_written(refused, broken_bag):
    for name, *options in (['evaluate', '--output', 'report', '--save-bag', 'new'], ['calibrate']):
        line = refused(name, broken_bag.path, *options)
        assert re.search(broken_bag.pattern, line), line


@pytest.mark.parametrize('name', ['evaluate', 'calibrate'])
def test_a_good_bag_before_it_changes_nothing(refused, make_bag, states, name):
    good, broken = make_bag(states(30)), make_bag(states(30), name='broken')
    (broken / 'metadata.yaml').unlink()
    assert refused(name, good, broken).startswith(f'{broken}: has no metadata.yaml')


def test_nothing_is_left_of_a_bag_that_fails_half_way(refused, make_bag, states):
    path = make_bag(states(3000))
    file = path / 'run.mcap'
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle:middle + 4000] = bytes([255]) * 4000
    file.write_bytes(data)
    assert refused('evaluate', path, '--save-bag', 'new').startswith(f'{path}')


def test_mcap_without_summary_is_evaluated(command, bag_without_summary, tmp_path):
    path, _ = bag_without_summary
    code, _, err = command('evaluate', path, '--output', tmp_path / 'report')
    assert (code, err) == (0, '')
    assert (tmp_path / 'report' / 'report.html').is_file()
