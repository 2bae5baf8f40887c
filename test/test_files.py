"""Files appear complete or not at all, and nobody can redirect a write."""

import os
import resource
import stat

from baxter_dynamics_ros.files import staged, write_file, write_files
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import pytest


def test_files_of_the_same_name_are_replaced_and_others_stay(tmp_path):
    folder = tmp_path / 'new' / 'folder'
    write_files(folder, {'figures/a.svg': 'old', 'notes.txt': 'mine'})
    os.chmod(folder / 'figures' / 'a.svg', 0o600)
    write_files(folder, {'figures/a.svg': b'new', 'report.html': 'é\udce9'})
    assert {path.name for path in folder.iterdir()} == {'figures', 'notes.txt', 'report.html'}
    assert (folder / 'figures' / 'a.svg').read_text() == 'new'
    assert (folder / 'report.html').read_bytes() == 'é?'.encode()
    for path in (folder, folder / 'report.html'):
        assert stat.S_IMODE(path.stat().st_mode) & 0o444 == 0o444


def test_links_in_the_target_folder_are_not_followed(tmp_path):
    victim = tmp_path / 'victim'
    victim.write_text('keep')
    folder = tmp_path / 'folder'
    folder.mkdir()
    (folder / 'r.yaml').symlink_to(victim)
    (folder / f'.baxter_dynamics_{os.getpid()}').symlink_to(tmp_path)
    write_file(folder / 'r.yaml', 'new')
    assert victim.read_text() == 'keep'
    assert (folder / 'r.yaml').read_text() == 'new' and not (folder / 'r.yaml').is_symlink()


def _full_disk(folder):
    """Run into a limit on the size of files, which fails a write like a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))  # [bytes]
    try:
        write_files(folder, {'a.txt': b'new', 'c.txt': bytes(9000)})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize('write, reason', [
    (_full_disk, 'File too large'),
    (lambda folder: write_files(folder, {'a.txt': b'new', 'b.txt': b'new'}), 'b.txt is a folder'),
    (lambda folder: write_files(folder / 'a.txt', {'d.txt': b'new'}), 'Not a directory'),
    (lambda folder: write_file(folder / 'none' / 'd.txt', ''), 'no folder'),
    (lambda folder: write_file(folder / 'pipe', 'new'), 'pipe is a device or pipe'),
], ids=['full disk', 'folder in the way', 'file as folder', 'no folder', 'pipe'])
def test_failures_change_nothing(tmp_path, write, reason):
    (tmp_path / 'a.txt').write_text('old')
    (tmp_path / 'b.txt').mkdir()
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(BaxterDynamicsError, match=f'^{tmp_path}.*cannot be written .*{reason}'):
        write(tmp_path)
    assert (tmp_path / 'a.txt').read_text() == 'old'
    assert {path.name for path in tmp_path.iterdir()} == {'a.txt', 'b.txt', 'pipe'}


def test_folders_without_permission_are_reported(tmp_path, closed):
    with closed(tmp_path, 0o555), pytest.raises(
            BaxterDynamicsError, match=f'^{tmp_path}/a: .*Permission denied'):
        write_file(tmp_path / 'a', 'x')


def test_nothing_appears_before_the_end_or_after_an_interrupt(tmp_path):
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / 'a' / 'b') as stage:
        (stage / 'file').write_text('x')
        assert not (tmp_path / 'a').exists()
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []
