"""The documents' figures are there, shown and made by their command; so are its tables."""

from importlib import import_module
from pathlib import Path
import re
import xml.etree.ElementTree as ET

from baxter_dynamics_ros.model.paper_tables import TABLE_V, TABLE_V_SUM
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
DOCS = REPOSITORY / 'docs'
PAGES = [REPOSITORY / 'README.md', *sorted(DOCS.glob('*.md'))]
IMAGE = re.compile(r'!\[([^\]]*)\]\(([^)]+)\)')
NUMBER = re.compile(r'(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])')
ROUNDING = 1e-9  # numbers below it are rounding errors, which no two machines share
CHEAP = ('arm_as_printed', 'spring', 'friction', 'control_loop')  # under a second each


@pytest.fixture
def beside(monkeypatch):
    """Return a function that imports a module of the folder docs."""
    monkeypatch.syspath_prepend(str(DOCS))
    return import_module


@pytest.fixture
def drawn(beside, tmp_path):
    """Return a function that draws figures into a folder by the command."""
    for module in ('matplotlib', 'mujoco', 'pinocchio'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')

    def run(*names, folder='figures'):
        assert beside('figures').main([*names, '-o', str(tmp_path / folder)]) == 0
        return tmp_path / folder

    return run


def images():
    """Yield page, alternative text and path of each image of the documents."""
    for page in PAGES:
        for text, target in IMAGE.findall(page.read_text(encoding='utf-8')):
            yield page, text, (page.parent / target).resolve()


def block(page, first):
    """Return the block of a page that begins with a line."""
    text = (DOCS / page).read_text(encoding='utf-8')
    return re.search(rf'```text\n({re.escape(first)}.*?)\n```', text, re.DOTALL)[1]


def assert_same(shown, printed):
    """Assert that two texts differ by a unit of their numbers' last digits, or by rounding."""
    assert NUMBER.sub('#', shown).split() == NUMBER.sub('#', printed).split()
    for ours, theirs in zip(NUMBER.findall(shown), NUMBER.findall(printed)):
        unit = 10.0 ** -len(theirs.partition('.')[2])
        if max(abs(float(ours)), abs(float(theirs))) > ROUNDING:
            assert float(ours) == pytest.approx(float(theirs), rel=0.0, abs=1.1 * unit)


def test_each_figure_is_in_the_table_in_the_folder_and_on_a_page(beside, capsys):
    figures = beside('figures')
    made = set(figures.FIGURES)
    assert {path.name for path in (DOCS / 'figures').iterdir()} == made
    assert {path.name for _, _, path in images() if path.parent == DOCS / 'figures'} == made
    assert figures.main(['--list']) == 0
    assert sorted(capsys.readouterr().out.split()) == sorted(Path(name).stem for name in made)


def test_each_image_says_in_words_what_it_shows():
    shown = list(images())
    assert len(shown) > 10
    for page, text, path in shown:
        assert path.is_file(), (page, path)
        assert len(text.split()) >= 5, (page, path)


@pytest.mark.parametrize('name', CHEAP)
def test_figures_are_drawn_as_they_are_shown(drawn, name):
    (path,) = drawn(name).iterdir()
    assert path.name == f'{name}.svg'
    root = ET.parse(path).getroot()
    assert float(root.get('width').removesuffix('pt')) == 576.0  # what a forge's page is wide
    assert '#ffffff' in next(iter(root.iter('{http://www.w3.org/2000/svg}path'))).get('style')
    shown = ET.parse(DOCS / 'figures' / path.name)
    assert [element.tag for element in root.iter()] == [element.tag for element in shown.iter()]


def test_figures_are_the_same_bytes_each_time(drawn):
    once, again = (drawn('friction', folder=folder) for folder in ('once', 'again'))
    assert (once / 'friction.svg').read_bytes() == (again / 'friction.svg').read_bytes()


def test_a_figure_that_fails_leaves_the_one_before(drawn, beside, tmp_path, monkeypatch):
    (tmp_path / 'broken_figure.py').write_text(
        'def draw(path):\n    path.write_text("half")\n    raise OSError(28, "disk is full")\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(beside('figures').FIGURES, 'spring.svg', ('broken_figure', 'draw'))
    folder = tmp_path / 'figures'
    folder.mkdir()
    (folder / 'spring.svg').write_text('before')
    assert beside('figures').main(['spring', '-o', str(folder)]) == 1
    assert [path.read_text() for path in folder.iterdir()] == ['before']


def test_what_cannot_be_is_one_line(drawn, beside, tmp_path, capsys):
    figures = beside('figures')
    with pytest.raises(SystemExit) as end:
        figures.main(['no_such_figure'])
    assert end.value.code == 2
    assert 'no figure no_such_figure; there are ' in capsys.readouterr().err
    (tmp_path / 'file').write_text('mine')
    assert figures.main(['spring', '-o', str(tmp_path / 'file')]) == 1
    assert capsys.readouterr().err.count('\n') == 1


def test_the_corrections_are_worth_what_the_page_says(beside, capsys):
    for module in ('pinocchio', 'mujoco'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')
    assert beside('evidence').main(['corrections']) == 0
    printed = capsys.readouterr().out.rstrip()
    assert_same(block('model.md', printed.splitlines()[0]), printed)


def test_time_costs_what_the_page_says(beside):
    for module in ('rosbags', 'mujoco'):
        pytest.importorskip(module, reason=f'needs {module}: pip install ".[demo]"')
    effort = beside('measured.effort')
    printed = effort.block(f'{effort.FAST}, ignored:', effort.fast())
    shown = block('effort.md', 'RMS of the residual [N m]').splitlines()
    start = shown.index(printed[0])
    assert_same('\n'.join(shown[start:start + len(printed)]), '\n'.join(printed))


def test_table_five_is_quoted_as_printed():
    rows = [line for line in block('experiment.md', '|signed mean| of e').splitlines()
            if line.startswith('paper')]
    assert len(rows) == 6
    for row, (number, method) in zip(rows, (
            (number, method) for number in range(3) for method in TABLE_V)):
        expected = [*TABLE_V[method][number], TABLE_V_SUM[method][number]]
        assert [float(x) for x in row.split()[-8:]] == expected
