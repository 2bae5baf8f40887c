"""export: the closed form in other languages, or the base parameters."""

import argparse
from collections.abc import Callable
import os
from pathlib import Path
import re

from .options import add_parameters, read_settings
from .paths import output_folder
from .terminal import say, write
from .. import __version__
from ..estimation.settings import PredictorSettings
from ..export import latex, matlab, sources, urdf
from ..export.base_table import base_table
from ..export.common import MARK
from ..files import write_files
from ..model.exceptions import BaxterDynamicsError

Exporter = Callable[[PredictorSettings, str], dict[str, str]]
LANGUAGES: dict[str, Exporter] = {
    'c': lambda settings, command: sources.c_files(settings.model.arm, command),
    'python': lambda settings, command: sources.python_files(settings.model.arm, command),
    'matlab': lambda settings, command: matlab.files(settings.model.arm, command),
    'latex': lambda settings, command: latex.files(settings.model.arm, command),
    'urdf': lambda settings, command: urdf.files(settings.model.arm, command, settings.arm,
                                                 settings.model.effort_model),
}
DESCRIPTION = (
    'Write the dynamics of the arm in another language, as standalone files that describe their '
    "inputs and outputs. The arm's parameters are stored in the files as data.")
_HEAD = 4000  # characters of a file that are searched for the mark of an export


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics export``."""
    parser.add_argument('language', nargs='?', choices=tuple(LANGUAGES),
                        help='language to write; python is for floats, NumPy, CasADi, SymPy, JAX '
                        "and PyTorch; urdf is the manufacturer's description with the arm's "
                        'masses, inertias and friction')
    parser.add_argument('-o', '--output', metavar='PATH',
                        help='folder, or name of the file if there is only one (default: '
                        'baxter_dynamics_LANGUAGE)')
    add_parameters(parser, 'with the payload, links and gravity to use')
    parser.add_argument('--base-parameters', action='store_true',
                        help='print the base parameters and their meaning instead')


def main(args: argparse.Namespace) -> int:
    """Write the closed form in another language, or print the base parameters."""
    if args.base_parameters == bool(args.language):
        raise BaxterDynamicsError('expected either a language or --base-parameters')
    if args.base_parameters and args.output is not None:
        raise BaxterDynamicsError('--base-parameters prints a table and takes no --output')
    settings = PredictorSettings.from_parameters(read_settings(args))
    if args.base_parameters:
        write(base_table(settings.model.arm) + '\n')
        return 0
    texts = LANGUAGES[args.language](settings, _command(args.command_line))
    folder, files = _placed(texts, args.output or f'baxter_dynamics_{args.language}')
    write_files(folder, files)
    if args.language != 'urdf':
        say('tau is the torque of the rigid body: springs, friction and bias of the effort '
            'model are not exported')
    say(*(f'wrote: {folder / name}' for name in files))
    return 0


def _command(command_line: str) -> str:
    """Return command and version, safe in a comment of any language."""
    text = re.sub(r'[^ -~]|\\', '_', f'{command_line}` of version `{__version__}')
    return re.sub(r'\*/|/\*|"""', '_', text)


def _placed(texts: dict[str, str], output: str) -> tuple[Path, dict[str, str]]:
    """Return the folder and its new files; refuse to replace files of others."""
    path = Path(output).expanduser().resolve()
    if path.suffix in {Path(name).suffix for name in texts} and not path.is_dir():
        if len(texts) > 1:
            raise BaxterDynamicsError(f'--output: expected a folder for {len(texts)} files')
        texts, path = {path.name: text for text in texts.values()}, path.parent
    folder = output_folder('--output', path)
    for name in texts:
        if os.path.lexists(folder / name) and not _is_exported(folder / name):
            raise BaxterDynamicsError(f'--output: {folder / name} exists and was not written by '
                                      'an export; move it, or choose another name')
    return folder, texts


def _is_exported(path: Path) -> bool:
    try:
        with path.open(encoding='utf-8', errors='replace') as file:
            return MARK in file.read(_HEAD)
    except OSError:
        return False
