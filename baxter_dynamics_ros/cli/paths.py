"""Output files and folders, checked before work begins."""

from collections.abc import Iterable
import os
from pathlib import Path
import tempfile

from ..model.exceptions import BaxterDynamicsError


def output_folder(option: str, output: str | Path, force: bool = True,
                  inputs: Iterable[str | Path] = ()) -> Path:
    """
    Return the absolute path of an output folder, which may not exist yet.

    Raises BaxterDynamicsError, with the option that names the folder, if it cannot be written,
    belongs to the inputs of the command, or has contents and force is False.
    """
    path = Path(output).expanduser().resolve()
    existing = next(place for place in (path, *path.parents) if os.path.lexists(place))
    if not existing.is_dir():
        raise BaxterDynamicsError(f'{option}: {existing} is not a folder')
    _check(option, path, existing, force, inputs)
    return path


def output_file(option: str, output: str | Path, endings: tuple[str, ...], force: bool = True,
                inputs: Iterable[str | Path] = ()) -> Path:
    """Return the absolute path of an output file with one of the endings, as output_folder."""
    path = Path(output).expanduser().resolve()
    if path.suffix.lower() not in endings:
        raise BaxterDynamicsError(
            f'{option}: expected a name ending in {" or ".join(endings)}, got {path.name}')
    if not path.parent.is_dir():
        raise BaxterDynamicsError(f'{option}: no folder {path.parent}')
    if path.is_dir():
        raise BaxterDynamicsError(f'{option}: {path} is a folder')
    _check(option, path, path.parent, force, inputs)
    return path


def _check(option: str, path: Path, folder: Path, force: bool,
           inputs: Iterable[str | Path]) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BaxterDynamicsError(
            f'{option}: {folder} cannot be written ({error.strerror})') from None
    if not path.exists() or path.is_dir() and not any(path.iterdir()):
        return
    for source in (Path(name).expanduser() for name in inputs):
        if source.exists() and (path.is_relative_to(source.resolve())
                                or os.path.samefile(path, source)):
            raise BaxterDynamicsError(f'{option}: {path} belongs to the input {source}')
    if not force:
        raise BaxterDynamicsError(f'{option}: {path} exists; choose another name, or replace it '
                                  'with --force')


def new_folder(output: str) -> Path:
    """Create an output folder and return it; raise BaxterDynamicsError unless it is empty."""
    path = Path(output).expanduser().resolve()
    try:
        path.mkdir(exist_ok=True)
        is_empty = not any(path.iterdir())
    except OSError as error:
        raise BaxterDynamicsError(
            f'--output: {path} cannot be created ({error.strerror})') from None
    if not is_empty:
        raise BaxterDynamicsError(f'--output: {path} is not empty; name a new folder')
    return path
