"""The pages build with Sphinx, their links lead somewhere, and their figures are drawn."""

from importlib import import_module
from pathlib import Path
import re
import subprocess
import sys
from urllib.parse import unquote, urlsplit
import xml.etree.ElementTree as ET

import pytest

DOCS = Path(__file__).resolve().parents[1] / 'docs'
FAST = ('arm_as_printed', 'spring', 'friction')  # figures drawn in under a second each
PAGES = sorted(path.stem for path in DOCS.glob('*.md'))

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope='module')
def site(tmp_path_factory):
    """Return the folder of the HTML pages."""
    for module in ('sphinx', 'myst_parser'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[doc]"')
    folder = tmp_path_factory.mktemp('site')
    built = subprocess.run([sys.executable, '-m', 'sphinx', '-W', '--keep-going', '-q', DOCS,
                            folder], capture_output=True, text=True, timeout=280)
    assert (built.returncode, built.stderr) == (0, '')
    return folder


def test_links_and_pictures_lead_somewhere(site):
    texts = {path.name: path.read_text('utf-8') for path in site.glob('*.html')}
    for name, text in texts.items():
        for target in re.findall(r'(?:href|src)="([^"]+)"', text):
            link = urlsplit(target)
            if not link.scheme:
                assert (site / unquote(link.path)).exists(), f'{name}: {target}'
            if link.fragment and (link.path or name) in texts:
                assert f'id="{unquote(link.fragment)}"' in texts[link.path or name], target


@pytest.mark.parametrize('page', PAGES)
def test_equations_and_pictures_are_shown(site, page):
    source, shown = (DOCS / f'{page}.md').read_text('utf-8'), (site / f'{page}.html').read_text()
    assert shown.count('\\begin{equation*}') == source.count('```math')
    assert shown.count('<img') == source.count('![') and '$`' not in shown


def test_the_reference_and_the_search_know_the_model(site):
    name = 'id="baxter_dynamics_ros.BaxterArm.mass_matrix"'
    assert name in (site / 'reference.html').read_text('utf-8')
    assert 'christoffel' in (site / 'searchindex.js').read_text('utf-8').lower()


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


def test_table_five_is_shown_as_it_is_printed(figures):
    evaluation = import_module('drawing.table_five').evaluation('lift', False)
    shown = re.search(r'set 3, lift.*?RMS, defaults ([ \d.]*)',
                      (DOCS / 'experiment.md').read_text('utf-8'), re.DOTALL)
    assert [float(rms) for rms in shown[1].split()] == pytest.approx(
        evaluation.methods['lagrange_euler'].rms, abs=3e-4)
