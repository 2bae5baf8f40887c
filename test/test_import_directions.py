"""Imports point one way, as MAY_IMPORT says; the model and the estimation need NumPy only."""

import ast
import os
from pathlib import Path
import subprocess
import sys

import baxter_dynamics_ros
import pytest

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
    'calibration': 'model estimation recordings',
    'report': 'model files recordings calibration',
    'nodes': 'model estimation ros1',
    'cli': 'model files estimation simulation recordings calibration report export nodes ros1',
}
# ... and in functions only, so that the import waits until it is needed.
MAY_IMPORT_LATE = {'estimation': 'newton_euler', 'nodes': 'simulation calibration recordings'}
# Library -> the parts that may import it.
CONFINED = {
    'pinocchio': 'newton_euler', 'mujoco': 'simulation', 'rosbags': 'recordings',
    'mcap': 'recordings', 'yaml': 'recordings', 'scipy': 'calibration',
    'jinja2': 'report', 'matplotlib': 'report cli', 'rclpy': 'nodes cli', 'rich': 'cli',
}
# Parts that import nothing but themselves, NumPy and the standard library.
NUMPY_ALONE = {'__init__', 'model', 'estimation'}

FILES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob('*.py'))


def test_the_files_are_found():
    assert Path('model', 'arm.py') in FILES


def test_every_part_has_a_rule_and_every_rule_is_needed():
    done = {(_part(file), module[1], late) for file in FILES for module, late in _imports(file)
            if module[0] == NAME and module[1:2] not in ((), (_part(file),))}
    allowed = {(part, name, late) for late, rules in ((False, MAY_IMPORT), (True, MAY_IMPORT_LATE))
               for part, names in rules.items() for name in names.split()}
    assert MAY_IMPORT.keys() == {_part(file) for file in FILES}
    assert allowed - done <= {('__init__', 'model', False)}


@pytest.mark.parametrize('file', FILES, ids=str)
def test_imports_within_the_package(file):
    part = _part(file)
    for module, late in _imports(file):
        if module[0] != NAME:
            continue
        allowed = {part, *MAY_IMPORT[part].split(),
                   *(MAY_IMPORT_LATE.get(part, '').split() if late else ())}
        imported = module[1] if len(module) > 1 else 'model'
        assert imported in allowed, f'{file} imports {".".join(module)}'


@pytest.mark.parametrize('file', FILES, ids=str)
def test_imports_from_elsewhere(file):
    part = _part(file)
    for module, _ in _imports(file):
        top = module[0]
        if part in NUMPY_ALONE:
            assert top in sys.stdlib_module_names | {'numpy', NAME}, f'{file} imports {top}'
        assert part in CONFINED.get(top, part).split(), f'{file} imports {top}'


def test_the_package_loads_numpy_only():
    assert _loaded_by(NAME) == {'numpy', NAME}


def test_model_and_estimation_load_numpy_only():
    modules = ['.'.join((NAME, *file.with_suffix('').parts)) for file in FILES
               if _part(file) in NUMPY_ALONE and file.stem != '__init__']
    assert _loaded_by(*modules) == {'numpy', NAME}


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


def _loaded_by(*modules):
    """Return what importing them loads into a fresh interpreter, beside the standard library."""
    code = (f'import sys; before = set(sys.modules); import {", ".join(modules)}; '
            'print(*{name.split(".")[0] for name in set(sys.modules) - before})')
    path = os.pathsep.join([str(PACKAGE.parent), os.environ.get('PYTHONPATH', '')])
    answer = subprocess.run([sys.executable, '-c', code], env={**os.environ, 'PYTHONPATH': path},
                            check=True, capture_output=True, text=True, timeout=60)
    return set(answer.stdout.split()) - sys.stdlib_module_names
