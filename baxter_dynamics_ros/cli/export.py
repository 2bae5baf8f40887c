"""export: the closed form in other languages, and the base parameters as a table."""

from importlib import import_module
import os
from pathlib import Path
import re
import tempfile

from .outputs import output_folder
from ..core.exceptions import BaxterDynamicsError
from ..export.base_table import base_table
from ..export.functions import derive
from ..signals.settings import PredictorSettings

# Languages whose module cannot have their name: it is that of a library.
_MODULES = {'numba': 'numba_file', 'casadi': 'casadi_file', 'sympy': 'sympy_file'}
# What each file of ours says in its head, wherever its lines break.
_OURS = re.compile(r'baxter\\?_dynamics\W+export')
_HEAD = 2000  # characters


def run(language: 'str | None', output: 'str | None', quantities: str, params: 'str | None',
        base_parameters: bool) -> int:
    """
    Write the closed form in another language, or print the base parameters.

    Parameters
    ----------
    language : str or None
        Which; None where base parameters are printed.
    output : str or None
        The folder, or the file where there is but one; None for a folder named by the language.
    quantities : str
        What to write, with commas between.
    params : str or None
        A parameter file, such as a calibration's; None for the defaults of the package.
    base_parameters : bool
        Whether to print the base parameters instead.

    Returns
    -------
    int
        Exit code 0.

    Raises
    ------
    BaxterDynamicsError
        If something cannot be read, derived or written.

    """
    if base_parameters == bool(language):
        raise BaxterDynamicsError('name a language or --base-parameters, one of the two')
    values = _read(params) if params else {}
    arm = PredictorSettings(values).arm
    if base_parameters:
        print(base_table(arm))
        return 0
    files = _exporter(language)
    symbols = [symbol.strip() for symbol in quantities.split(',') if symbol.strip()]
    functions = derive(arm, symbols)
    placed = _placed(files(functions, arm), output or f'baxter_dynamics_{language}', language)
    _write(placed)
    for symbol, function in zip(symbols, functions):
        print(f'{symbol:<12}{function.quantity.name:<26}{function.program.operations():>5} '
              'operations')
    if any(name.startswith('effort_model.') for name in values):
        print('not exported: the effort model (spring, friction, bias); this is the rigid body')
    for path in placed:
        print(f'wrote: {path}')
    return 0


def _read(path: str) -> dict:
    try:
        from ..offline.parameter_file import read_parameters
    except ImportError as error:
        raise BaxterDynamicsError(f'--params: {error}: pip install pyyaml') from None
    return read_parameters(path)


def _exporter(language: str):
    """Return what writes functions in a language."""
    try:
        import_module('..closed_form.derivation', __package__)  # needs CasADi
        module = import_module(f'..export.{_MODULES.get(language, language)}', __package__)
    except ImportError as error:
        raise BaxterDynamicsError(
            f"{error}. Install the export extra: pip install 'baxter_dynamics_ros[export]', or "
            '".[export]" in a checkout') from None
    return module.files


def _placed(texts: dict, output: str, language: str) -> dict:
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


def _is_ours(path: Path) -> bool:
    try:
        with path.open(encoding='utf-8', errors='replace') as file:
            return _OURS.search(file.read(_HEAD)) is not None
    except OSError:
        return False


def _write(texts: dict):
    """Write all files, each in place of an old one once all are complete, or none."""
    folder = next(iter(texts)).parent
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    partial = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            with tempfile.NamedTemporaryFile('w', encoding='utf-8', dir=folder, delete=False,
                                             prefix=f'.{path.name}.') as file:
                partial[path] = file.name
                file.write(text)
            os.chmod(file.name, 0o644)
        for path in texts:
            os.replace(partial.pop(path), path)
    except BaseException as error:
        for name in partial.values():
            os.unlink(name)
        for place in made:
            if place.exists() and not any(place.iterdir()):
                place.rmdir()
        if isinstance(error, OSError):
            raise BaxterDynamicsError(
                f'--output: {folder} cannot be written ({error.strerror})') from None
        raise
