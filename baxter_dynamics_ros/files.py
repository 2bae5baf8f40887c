"""Files and folders that appear complete or not at all."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import os
from pathlib import Path
import tempfile

from .model import BaxterDynamicsError


@contextmanager
def staged(folder: str | Path, name: str = '') -> Iterator[Path]:
    """
    Provide a hidden folder whose contents move into a target folder when the block succeeds.

    The target is created with its parents if missing. Existing files of the same names are
    replaced, other files in it stay. After an exception nothing has changed. Error messages name
    the target, or the ``name`` in it.
    """
    folder = Path(folder).resolve()
    try:
        there = next(place for place in (folder, *folder.parents) if os.path.lexists(place))
        with tempfile.TemporaryDirectory(prefix='.baxter_dynamics.', dir=there) as temporary:
            stage = Path(temporary) / 'stage'
            stage.mkdir()
            yield stage
            renames = list(_renames(stage, folder))
            folder.parent.mkdir(parents=True, exist_ok=True)
            for source, target in renames:
                os.replace(source, target)
    except OSError as error:
        reason = error.strerror or error
        raise BaxterDynamicsError(f'{folder / name}: cannot be written ({reason})') from None


def write_files(folder: str | Path, contents: Mapping[str, str | bytes], name: str = '') -> None:
    """
    Write files into a folder, all or none; see :func:`staged`.

    The keys are paths within the folder, with '/'. Text is written as UTF-8, with a question mark
    for surrogates.
    """
    with staged(folder, name) as stage:
        for file, content in contents.items():
            path = stage / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else
                             content.encode('utf-8', 'replace'))


def write_file(path: str | Path, content: str | bytes) -> None:
    """Write a single file in an existing folder; see :func:`write_files`."""
    path = Path(path)
    if not path.parent.is_dir():
        raise BaxterDynamicsError(f'{path}: cannot be written (no folder {path.parent})')
    write_files(path.parent, {path.name: content}, path.name)


def _renames(source: Path, target: Path) -> Iterator[tuple[Path, Path]]:
    """Yield the renames that merge a file or folder into the target, once all are possible."""
    if source.is_dir() and target.is_dir():
        for entry in sorted(source.iterdir()):
            yield from _renames(entry, target / entry.name)
    elif os.path.lexists(target) and (source.is_dir() or target.exists() and not target.is_file()):
        kind = 'folder' if target.is_dir() else 'file' if target.is_file() else 'device or pipe'
        raise FileExistsError(f'{target} is a {kind}')
    else:
        yield source, target
