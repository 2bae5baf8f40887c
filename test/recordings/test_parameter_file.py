"""Parameter files: round trip, and refusals in one line."""

import os
import re
import time

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import pytest

yaml = pytest.importorskip('yaml', reason='parameter files need PyYAML: pip install pyyaml')

from baxter_dynamics_ros.recordings.parameter_file import (  # noqa: E402, I100
    ParameterFileError, read_parameters, write_parameters)

HEAD = '/**:\n  ros__parameters:\n'


def test_every_setting_round_trips_with_seven_digits(tmp_path, all_changed):
    write_parameters(tmp_path / 'p.yaml', all_changed)
    values = read_parameters(tmp_path / 'p.yaml')
    assert set(values) == set(DEFAULTS)
    for name, wanted in all_changed.parameters().items():
        found = values[name]
        if isinstance(wanted, tuple):
            assert found == [float(f'{x:.7g}') for x in wanted] != list(wanted), name
        elif isinstance(wanted, float):
            assert found == float(f'{wanted:.7g}') != wanted, name
        else:
            assert found == wanted, name
    PredictorSettings.from_parameters(values)


def test_only_the_arm_and_changed_settings_are_written(tmp_path):
    path = tmp_path / 'p.yaml'
    write_parameters(path, PredictorSettings())
    assert read_parameters(path) == {'arm': 'right'}
    write_parameters(path, PredictorSettings(arm='left').replace({'payload.mass': 0.25}))
    assert read_parameters(path) == {'arm': 'left', 'payload.mass': 0.25}
    assert yaml.safe_load(path.read_text()) == {
        '/**': {'ros__parameters': {'arm': 'left', 'payload': {'mass': 0.25}}}}


@pytest.mark.parametrize('mass', [1.0, 10.0, 1e-5, 1e-9, 1.5e-12, 0.1 + 0.2, 9.99999999])
def test_numbers_have_a_decimal_point(tmp_path, mass):
    """Without one, ROS takes them for integers and refuses them."""
    path = tmp_path / 'p.yaml'
    write_parameters(path, PredictorSettings.from_parameters(
        {'payload.mass': mass, 'gravity': (mass, -mass, 0.0)}))
    assert read_parameters(path) == {
        'arm': 'right', 'payload.mass': pytest.approx(mass, rel=1e-6),
        'gravity': pytest.approx([mass, -mass, 0.0], rel=1e-6)}
    assert all('.' in number for number in re.findall(r'-?\d[\d.e+-]*', path.read_text()))


@pytest.mark.parametrize('comment', [
    'plain', '', ' indented: {', '# twice', '---', '%YAML 9.9', 'tab\there', 'two\nb: {lines',
    'return\rb: [', 'next\x85b: [', 'separator\u2028b: [', 'bell\a', 'nothing\0', 'escape\x1b[0m',
    'mark\ufeff', 'café Ωm 😀', 'no text\udce9', 'x' * 5000,
    'b\n/**:\n  ros__parameters:\n    arm: middle'], ids=lambda comment: ascii(comment[:12]))
def test_comments_of_any_kind_stay_comments(tmp_path, comment):
    path = tmp_path / 'p.yaml'
    write_parameters(path, PredictorSettings(arm='left'), ['first', comment, 'last'])
    assert read_parameters(path) == {'arm': 'left'}
    lines = path.read_text(encoding='utf-8').split('\n')
    assert (lines[0], lines[2], lines[3]) == ('# first', '# last', '/**:')
    assert lines[1].startswith('#') and lines[1].rstrip() == lines[1]
    if comment.isprintable():
        assert lines[1] == f'# {comment}'.rstrip()


@pytest.mark.parametrize('text, problem', [
    ('a: {', 'invalid YAML at line 2: '), (b'\xff', 'invalid YAML'), ('[' * 9000, 'invalid YAML'),
    ('&a [*a]', 'aliases are not supported, at line 1'),
    ('[' * 9000 + ']' * 9000, ''),
    (HEAD + '    payload: {mas: 1.0}',
     'payload.mas: no such parameter; did you mean payload.mass?'),
    (HEAD + '    arm: middle', "arm: expected one of right, left, got 'middle'"),
    (HEAD + '    payload: {mass: 1}', 'payload.mass: expected a number with a decimal point'),
    (HEAD + '    payload: {mass: -1.0}', 'payload.mass: expected a value in [0, 10] kg, got -1'),
    (HEAD + '    payload: {mass: ' + '9' * 5000 + '}', 'payload.mass: expected'),
    (HEAD + '    payload: {mass: !!float abc}', 'payload.mass: expected a number'),
    (HEAD + '    payload: {mass: 2001-01-01}', 'payload.mass: expected a number with'),
    (HEAD + '    gravity: [0.0, 0.0]', 'gravity: expected shape (3,), got (2,)'),
    (HEAD + ''.join(f'    &a{i} x{i}: [*a{i - 1}, *a{i - 1}]\n' for i in range(1, 40)),
     'aliases are not supported, at line 3'),
    (HEAD + ''.join(f'    p{i}: 1\n' for i in range(8_000)), None),
    (b' ' * 300_000, '300000 bytes is too large for a parameter file'),
], ids=lambda value: ascii(value[-20:]) if value else 'many')
def test_bad_files_are_refused_in_a_line_within_a_second(tmp_path, text, problem):
    path = tmp_path / 'p.yaml'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    start = time.process_time()
    if problem is None:
        lines = []
        assert read_parameters(path, warn=lines.append) == {} and len(lines) == 1
    else:
        with pytest.raises(ParameterFileError) as caught:
            read_parameters(path)
        assert str(caught.value).startswith(f'{path}: {problem}')
        assert '\n' not in str(caught.value) and len(str(caught.value)) < 300
    assert time.process_time() - start < 1.0


def test_only_readable_regular_files_are_read(tmp_path, closed):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'small').write_text('')
    with closed(tmp_path / 'small'):
        for path, reason in {tmp_path / 'pipe': 'is not a file', tmp_path: 'is not a file',
                             '/dev/zero': 'is not a file',
                             tmp_path / 'none': 'cannot be read .No such file',
                             tmp_path / 'small': 'cannot be read .Permission denied'}.items():
            with pytest.raises(BaxterDynamicsError, match=f'^{path}: {reason}'):
                read_parameters(path)


def test_ignored_parameters_are_reported(tmp_path):
    (tmp_path / 'p.yaml').write_text(HEAD + '    publish_rate: 50.0\n    arm: left\n')
    (tmp_path / 'q.yaml').write_text('/r/torque_predictor:\n  ros__parameters: {arm: left}\n')
    lines = []
    assert read_parameters(tmp_path / 'p.yaml', warn=lines.append) == {'arm': 'left'}
    assert read_parameters(tmp_path / 'q.yaml', warn=lines.append) == {}
    assert lines == [
        f'{tmp_path}/p.yaml: ignoring publish_rate: not parameters of the predictor',
        f'{tmp_path}/q.yaml: no parameters for /torque_predictor, only for /r/torque_predictor: '
        'using the defaults']
