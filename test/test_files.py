"""Files appear completely or not at all, and links are not followed."""

import os
import resource
import stat

from baxter_dynamics_ros.files import staged, write_file, write_files
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import pytest


def test_files_of_the_same_name_are_replaced_and_others_stay(tmp_path):
    (tmp_path / 'figures').mkdir()
    (tmp_path / 'figures' / 'a.svg').write_text('old')
    (tmp_path / 'notes.txt').write_text('mine')
    os.chmod(tmp_path / 'figures' / 'a.svg', 0o600)
    write_files(tmp_path, {'figures/a.svg': b'new', 'report.html': 'é\udce9'})
    assert {path.name for path in tmp_path.iterdir()} == {'figures', 'notes.txt', 'report.html'}
    assert (tmp_path / 'figures' / 'a.svg').read_text() == 'new'
    assert (tmp_path / 'report.html').read_bytes() == 'é?'.encode()
    assert stat.S_IMODE((tmp_path / 'report.html').stat().st_mode) & 0o444 == 0o444


def test_new_folders_appear_with_their_parents(tmp_path):
    with staged(tmp_path / 'a' / 'b') as stage:
        (stage / 'file').write_text('x')
        assert not (tmp_path / 'a').exists()
    assert (tmp_path / 'a' / 'b' / 'file').read_text() == 'x'
    assert stat.S_IMODE((tmp_path / 'a' / 'b').stat().st_mode) & 0o555 == 0o555


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
    (lambda folder: write_files(folder / 'a.txt' / 'c', {'d.txt': b'new'}), 'Not a directory'),
    (lambda folder: write_file(folder / 'none' / 'd.txt', ''), 'no folder'),
], ids=['full disk', 'folder in the way', 'file as folder', 'below a file', 'no folder'])
def test_failures_change_nothing(tmp_path, write, reason):
    (tmp_path / 'a.txt').write_text('old')
    (tmp_path / 'b.txt').mkdir()
    with pytest.raises(BaxterDynamicsError, match=f'^{tmp_path}.*cannot be written .*{reason}'):
        write(tmp_path)
    assert (tmp_path / 'a.txt').read_text() == 'old'
    assert {path.name for path in tmp_path.iterdir()} == {'a.txt', 'b.txt'}


def test_folders_without_permission_are_reported(tmp_path, closed):
    with closed(tmp_path, 0o555):
        with pytest.raises(BaxterDynamicsError, match=f'^{tmp_path}/a: .*Permission denied'):
            write_file(tmp_path / 'a', 'x')


def test_interrupts_leave_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / 'new') as stage:
        (stage / 'file').write_text('x')
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []
