"""
Export the arm's dynamics as C, Python, MATLAB, LaTeX or URDF.

The files stand alone, describe their inputs and outputs, and hold the arm's parameters as data.
"""

import argparse
from contextlib import suppress
import os
from pathlib import Path
import re

from .options import add_parameters, output_path, read_settings, resolved
from .terminal import say, write
from .. import __version__
from ..estimation.settings import PredictorSettings
from ..export import latex, sources, urdf
from ..export.parameter_table import base_table
from ..export.sources import MARK
from ..files import write_files
from ..model import BaxterDynamicsError

_LANGUAGES = {'c': sources.c_files, 'python': sources.python_files, 'matlab': sources.matlab_files,
              'latex': latex.files}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics export``."""
    parser.add_argument('language', nargs='?', choices=(*_LANGUAGES, 'urdf'),
                        help='the closed form in a language (python accepts floats, NumPy, '
                        'CasADi, SymPy, JAX and PyTorch), or urdf: the description '
                        "of the manufacturer with the arm's masses, inertias and friction")
    parser.add_argument('-o', '--output', metavar='PATH',
                        help='folder, or name of the file if there is only one (default: '
                        'baxter_dynamics_LANGUAGE)')
    add_parameters(parser, 'with the payload, links and gravity to use')
    parser.add_argument('--base-parameters', action='store_true',
                        help='print the base parameters and their meaning instead')


def main(args: argparse.Namespace) -> int:
    """Export the arm's dynamics, or print the base parameters."""
    if args.base_parameters == bool(args.language):
        raise BaxterDynamicsError('expected either a language or --base-parameters')
    if args.base_parameters and args.output is not None:
        raise BaxterDynamicsError('--base-parameters prints a table and takes no --output')
    settings = PredictorSettings.from_parameters(read_settings(args))
    arm = settings.model.arm
    if args.base_parameters:
        write(base_table(arm) + '\n')
        return 0
    # Command and version, safe in a comment of any language.
    command = re.sub(r'[^ -~]|\\|\*/|/\*|"""', '_',
                     f'{args.command_line}` of version `{__version__}')
    if args.language == 'urdf':
        texts = urdf.files(arm, command, settings.arm, settings.model.effort_model)
    else:
        texts = _LANGUAGES[args.language](arm, command)
    folder, texts = _placed(texts, args.output or f'baxter_dynamics_{args.language}')
    write_files(folder, texts)
    if args.language != 'urdf':
        say('tau is the torque of the rigid body: springs, friction and bias of the effort '
            'model are not exported')
    say(*(f'wrote: {folder / name}' for name in texts))
    return 0


def _placed(texts: dict[str, str], output: str) -> tuple[Path, dict[str, str]]:
    """Return the folder and its new files; refuse to replace files of others."""
    path = resolved(output)
    if path.suffix in {Path(name).suffix for name in texts} and not os.path.isdir(path):
        if len(texts) > 1:
            raise BaxterDynamicsError(f'--output: expected a folder for {len(texts)} files')
        texts, path = {path.name: text for text in texts.values()}, path.parent
    folder = output_path('--output', path)
    for file in map(folder.joinpath, texts):
        is_exported = False
        with suppress(OSError), file.open(encoding='utf-8', errors='replace') as text:
            is_exported = MARK in text.read(4000)  # the mark is in the head
        if os.path.lexists(file) and not is_exported:
            raise BaxterDynamicsError(f'--output: {file} exists and was not written by an '
                                      'export; move it, or choose another name')
    return folder, texts
