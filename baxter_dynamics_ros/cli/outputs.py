"""Where a command writes: whatever cannot be written is refused before work begins."""

from collections.abc import Iterable
import os
from pathlib import Path
import tempfile

from ..model.exceptions import BaxterDynamicsError


def output_folder(option: str, output: str | Path, force: bool = True,
                  inputs: Iterable[str | Path] = ()) -> Path:
    """
    Return the absolute path of an output folder, which may not exist yet.

    Parameters
    ----------
    option : str
        The option that names it, for error messages.
    output : Path
        The folder.
    force : bool
        Whether it may exist and have contents.
    inputs : iterable of Path
        Files and folders that the command reads.

    Raises
    ------
    BaxterDynamicsError
        If it cannot be created or written, or must not be.

    """
    path = Path(output).expanduser().resolve()
    there = next(place for place in (path, *path.parents) if os.path.lexists(place))
    if not there.is_dir():
        raise BaxterDynamicsError(f'{option}: {there} is no folder')
    _refuse_closed(option, there)
    _refuse_existing(option, path, force, inputs)
    return path


def output_file(option: str, output: str | Path, endings: tuple[str, ...], force: bool = True,
                inputs: Iterable[str | Path] = ()) -> Path:
    """
    Return the absolute path of an output file in an existing folder.

    Parameters are those of :func:`output_folder`; endings are the permitted file name extensions.

    Raises
    ------
    BaxterDynamicsError
        If it has another ending, cannot be written, or must not be.

    """
    path = Path(output).expanduser().resolve()
    if path.suffix not in endings:
        raise BaxterDynamicsError(f'{option}: expected a {endings[0]} file, got {path.name}')
    if not path.parent.is_dir():
        raise BaxterDynamicsError(f'{option}: no folder {path.parent}')
    if path.is_dir():
        raise BaxterDynamicsError(f'{option}: {path} is a folder')
    _refuse_closed(option, path.parent)
    _refuse_existing(option, path, force, inputs)
    return path


def _refuse_existing(option: str, path: Path, force: bool, inputs: Iterable[str | Path]) -> None:
    if not path.exists() or path.is_dir() and not any(path.iterdir()):
        return
    for source in (Path(name).expanduser() for name in inputs):
        if source.exists() and (path.is_relative_to(source.resolve())
                                or os.path.samefile(path, source)):
            raise BaxterDynamicsError(f'{option}: {path} belongs to the input {source}')
    if not force:
        raise BaxterDynamicsError(f'{option}: {path} exists; choose another name, or replace it '
                                  'with --force')


def _refuse_closed(option: str, folder: Path) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BaxterDynamicsError(
            f'{option}: {folder} cannot be written ({error.strerror})') from None
