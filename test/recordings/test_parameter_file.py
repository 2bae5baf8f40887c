"""Parameter files come back as they were written, are ROS's kind of YAML, and are whole."""

import os
import re
import resource
import stat

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import pytest

yaml = pytest.importorskip('yaml', reason='parameter files need PyYAML: pip install pyyaml')

from baxter_dynamics_ros.recordings.parameter_file import (  # noqa: E402, I100
    ParameterFileError, read_parameters, write_parameters)

HEAD = '/**:\n  ros__parameters:\n'


def test_every_setting_comes_back_with_seven_digits(tmp_path, all_changed):
    write_parameters(tmp_path / 'p.yaml', all_changed)
    values = read_parameters(tmp_path / 'p.yaml')
    assert set(values) == set(DEFAULTS)
    for name, wanted in all_changed.items():
        found = values[name]
        if isinstance(wanted, tuple):
            assert found == [float(f'{x:.7g}') for x in wanted] != list(wanted), name
        elif isinstance(wanted, float):
            assert found == float(f'{wanted:.7g}') != wanted, name
        else:
            assert found == wanted, name
    PredictorSettings(values)


def test_what_has_its_default_is_not_written_but_for_the_arm(tmp_path):
    path = tmp_path / 'p.yaml'
    write_parameters(path, dict(DEFAULTS))
    assert read_parameters(path) == {'arm': 'right'}
    write_parameters(path, {**DEFAULTS, 'arm': 'left', 'payload.mass': 0.25})
    assert read_parameters(path) == {'arm': 'left', 'payload.mass': 0.25}
    assert yaml.safe_load(path.read_text()) == {
        '/**': {'ros__parameters': {'arm': 'left', 'payload': {'mass': 0.25}}}}


@pytest.mark.parametrize('mass', [1.0, 10.0, 1e-5, 1e-9, 1.5e-12, 0.1 + 0.2, 9.99999999])
def test_numbers_have_a_decimal_point(tmp_path, mass):
    """Or else ROS takes them for integers and refuses them."""
    path = tmp_path / 'p.yaml'
    write_parameters(path, {**DEFAULTS, 'payload.mass': mass,
                            'gravity': (mass, -mass, 0.0)})
    parameters = yaml.safe_load(path.read_text())['/**']['ros__parameters']
    for number in (parameters['payload']['mass'], *parameters['gravity']):
        assert type(number) is float
        assert abs(number) == pytest.approx(mass, rel=1e-6) or number == 0.0
    for number in re.findall(r'-?\d[\d.e+-]*', path.read_text()):
        assert '.' in number


def test_all_numbers_of_all_settings_have_one_but_counts(tmp_path, all_changed):
    write_parameters(tmp_path / 'p.yaml', all_changed)
    written = yaml.safe_load((tmp_path / 'p.yaml').read_text())['/**']['ros__parameters']
    for name, default in DEFAULTS.items():
        value = written
        for part in name.split('.'):
            value = value[part]
        kinds = {type(x) for x in value} if isinstance(value, list) else {type(value)}
        assert kinds == {float if isinstance(default, tuple) else type(default)}, name


@pytest.mark.parametrize('comment', [
    'plain', '', ' indented: {', '# twice', '---', '%YAML 9.9', 'tab\there', 'two\nb: {lines',
    'return\rb: [', 'next\x85b: [', 'separator\u2028b: [', 'bell\a', 'nothing\0', 'escape\x1b[0m',
    'mark\ufeff', 'café Ωm 😀', 'no text\udce9', 'x' * 5000,
    'b\n/**:\n  ros__parameters:\n    arm: middle'], ids=lambda comment: ascii(comment[:12]))
def test_comments_of_any_kind_stay_comments(tmp_path, comment):
    path = tmp_path / 'p.yaml'
    write_parameters(path, {**DEFAULTS, 'arm': 'left'}, ['first', comment, 'last'])
    assert read_parameters(path) == {'arm': 'left'}
    lines = path.read_text(encoding='utf-8').split('\n')
    assert (lines[0], lines[2], lines[3]) == ('# first', '# last', '/**:')
    assert lines[1].startswith('#') and lines[1].rstrip() == lines[1]
    if comment.isprintable():
        assert lines[1] == f'# {comment}'.rstrip()


@pytest.mark.parametrize('text, values', [
    ('torque_predictor:\n  ros__parameters: {arm: left}', {'arm': 'left'}),
    ('/robot/torque_predictor:\n  ros__parameters: {arm: left}', {'arm': 'left'}),
    ('/*:\n  ros__parameters: {payload.mass: 1.0}', {'payload.mass': 1.0}),
    (HEAD + '    payload: {mass: 1.0}\nother:\n  ros__parameters: {rate: 5}',
     {'payload.mass': 1.0}),
    (HEAD + '    arm: right\n    payload: {mass: 1.0}\ntorque_predictor:\n  ros__parameters: '
     '{arm: left}', {'arm': 'left', 'payload.mass': 1.0}),
    (HEAD + '    arm: left\n    use_sim_time: true\n    qos_overrides:\n      '
     '/robot/joint_states: {subscription: {depth: 10}}', {'arm': 'left'}),
])
def test_files_by_hand_are_read_as_the_node_would(tmp_path, text, values):
    (tmp_path / 'p.yaml').write_text(text)
    assert read_parameters(tmp_path / 'p.yaml') == values


NONE = 'no parameters of torque_predictor; expected'
NO_YAML = 'cannot be read as a parameter file ('


@pytest.mark.parametrize('text, problem', [
    ('', NONE), ('hello', NONE), ('[1, 2]', NONE), ('/**: 3', NONE), (HEAD, NONE),
    (HEAD + '    - 1', NONE), ('other:\n  ros__parameters: {arm: left}', NONE),
    (HEAD + '    use_sim_time: true', NONE),
    ('a: {', NO_YAML), ('a: b: c', NO_YAML), ('\a', NO_YAML), (b'\xff\xfe', NO_YAML),
    ('!!python/object:os.system x', NO_YAML), ('[' * 1500, NO_YAML),
    ('/**: &a\n  ros__parameters: &b {payload: *b}', NO_YAML),
    (HEAD + '    payload: {mas: 1.0}', 'payload.mas: unknown setting; known are arm, '),
    (HEAD + '    3: 4', '3: unknown setting'),
    (HEAD + '    arm: middle', "arm: expected one of right, left, got 'middle'"),
    (HEAD + '    align: 1', 'align: expected true or false, got 1'),
    (HEAD + '    payload: {mass: -1.0}', 'payload.mass: expected a value in [0, 10] kg, got -1'),
    (HEAD + '    payload: {mass: heavy}', 'payload.mass: expected real numbers'),
    (HEAD + '    payload: {mass: null}', 'payload.mass: expected real numbers'),
    (HEAD + '    payload: {mass: 2001-01-01}', 'payload.mass: expected real numbers'),
    (HEAD + '    gravity: [0.0, 0.0]', 'gravity: expected shape (3,), got (2,)'),
    (HEAD + '    gravity: [0.0, 0.0, .nan]', 'gravity: expected finite values'),
    (HEAD + '    payload: {inertia: [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]}', 'payload.'),
], ids=lambda value: ascii(value[-20:]))
def test_what_is_wrong_is_one_line_with_the_path(tmp_path, text, problem):
    path = tmp_path / 'p.yaml'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ParameterFileError) as caught:
        read_parameters(path)
    line = str(caught.value)
    assert '\n' not in line
    assert line.startswith(f'{path}: {problem}')


def test_what_is_no_file_is_one_line(tmp_path):
    for path in (tmp_path / 'none.yaml', tmp_path):
        with pytest.raises(BaxterDynamicsError, match=f'^{path}: cannot be read as a parameter'):
            read_parameters(path)


def test_a_file_without_rights_is_one_line(tmp_path, closed):
    path = tmp_path / 'p.yaml'
    path.write_text('')
    with closed(path):
        with pytest.raises(ParameterFileError, match='Permission denied'):
            read_parameters(path)


def test_places_that_cannot_be_written_are_one_line(tmp_path, closed):
    folder = tmp_path / 'locked'
    folder.mkdir()
    with closed(folder, 0o555):
        with pytest.raises(ParameterFileError) as caught:
            write_parameters(folder / 'p.yaml', dict(DEFAULTS))
    assert str(caught.value) == f'{folder}/p.yaml: cannot be written (Permission denied)'
    path = tmp_path / 'none' / 'p.yaml'
    with pytest.raises(ParameterFileError, match=f'^{path}: cannot be written .No such file'):
        write_parameters(path, dict(DEFAULTS))
    with pytest.raises(ParameterFileError, match=f'^{folder}: cannot be written .Is a directory'):
        write_parameters(folder, dict(DEFAULTS))
    assert sorted(tmp_path.rglob('*')) == [folder]


@pytest.mark.parametrize('before', [None, 'what was there'])
def test_a_full_disk_leaves_what_was_there(tmp_path, before):
    """As a limit to the size of files has it, to which writing fails alike."""
    path = tmp_path / 'p.yaml'
    if before:
        path.write_text(before)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))  # bytes
    try:
        with pytest.raises(ParameterFileError, match=f'^{path}: cannot be written .*large'):
            write_parameters(path, dict(DEFAULTS), ['x' * 100] * 200)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [left.read_text() for left in tmp_path.iterdir()] == ([before] if before else [])


def test_a_file_is_replaced_and_others_may_read_it(tmp_path):
    path = tmp_path / 'p.yaml'
    path.write_text('old')
    os.chmod(path, 0o600)
    write_parameters(path, {**DEFAULTS, 'arm': 'left'})
    assert read_parameters(path) == {'arm': 'left'}
    assert stat.S_IMODE(path.stat().st_mode) == 0o644
    assert [left.name for left in tmp_path.iterdir()] == ['p.yaml']
