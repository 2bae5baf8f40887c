"""The figures of the documentation are drawn by their command."""

from importlib import import_module
from pathlib import Path
import xml.etree.ElementTree as ET

import pytest

DOCS = Path(__file__).resolve().parents[1] / 'docs'
FAST = ('arm_as_printed', 'spring', 'friction')  # under a second each


@pytest.fixture
def figures(monkeypatch):
    """Return the module of the command."""
    for module in ('matplotlib', 'mujoco', 'pinocchio'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')
    monkeypatch.syspath_prepend(str(DOCS))
    return import_module('figures')


def test_every_figure_has_a_function_that_draws_it(figures):
    assert figures.FIGURES.keys() == {path.name for path in (DOCS / 'figures').iterdir()}
    for module, function in figures.FIGURES.values():
        assert callable(getattr(import_module(module), function))


def test_figures_are_drawn_as_they_are_shown(figures, tmp_path):
    assert figures.main([*FAST, '-o', str(tmp_path)]) == 0
    for name in FAST:
        drawn, shown = ([element.tag for element in ET.parse(folder / f'{name}.svg').iter()]
                        for folder in (tmp_path, DOCS / 'figures'))
        assert drawn == shown, name


def test_a_failure_is_one_line_and_keeps_the_figure_before(figures, tmp_path, monkeypatch, capsys):
    (tmp_path / 'broken.py').write_text(
        'def draw(path):\n    path.write_text("half")\n    raise OSError(28, "disk is full")\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(figures.FIGURES, 'spring.svg', ('broken', 'draw'))
    folder = tmp_path / 'figures'
    folder.mkdir()
    (folder / 'spring.svg').write_text('before')
    assert figures.main(['spring', '-o', str(folder)]) == 1
    assert [path.read_text() for path in folder.iterdir()] == ['before']
    assert capsys.readouterr().err.count('\n') == 1
