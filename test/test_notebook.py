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


@pytest.fixture(scope='module')
def printed():
    """Return the output of the cells, run in order in one process."""
    script = '\n'.join(f'{source}\nprint({END!r})' for source in SOURCES)
    answer = subprocess.run(
        [sys.executable, '-W', 'ignore', '-c', script], capture_output=True, text=True,
        timeout=60.0, stdin=subprocess.DEVNULL, cwd=REPOSITORY,
        env={**os.environ, 'MPLBACKEND': 'Agg', 'BAXTER_DYNAMICS_ENGINE': 'python'})
    assert (answer.returncode, answer.stderr) == (0, '')
    return answer.stdout.split(END + '\n')[:-1]


def test_cells_print_their_stored_output(printed):
    assert [cell['execution_count'] for cell in CODE] == list(range(1, len(CODE) + 1))
    for cell, found in zip(CODE, printed, strict=True):
        shown = ''.join(''.join(output['text']) for output in cell['outputs']
                        if output['output_type'] == 'stream')
        assert NUMBER.sub('0', shown).split() == NUMBER.sub('0', found).split()
        numbers = [np.array(NUMBER.findall(text), dtype=float) for text in (shown, found)]
        np.testing.assert_allclose(*numbers, rtol=0.0, atol=2e-3)


def test_figures_are_stored():
    figures = [output for cell in CODE for output in cell['outputs']
               if output['output_type'] == 'display_data']
    assert sum(source.count('plt.show()') for source in SOURCES) == len(figures) > 0
