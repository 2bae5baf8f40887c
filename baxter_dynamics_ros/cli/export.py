"""export: the closed form in other languages, and the base parameters as a table."""

import argparse
from importlib import import_module
from keyword import iskeyword
import os
from pathlib import Path
import re
import sys
from types import ModuleType
from typing import Any

from .options import add_parameters
from .outputs import output_folder
from .. import __version__
from ..estimation.settings import PredictorSettings
from ..export.base_table import base_table
from ..export.functions import check_symbols, DEFAULT_SYMBOLS, derive, SYMBOLS
from ..files import write_files
from ..model.exceptions import ArgumentError, BaxterDynamicsError

# Languages whose module cannot have their name: it is that of a library.
_MODULES = {'numba': 'numba_file', 'casadi': 'casadi_file', 'sympy': 'sympy_file'}
# What each file of ours says in its head, wherever its lines break: all but LaTeX, LaTeX.
_OURS = re.compile('|'.join(r'\W+'.join(text.split()) for text in (
    'its two errors mended written by baxter_dynamics export',
    r"the paper's two corrections This is the printable part written by texttt "
    r'baxter\\_dynamics export')))
_HEAD = 4000  # characters
_RIGID = ('not exported: the effort model (spring, friction, bias); tau is the rigid body, not '
          'the effort that is measured')


LANGUAGES = ('c', 'python', 'numba', 'matlab', 'casadi', 'sympy', 'latex')
DESCRIPTION = (
    'Write the dynamics of the arm in another language, as standalone files that describe their '
    "inputs and outputs. The arm's parameters are stored in the files as data.")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics export``."""
    parser.add_argument('language', nargs='?', choices=LANGUAGES,
                        help='language to write; casadi and sympy are Python files')
    parser.add_argument('-o', '--output', metavar='PATH',
                        help='folder, or file where there is only one (default: '
                        'baxter_dynamics_LANGUAGE)')
    parser.add_argument('--quantities', metavar='LIST',
                        help='comma-separated list of ' + ','.join(SYMBOLS) + ': M, C and G of '
                        'the model, MCG all three at once; Cqd the torque C qd; tau inverse, qdd '
                        'forward dynamics; regressor Y of tau = Y phi; gradient of tau with '
                        'respect to q and qd; christoffel the symbols h of '
                        'C_ik = sum_m h_ikm qd_m (default: ' + ','.join(DEFAULT_SYMBOLS) + ')')
    add_parameters(parser, 'with the payload, links and gravity to use')
    parser.add_argument('--base-parameters', action='store_true',
                        help='print the base parameters and their meaning instead')


def main(args: argparse.Namespace) -> int:
    """Write the closed form in another language, or print the base parameters."""
    language, output, quantities = args.language, args.output, args.quantities
    if args.base_parameters == bool(language):
        raise BaxterDynamicsError('name a language or --base-parameters, one of the two')
    if args.base_parameters and (output is not None or quantities is not None):
        raise BaxterDynamicsError('--base-parameters prints a table: it takes no --output and no '
                                  '--quantities')
    arm = PredictorSettings(_read(args) if args.params else {}).arm
    if args.base_parameters or language is None:
        _say([base_table(arm)])
        return 0
    module = _exporter(language)
    wanted = _symbols(quantities)
    try:
        symbols = module.printable(wanted) if language == 'latex' else wanted
        functions = derive(arm, symbols)
    except ArgumentError as error:
        raise BaxterDynamicsError(f'--{error}') from None
    texts = module.files(functions, arm, command=_command(args.command_line, symbols))
    placed = _placed(texts, output or f'baxter_dynamics_{language}', language)
    stale = _stale(placed) if language == 'matlab' else []
    folder = next(iter(placed)).parent
    write_files(folder, {path.name: text for path, text in placed.items()})
    for path in stale:
        path.unlink(missing_ok=True)
    if language == 'latex':
        lines = [f'printed: {each.title}' for each in
                 module.printed(function.quantity.name for function in functions)]
        left_out = [symbol for symbol in wanted if symbol not in ('G', 'M')]
        if left_out:
            lines.append(f'left out: {", ".join(left_out)}, beyond what is printed')
    else:
        lines = [f'{symbol:<12}{function.quantity.name:<26}'
                 f'{function.program.operations():>5} operations'
                 for symbol, function in zip(symbols, functions)]
    _say([*lines, _RIGID, *(f'removed: {path} (of an older export)' for path in stale),
          *(f'wrote: {path}' for path in placed)])
    return 0


def _symbols(quantities: 'str | None') -> list[str]:
    """Return the symbols that a list names."""
    if quantities is None:
        return list(DEFAULT_SYMBOLS)
    symbols = [symbol.strip() for symbol in quantities.split(',') if symbol.strip()]
    try:
        check_symbols(symbols)
    except ArgumentError as error:
        raise BaxterDynamicsError(f'--{error}') from None
    return symbols


def _command(command_line: str, symbols: list[str]) -> str:
    """Return the command with version and quantities, fit for a comment of any language."""
    text = f'{command_line}` of version {__version__}, quantities `{",".join(symbols)}'
    text = re.sub(r'[^ -~]|\\', '_', text)
    return re.sub(r'\*/|/\*|"""', '_', text)


def _say(lines: list[str]) -> None:
    """
    Print lines.

    Raises
    ------
    BaxterDynamicsError
        If nobody takes them.

    """
    try:
        print('\n'.join(lines), flush=True)
    except OSError as error:
        # What is left would be tried once more at the end, with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise BaxterDynamicsError(f'standard output: {error.strerror}') from None


def _read(args: argparse.Namespace) -> dict[str, Any]:
    try:
        from ..recordings.parameter_file import read_parameters
    except ImportError as error:
        raise BaxterDynamicsError(f'--params: {error}: pip install pyyaml') from None
    return read_parameters(args.params, args.node,
                           lambda line: print(f'warning: {line}', file=sys.stderr))


def _exporter(language: str) -> ModuleType:
    """Return the module that writes functions in a language."""
    try:
        import_module('..closed_form.derivation', __package__)  # needs CasADi
        module = import_module(f'..export.{_MODULES.get(language, language)}', __package__)
    except ImportError as error:
        raise BaxterDynamicsError(
            f"{error}. Install the export extra: pip install 'baxter_dynamics_ros[export]', or "
            '".[export]" in a checkout') from None
    return module


def _placed(texts: dict[str, str], output: str, language: str) -> dict[Path, str]:
    """
    Return path -> text.

    Raises
    ------
    BaxterDynamicsError
        If it is not clear or not possible where to write, or something else would be lost.

    """
    path = Path(output).expanduser().resolve()
    if path.suffix in {Path(name).suffix for name in texts} and not path.is_dir():
        if len(texts) > 1:
            raise BaxterDynamicsError(
                f'--output: {language} gives {len(texts)} files: name a folder')
        if path.suffix == '.py' and not _importable(path.stem):
            raise BaxterDynamicsError(
                f'--output: {path.name} cannot be imported: {path.stem!r} is no name in Python; '
                'use a letter, then letters, digits and _')
        output_folder('--output', path.parent)
        result = {path: text for text in texts.values()}
    else:
        folder = output_folder('--output', path)
        result = {folder / name: text for name, text in texts.items()}
    for path in result:
        if os.path.lexists(path) and not _is_ours(path):
            raise BaxterDynamicsError(f'--output: {path} is there, and no export wrote it; move '
                                      'it away, or name another place')
    return result


def _importable(stem: str) -> bool:
    return stem.isidentifier() and stem.isascii() and not iskeyword(stem)


def _stale(placed: dict[Path, str]) -> list[Path]:
    """Return our older functions beside new ones, which would be called with other numbers."""
    folder = next(iter(placed)).parent
    return sorted(path for path in folder.glob('baxter_dynamics_*.m')
                  if path not in placed and _is_ours(path))


def _is_ours(path: Path) -> bool:
    try:
        with path.open(encoding='utf-8', errors='replace') as file:
            return _OURS.search(file.read(_HEAD)) is not None
    except OSError:
        return False
