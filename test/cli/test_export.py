"""The command export: its files, its refusals, and the table of base parameters."""

import os
import subprocess
import sys

from baxter_dynamics_ros import __version__, BaxterArm, mount, Payload
from baxter_dynamics_ros.export.parameter_table import base_table
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
import numpy as np
import pytest

FILES = {
    'c': ['baxter_dynamics.c', 'baxter_dynamics.h', 'example.c'],
    'python': ['baxter_dynamics.py'],
    'matlab': [f'+baxter_dynamics/{name}.m' for name in (*FUNCTIONS, 'parameters')],
    'latex': ['baxter_dynamics.tex'],
    'urdf': ['baxter_right.urdf'],
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


def files(folder):
    """Return the paths of all files below a folder."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob('*') if path.is_file())


def gravity(file, folder):
    """Return G of an exported Python file, in a process without this package."""
    code = (f'import {file} as m, numpy as np; print(*m.evaluate(m.gravity, np.full(7, 0.1)))')
    done = subprocess.run([sys.executable, '-c', code], cwd=folder, check=True,
                          capture_output=True, text=True, timeout=60)
    return np.array(done.stdout.split(), float)


@pytest.mark.parametrize('language', FILES)
def test_each_language(command, here, language):
    for _ in range(2):  # the second time it replaces its own files
        code, out, err = command('export', language, '-o', 'new/folder')
        assert (code, err) == (0, '')
        assert files(here / 'new' / 'folder') == sorted(FILES[language])
        wrote = [line for line in out.splitlines() if line.startswith('wrote: ')]
        assert sorted(wrote) == sorted(f'wrote: {here}/new/folder/{file}'
                                       for file in FILES[language])
        assert ('are not exported' in out) == (language != 'urdf')
    text = (here / 'new' / 'folder' / FILES[language][0]).read_text()
    text = ' '.join(text.replace(' * ', ' ').replace('%', '').split())
    assert f'`baxter_dynamics export {language} -o new/folder` of version `{__version__}`' in text


def test_default_folder_and_a_named_file(command, here):
    assert command('export', 'python')[0] == 0
    assert files(here) == ['baxter_dynamics_python/baxter_dynamics.py']
    code, out, _ = command('export', 'python', '-o', 'sub/my_arm.py')
    assert code == 0 and out.splitlines()[-1] == f'wrote: {here}/sub/my_arm.py'
    np.testing.assert_allclose(gravity('my_arm', here / 'sub'), BaxterArm().gravity([0.1] * 7),
                               rtol=0.0, atol=1e-11)


def test_params(command, here):
    (here / 'p.yaml').write_text(PAYLOAD)
    assert command('export', 'python', '-o', 'a.py', '--params', 'p.yaml')[::2] == (0, '')
    arm = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1)), (1.3, -2.1, -9.4), mount('left'))
    np.testing.assert_allclose(gravity('a', here), arm.gravity([0.1] * 7), rtol=0.0, atol=1e-11)
    assert command('export', '--base-parameters', '--params', 'p.yaml') == (
        0, base_table(arm) + '\n', '')
    assert command('export', 'urdf', '--params', 'p.yaml')[0] == 0
    assert files(here / 'baxter_dynamics_urdf') == ['baxter_left.urdf']


def test_no_command_ends_a_comment(command, here):
    (here / 'p*').mkdir()
    (here / 'p*' / 'ü"""\\.yaml').write_text(PAYLOAD)
    for language in FILES:
        assert command('export', language, '--params', 'p*/ü"""\\.yaml')[::2] == (0, ''), language
    gravity('baxter_dynamics', here / 'baxter_dynamics_python')
    head = (here / 'baxter_dynamics_c' / 'baxter_dynamics.h').read_text().split('#ifndef')[0]
    assert head.isascii() and head.count('*/') == 1 and '\\' not in head


def test_exports_need_neither_casadi_nor_a_compiler(here):
    code = ('import sys; sys.modules["casadi"] = None; '
            'sys.modules["baxter_dynamics_ros.model._compiled"] = None; '
            'from baxter_dynamics_ros.cli.main import main; '
            'sys.exit(any([main(["export", language]) for language in sys.argv[1:]]))')
    done = subprocess.run([sys.executable, '-c', code, *FILES], cwd=here, text=True,
                          capture_output=True, timeout=60, env={**os.environ, 'PATH': ''})
    assert done.returncode == 0, done.stderr
