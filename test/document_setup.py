"""What setup.py says of the package: its name, its executables, its extras."""

import ast
from pathlib import Path

PACKAGE = 'baxter_dynamics_ros'
REPOSITORY = Path(__file__).resolve().parents[1]


def executables() -> dict:
    """Return the commands that the package installs: name to 'module:function'."""
    for node in ast.walk(_setup()):
        if isinstance(node, ast.keyword) and node.arg == 'entry_points':
            scripts = ast.literal_eval(node.value)['console_scripts']
            return dict(script.split(' = ') for script in scripts)


def extras() -> set:
    """Return the extras that the package has."""
    for node in ast.walk(_setup()):
        if isinstance(node, ast.keyword) and node.arg == 'extras_require':
            return {key.value for key in node.value.keys}


def distributions() -> set:
    """Return the names of what setup.py asks pip for."""
    texts = (node.value for node in ast.walk(_setup()) if isinstance(node, ast.Constant))
    return {text.partition('==')[0] for text in texts if isinstance(text, str)}


def _setup() -> ast.Module:
    return ast.parse((REPOSITORY / 'setup.py').read_text(encoding='utf-8'))
