"""A checkout of the repository for a reader, and its commands on a PATH."""

from pathlib import Path
import shutil
import sys

from document_setup import executables

NEVER_COPIED = ('.*', '*.nbc', '*.nbi', '*.egg-info', 'build', 'install', 'log')
_LAUNCHER = """#!/bin/sh
exec '{python}' -c '
import sys
sys.path.insert(0, "{path}")
from {module} import {function}
sys.exit({function}())
' "$@"
"""


def checkout(repository: Path, folder: Path) -> Path:
    """Return a fresh checkout of the repository, in a new folder."""
    shutil.copytree(repository, folder, ignore=shutil.ignore_patterns(*NEVER_COPIED))
    return folder


def launchers(folder: Path, root: Path) -> Path:
    """Return a new folder for the PATH: the package's commands, and ros2 where there is none."""
    folder.mkdir()
    commands_ = executables()
    if shutil.which('ros2') is None:
        commands_['ros2'] = 'ros2_stand_in:main'
    for name, target in commands_.items():
        module, function = target.split(':')
        where = root / 'test' if name == 'ros2' else root
        (folder / name).write_text(_LAUNCHER.format(
            python=sys.executable, path=where, module=module, function=function))
    for name in ('python', 'python3'):  # no links: they would leave the virtual environment
        (folder / name).write_text(f'#!/bin/sh\nexec \'{sys.executable}\' "$@"\n')
    for path in folder.iterdir():
        path.chmod(0o755)
    return folder
