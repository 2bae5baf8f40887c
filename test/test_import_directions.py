"""Imports point one way, as MAY_IMPORT says; the model and the estimation need NumPy only."""

import ast
from pathlib import Path
import subprocess
import sys

import baxter_dynamics_ros

PACKAGE = Path(baxter_dynamics_ros.__file__).resolve().parent
NAME = PACKAGE.name

# Part of the package -> the other parts it may import, at the top of a module or in functions.
MAY_IMPORT = {
    '__init__': 'model',  # it re-exports the model
    'model': '',
    'files': 'model',
    'newton_euler': 'model',
    'estimation': 'model',
    'ros1': '',
    'export': 'model simulation',
    'simulation': 'model files',
    'recordings': 'model files estimation newton_euler',
    'calibration': 'files model estimation recordings',
    'report': 'model files recordings calibration',
    'nodes': 'model estimation ros1',
    'cli': 'model files estimation simulation recordings calibration export nodes ros1',
}
# ... and in functions only, so that the import waits until it is needed.
MAY_IMPORT_LATE = {'cli': 'report', 'estimation': 'newton_euler',
                   'nodes': 'simulation calibration recordings'}
# Library -> the parts that may import it.
CONFINED = {
    'pinocchio': 'newton_euler', 'mujoco': 'simulation', 'rosbags': 'recordings',
    'mcap': 'recordings', 'yaml': 'recordings', 'scipy': 'calibration',
    'jinja2': 'report', 'matplotlib': 'report cli', 'rclpy': 'nodes cli', 'rich': 'cli',
}
# Parts that import nothing but themselves, NumPy and the standard library.
NUMPY_ALONE = {'__init__', 'model', 'estimation'}

FILES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob('*.py'))


def test_every_rule_is_needed_and_every_part_has_one():
    done = {(_part(file), module[1], late) for file, module, late in IMPORTS
            if module[0] == NAME and module[1:2] not in ((), (_part(file),))}
    allowed = {(part, name, late) for late, rules in ((False, MAY_IMPORT), (True, MAY_IMPORT_LATE))
               for part, names in rules.items() for name in names.split()}
    assert MAY_IMPORT.keys() == {_part(file) for file in FILES}
    assert allowed - done <= {('__init__', 'model', False)}


def test_imports_follow_the_rules():
    for file, module, late in IMPORTS:
        part, top = _part(file), module[0]
        if top == NAME:
            allowed = {part, *MAY_IMPORT[part].split(),
                       *(MAY_IMPORT_LATE.get(part, '').split() if late else ())}
            assert (*module, 'model')[1] in allowed, f'{file} imports {".".join(module)}'
        elif part in NUMPY_ALONE:
            assert top in sys.stdlib_module_names | {'numpy'}, f'{file} imports {top}'
        else:
            assert part in CONFINED.get(top, part).split(), f'{file} imports {top}'


def test_model_and_estimation_load_numpy_only():
    modules = ['.'.join((NAME, *file.with_suffix('').parts)) for file in FILES
               if _part(file) in NUMPY_ALONE and file.stem != '__init__']
    code = (f'import sys; before = set(sys.modules); import {", ".join(modules)}; '
            'print(*{name.split(".")[0] for name in set(sys.modules) - before})')
    answer = subprocess.run([sys.executable, '-c', code], cwd=PACKAGE.parent, check=True,
                            capture_output=True, text=True, timeout=60)
    assert set(answer.stdout.split()) - sys.stdlib_module_names == {'numpy', NAME}


def _part(file):
    """Return the folder, or the module in the root, of a file."""
    return Path(file.parts[0]).stem


def _imports(file):
    """Yield (name parts, whether inside a function) of each module that a file imports."""
    tree = ast.parse((PACKAGE / file).read_text(encoding='utf-8'))
    functions = [node for node in ast.walk(tree)
                 if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
    late = {node for function in functions for node in ast.walk(function)}
    here = (NAME, *file.with_suffix('').parts)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield tuple(alias.name.split('.')), node in late
        elif isinstance(node, ast.ImportFrom):
            base = here[:-node.level] if node.level else ()
            base += tuple(node.module.split('.')) if node.module else ()
            for alias in node.names:
                # `from .. import x`: x is a part, or a name that the root hands out.
                is_part = base == (NAME,) and alias.name in MAY_IMPORT
                yield (base + (alias.name,) if is_part else base), node in late


IMPORTS = [(file, *found) for file in FILES for found in _imports(file)]
