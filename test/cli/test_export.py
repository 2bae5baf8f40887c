"""The command export: what it writes where, what it refuses, and the table that it prints."""

import os
import subprocess
import sys

from baxter_dynamics_ros import __version__, BaxterArm, Payload
import numpy as np
import pytest

pytest.importorskip('casadi', reason='needs CasADi: pip install casadi')

from baxter_dynamics_ros.export.base_table import base_table  # noqa: E402, I100
from baxter_dynamics_ros.export.functions import DEFAULT_SYMBOLS  # noqa: E402

FILES = {
    'c': ['baxter_dynamics.c', 'baxter_dynamics.h', 'example.c'],
    'python': ['baxter_dynamics.py'],
    'numba': ['baxter_dynamics_numba.py'],
    'matlab': ['baxter_dynamics_gravity.m', 'baxter_dynamics_parameters.m'],
    'casadi': ['baxter_dynamics_casadi.py'],
    'sympy': ['baxter_dynamics_sympy.py'],
    'latex': ['baxter_dynamics.tex'],
}
PAYLOAD = """\
/**:
  ros__parameters:
    arm: left
    payload: {mass: 0.9, center_of_mass: [0.01, 0.02, 0.1]}
    gravity: [1.3, -2.1, -9.4]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Return the current folder, which is empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def names(folder):
    """Return the names of all that is in a folder."""
    return sorted(path.name for path in folder.iterdir())


def alone(file, expression, folder):
    """Return what an expression of an exported module is, in a process without this package."""
    code = f'import sys; sys.path.insert(0, "."); import {file} as m; print(*{expression})'
    done = subprocess.run([sys.executable, '-I', '-c', code], cwd=folder, check=True,
                          capture_output=True, text=True, timeout=60)
    return np.array(done.stdout.split(), float)


@pytest.mark.parametrize('language, files', FILES.items(), ids=FILES.keys())
def test_each_language(command, here, language, files):
    code, out, err = command('export', language, '--quantities', 'G', '-o', 'new/folder')
    assert (code, err) == (0, '')
    assert names(here / 'new' / 'folder') == files
    first, rigid, *wrote = out.splitlines()
    if language == 'latex':
        assert first == 'printed: Gravity torques'
    else:
        assert first.split()[:2] == ['G', 'gravity'] and first.endswith(' 82 operations')
    assert rigid.startswith('not exported: the effort model')
    assert sorted(wrote) == sorted(f'wrote: {here}/new/folder/{file}' for file in files)


def test_what_is_written_unless_told_otherwise(command, here):
    code, out, _ = command('export', 'python')
    assert code == 0
    assert names(here) == ['baxter_dynamics_python']
    assert [line.split()[0] for line in out.splitlines()] == [*DEFAULT_SYMBOLS, 'not', 'wrote:']


def test_a_file_where_there_is_but_one(command, here):
    code, out, _ = command('export', 'python', '-o', 'sub/my_arm.py', '--quantities', 'tau, G')
    assert code == 0 and out.splitlines()[-1] == f'wrote: {here}/sub/my_arm.py'
    assert names(here / 'sub') == ['my_arm.py']
    np.testing.assert_allclose(alone('my_arm', 'm.gravity([.1] * 7)', here / 'sub'),
                               BaxterArm().gravity([0.1] * 7), rtol=0.0, atol=1e-11)


def test_params(command, here):
    (here / 'p.yaml').write_text(PAYLOAD)
    code, out, err = command('export', 'python', '-o', 'a.py', '--params', 'p.yaml',
                             '--quantities', 'G')
    assert (code, err) == (0, '')
    from baxter_dynamics_ros import mount
    arm = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1)), (1.3, -2.1, -9.4), mount('left'))
    np.testing.assert_allclose(alone('a', 'm.gravity([.1] * 7)', here),
                               arm.gravity([0.1] * 7), rtol=0.0, atol=1e-11)
    assert command('export', '--base-parameters', '--params', 'p.yaml') == (
        0, base_table(arm) + '\n', '')


def test_the_head_states_the_command(command, here):
    assert command('export', 'c', '--quantities', 'G')[0] == 0
    assert command('export', 'latex', '--quantities', 'G,tau,C')[1].splitlines()[:2] == [
        'printed: Gravity torques', 'left out: tau, C, beyond what is printed']
    for language, files in (('c', FILES['c']), ('latex', FILES['latex'])):
        for file in files:
            text = (here / f'baxter_dynamics_{language}' / file).read_text().replace('\\', '')
            text = ' '.join(text.replace(' * ', ' ').split())
            assert f'baxter_dynamics export {language} --quantities G' in text
            assert f'of version {__version__}' in text


def test_no_command_ends_a_comment(command, here):
    (here / 'p*').mkdir()
    (here / 'p*' / 'ü"""\\.yaml').write_text(PAYLOAD)
    for language in FILES:
        code, _, err = command('export', language, '--quantities', 'G', '--params',
                               'p*/ü"""\\.yaml')
        assert (code, err) == (0, ''), language
    alone('baxter_dynamics', 'm.gravity([.1] * 7)', here / 'baxter_dynamics_python')
    head = (here / 'baxter_dynamics_c' / 'baxter_dynamics.h').read_text().split('#ifndef')[0]
    assert head.isascii() and head.count('*/') == 1 and '\\' not in head


def test_older_functions_for_matlab_are_removed(command, here):
    (here / 'p.yaml').write_text(PAYLOAD)
    assert command('export', 'matlab', '-o', 'm', '--quantities', 'G')[0] == 0
    (here / 'm' / 'baxter_dynamics_mine.m').write_text('% to call baxter_dynamics export files')
    code, out, _ = command('export', 'matlab', '-o', 'm', '--quantities', 'tau', '--params',
                           'p.yaml')
    assert code == 0
    assert f'removed: {here}/m/baxter_dynamics_gravity.m (of an older export)\n' in out
    assert names(here / 'm') == [f'baxter_dynamics_{name}.m' for name in (
        'inverse_dynamics', 'mine', 'parameters')]


def test_new_files_obey_the_umask(command, here):
    before = os.umask(0o027)
    try:
        assert command('export', 'python', '-o', 'a.py', '--quantities', 'G')[0] == 0
    finally:
        os.umask(before)
    assert (here / 'a.py').stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='no /dev/full')
def test_output_that_nobody_takes(here):
    code = 'import sys; from baxter_dynamics_ros.cli.main import main; sys.exit(main())'
    with open('/dev/full', 'w') as full:
        done = subprocess.run([sys.executable, '-c', code, 'export', '--base-parameters'],
                              stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (
        1, 'baxter_dynamics export: standard output: No space left on device\n')


def test_an_effort_model_is_not_exported_and_this_is_said(command, here):
    (here / 'p.yaml').write_text(
        '/**: {ros__parameters: {arm: left, effort_model: {bias: [1., 0., 0., 0., 0., 0., 0.]}}}')
    code, out, _ = command('export', 'python', '--params', 'p.yaml', '--quantities', 'G')
    assert code == 0 and 'not exported: the effort model' in out


def test_its_own_files_are_replaced(command, here):
    for language in FILES:
        for quantities in ('M', 'MCG,G'):
            code, _, err = command('export', language, '-o', language, '--quantities', quantities)
            assert (code, err) == (0, ''), language
    assert 'def terms' in (here / 'python' / 'baxter_dynamics.py').read_text()


@pytest.mark.parametrize('arguments, problem', [
    ((), 'name a language or --base-parameters, one of the two'),
    (('c', '--base-parameters'), 'name a language or --base-parameters, one of the two'),
    (('--base-parameters', '-o', 'x'), '--base-parameters prints a table'),
    (('--base-parameters', '--quantities', 'G'), '--base-parameters prints a table'),
    (('python', '-o', '7up.py'), "7up.py cannot be imported: '7up' is no name in Python"),
    (('casadi', '-o', 'class.py'), 'class.py cannot be imported'),
    (('c', '--quantities', 'M,Q'), "--quantities: unknown 'Q'; expected some of M, C, G, "),
    (('c', '--quantities', 'M,M'), '--quantities: M is named twice'),
    (('c', '--quantities', ' , '), '--quantities: name at least one of M, C, G, '),
    (('latex', '--quantities', 'tau'), 'name G, M or MCG'),
    (('c', '-o', 'my.c'), '--output: c gives 3 files: name a folder'),
    (('c', '--params', 'none.yaml'), 'none.yaml: cannot be read (No such file'),
    (('c', '-o', 'theirs.txt'), 'theirs.txt is no folder'),
    (('python', '-o', 'theirs.txt/arm.py'), 'theirs.txt is no folder'),
    (('python', '-o', 'theirs.py'), 'theirs.py is there, and no export wrote it'),
    (('c', '-o', 'theirs'), 'theirs/example.c is there, and no export wrote it'),
    (('matlab', '-o', 'theirs'), 'theirs/baxter_dynamics_gravity.m is there, and no export'),
], ids=lambda value: ' '.join(value) if isinstance(value, tuple) else '')
def test_what_is_refused(refused, here, arguments, problem):
    (here / 'theirs' / 'baxter_dynamics_gravity.m').mkdir(parents=True)
    for file in ('theirs.txt', 'theirs.py', 'theirs/example.c'):
        (here / file).write_text('/* baxter_dynamics export */')
    assert problem in refused('export', *arguments)


def test_a_folder_that_is_closed(refused, closed, here):
    folder = here / 'closed'
    folder.mkdir()
    with closed(folder, 0o500):
        for output in ('closed', 'closed/new', 'closed/arm.py'):
            assert 'closed cannot be written' in refused('export', 'python', '-o', output)


def test_a_disk_that_is_full_keeps_what_was_there(command, here):
    """A limit to the size of files: the second file of three does not fit any more."""
    assert command('export', 'c', '-o', 'c', '--quantities', 'G')[0] == 0
    before = {path: path.read_bytes() for path in (here / 'c').iterdir()}
    code = ('import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); '
            'from baxter_dynamics_ros.cli.main import main; '
            'resource.setrlimit(resource.RLIMIT_FSIZE, (15000, 15000)); '
            'sys.exit(main(["export", "c", "-o", sys.argv[1]]))')
    for folder in ('c', 'new/folder'):
        done = subprocess.run([sys.executable, '-c', code, folder], cwd=here, text=True,
                              capture_output=True, timeout=60)
        assert (done.returncode, done.stdout) == (1, '')
        assert done.stderr == (f'baxter_dynamics export: {here}/{folder}: cannot be '
                               'written (File too large)\n')
    assert names(here) == ['c']
    assert {path: path.read_bytes() for path in (here / 'c').iterdir()} == before


def test_without_casadi(here):
    code = ('import sys; sys.modules["casadi"] = None; '
            'from baxter_dynamics_ros.cli.main import main; sys.exit(main(sys.argv[1:]))')

    def run(*arguments):
        return subprocess.run([sys.executable, '-c', code, 'export', *arguments], cwd=here,
                              text=True, capture_output=True, timeout=60, env=os.environ)

    done = run('c')
    assert (done.returncode, done.stdout) == (1, '')
    (line,) = done.stderr.splitlines()
    assert line.startswith('baxter_dynamics export: import of casadi halted')
    assert "pip install 'baxter_dynamics_ros[export]'" in line
    assert names(here) == []
    done = run('--base-parameters')
    assert (done.returncode, done.stdout) == (0, base_table(BaxterArm()) + '\n')
