"""The notebook runs, and is stored with its output and figures."""

import json
import os
from pathlib import Path
import re
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='needs matplotlib: pip install ".[demo]"')

REPOSITORY = Path(__file__).resolve().parents[1]
NOTEBOOK = json.loads((REPOSITORY / 'examples' / 'baxter_arm.ipynb').read_text(encoding='utf-8'))
CODE = [cell for cell in NOTEBOOK['cells'] if cell['cell_type'] == 'code']
SOURCES = [''.join(cell['source']) for cell in CODE]
NUMBER = re.compile(r'(?<![\w.])[+-]?\d+\.?\d*(?:e[+-]?\d+)?')
END = '--- end of cell ---'


def stored(cell, kind):
    """Return a code cell's outputs of a kind."""
    return [output for output in cell['outputs'] if output['output_type'] == kind]


@pytest.fixture(scope='module')
def printed():
    """Return the output of the cells, run in order in one process."""
    script = '\n'.join(f'{source}\nprint({END!r})' for source in SOURCES)
    answer = subprocess.run(
        [sys.executable, '-W', 'ignore', '-c', script], capture_output=True, text=True,
        timeout=60.0, stdin=subprocess.DEVNULL, env={
            **os.environ, 'MPLBACKEND': 'Agg', 'BAXTER_DYNAMICS_ENGINE': 'python',
            'PYTHONPATH': os.pathsep.join([str(REPOSITORY), os.environ.get('PYTHONPATH', '')])})
    assert (answer.returncode, answer.stderr) == (0, '')
    return answer.stdout.split(END + '\n')[:-1]


@pytest.mark.parametrize('k', range(len(CODE)))
def test_a_cell_prints_its_stored_output(k, printed):
    expected = ''.join(''.join(output['text']) for output in stored(CODE[k], 'stream'))
    assert NUMBER.sub('0', expected).split() == NUMBER.sub('0', printed[k]).split()
    numbers = [np.array(NUMBER.findall(text), dtype=float) for text in (expected, printed[k])]
    np.testing.assert_allclose(*numbers, rtol=0.0, atol=2e-3)


def test_is_stored_as_run_from_the_top_with_its_figures():
    assert [cell['execution_count'] for cell in CODE] == list(range(1, len(CODE) + 1))
    figures = [output for cell in CODE for output in stored(cell, 'display_data')]
    assert sum(source.count('plt.show()') for source in SOURCES) == len(figures) > 0
