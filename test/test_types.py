"""The package passes mypy, and a user's type checker sees its types."""

from pathlib import Path
import re
import subprocess
import sys

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
PACKAGE = REPOSITORY / 'baxter_dynamics_ros'
OLDEST = '2.4'  # version of mypy: older ones, such as Ubuntu's, report other errors

# A user's code, with mypy's answer to each line: a revealed type, or the code of an error.
SNIPPET = """
import numpy as np

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros import Payload
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel

arm = BaxterArm(payload=Payload(0.5, [0.0, 0.0, 0.1]), gravity=(0, 0, -1.62))
q = [0.0] * 7
reveal_type(arm.gravity(q))  # ndarray
reveal_type(arm.terms(q, np.zeros((3, 7)))[0])  # ndarray
reveal_type(EffortModel(bias=np.zeros(7)).has_friction)  # bool
predictor = Predictor(PredictorSettings(arm='left'))
step = predictor.handle(0, ['left_s0'], np.zeros(1), np.zeros(1), np.zeros(1))
reveal_type(step.begins)  # bool
BaxterArm(payload=3)  # arg-type
BaxterArm(grippers=2)  # call-arg
arm.inverse_dynamics(q, q)  # call-arg
arm.coriolis(q, q)  # attr-defined
step.prediction.effort  # union-attr
"""

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope='module')
def report(tmp_path_factory):
    """Return mypy's lines about the package, and those about the snippet by line number."""
    pytest.importorskip('mypy.version', OLDEST, reason=f'needs mypy {OLDEST}')
    snippet = tmp_path_factory.mktemp('types') / 'snippet.py'
    snippet.write_text(SNIPPET, encoding='utf-8')
    mypy = subprocess.run([sys.executable, '-m', 'mypy', PACKAGE, snippet], cwd=REPOSITORY,
                          timeout=280, capture_output=True, text=True)
    assert mypy.returncode in (0, 1), mypy.stdout + mypy.stderr  # 2: it does not get so far
    # mypy's cache may name the folder of an earlier run.
    about = re.findall(r'/snippet\.py:(\d+): (?:error|note: Revealed)(.*)', mypy.stdout)
    return ([line for line in mypy.stdout.splitlines()[:-1] if '/snippet.py:' not in line],
            {int(number): text for number, text in about})


def test_package(report):
    assert (PACKAGE / 'py.typed').is_file()
    assert report[0] == []


def test_what_users_see(report):
    for number, line in enumerate(SNIPPET.splitlines(), 1):
        code, _, expected = line.partition('  # ')
        said = report[1].get(number, '')
        if code.startswith('reveal_type'):
            assert re.match(r' type is "(?:\w+\.)*(\w+)', said)[1] == expected
        else:
            assert said.rpartition('[')[2].strip(']') == expected
