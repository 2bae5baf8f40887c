"""The docstrings are clean by ament_pep257."""

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
CHECKED = ('baxter_dynamics_ros', 'tools', 'test', 'benchmarks', 'docs', 'examples', 'setup.py',
           'conftest.py', 'baxter_dynamics_interfaces/ros_wheels.py')


@pytest.mark.linter
@pytest.mark.pep257
def test_pep257(capfd):
    for linter in ('ament_pep257', 'pydocstyle'):
        pytest.importorskip(linter, reason=f'{linter} is missing: pip install ".[test]"')
    from ament_pep257.main import main
    failed = main(argv=[str(REPOSITORY / name) for name in CHECKED])
    out, err = capfd.readouterr()
    assert not failed, err
    for name in CHECKED:  # a folder that is not there is passed over in silence
        assert f'checking {REPOSITORY / name}' in out
