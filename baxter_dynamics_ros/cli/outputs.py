"""Where a command writes: what cannot be written is refused before work begins."""

import os
from pathlib import Path
import tempfile

from ..model.exceptions import BaxterDynamicsError


def output_folder(option: str, output: str | Path) -> Path:
    """
    Return the folder that an option names, which may be missing as yet, and those above it.

    Raises
    ------
    BaxterDynamicsError
        If it cannot be made, or nothing can be written into it.

    """
    path = Path(output).expanduser().resolve()
    there = next(place for place in (path, *path.parents) if os.path.lexists(place))
    if not there.is_dir():
        raise BaxterDynamicsError(f'{option}: {there} is no folder')
    _refuse_closed(option, there)
    return path


def output_file(option: str, output: str | Path, endings: tuple[str, ...]) -> Path:
    """
    Return the file that an option names, in a folder that is there.

    Raises
    ------
    BaxterDynamicsError
        If its ending is none of those given, or it cannot be written.

    """
    path = Path(output).expanduser().resolve()
    if path.suffix not in endings:
        raise BaxterDynamicsError(f'{option}: expected a {endings[0]} file, got {path.name}')
    if not path.parent.is_dir():
        raise BaxterDynamicsError(f'{option}: no folder {path.parent}')
    if path.is_dir():
        raise BaxterDynamicsError(f'{option}: {path} is a folder')
    _refuse_closed(option, path.parent)
    return path


def _refuse_closed(option: str, folder: Path) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BaxterDynamicsError(
            f'{option}: {folder} cannot be written ({error.strerror})') from None
