"""The code is clean by ament_flake8."""

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
CHECKED = ('baxter_dynamics_ros', 'tools', 'test', 'benchmarks', 'docs', 'examples', 'setup.py',
           'conftest.py', 'baxter_dynamics_interfaces/ros_wheels.py')
GENERATED = ('_closed_form.py',)

# Without one of the plugins that ament asks for, flake8 checks less and does not say so.
LINTERS = ('ament_flake8', 'flake8_blind_except', 'flake8_builtins', 'flake8_class_newline',
           'flake8_comprehensions', 'flake8_deprecated', 'flake8_docstrings',
           'flake8_import_order', 'flake8_quotes')


@pytest.mark.timeout(600)
@pytest.mark.flake8
@pytest.mark.linter
def test_flake8(monkeypatch):
    for linter in LINTERS:
        pytest.importorskip(linter, reason=f'{linter} is missing: pip install ".[test]"')
    from ament_flake8.main import main_with_errors
    # test_pep257.py checks docstrings, by the same rules.
    monkeypatch.setattr('flake8_docstrings.pep257Checker.run', lambda checker: ())
    monkeypatch.chdir(REPOSITORY / 'test')  # ament_flake8 walks through all that lies below
    _, errors = main_with_errors(argv=[
        *(str(REPOSITORY / name) for name in CHECKED), '--exclude', *GENERATED])
    assert not errors, '\n'.join(errors)
