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
