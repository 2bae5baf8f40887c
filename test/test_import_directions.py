"""Imports point one way and are declared; the model and the estimation need NumPy only."""

import ast
from pathlib import Path
import subprocess
import sys
import xml.etree.ElementTree as ET

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
# Imported name: rosdep's key, where it differs; None for what has no key or comes with another.
ROSDEP = {
    **{name: f'python3-{name}'
       for name in ('jinja2', 'matplotlib', 'numpy', 'rich', 'scipy', 'yaml')},
    **{name: f'python3-{name}-pip' for name in ('mujoco', 'rosbags')},
    **dict.fromkeys(('trimesh', 'viser', 'yourdfpy', 'zstandard')), 'mcap': 'mcap-ros2-support'}
NOT_IMPORTED = {'ros2launch'}  # needed, to read the launch files
# Parts that import nothing but themselves, NumPy and the standard library.
NUMPY_ALONE = {'__init__', 'model', 'estimation'}

FILES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob('*.py'))


@pytest.fixture(scope='module')
def imports():
    """Return (file, imported name's parts, whether inside a function) of each import."""
    return [(file, *found) for file in FILES for found in _imports(file)]


def test_every_rule_is_needed_and_every_part_has_one(imports):
    done = {(_part(file), module[1], late) for file, module, late in imports
            if module[0] == NAME and module[1:2] not in ((), (_part(file),))}
    allowed = {(part, name, late) for late, rules in ((False, MAY_IMPORT), (True, MAY_IMPORT_LATE))
               for part, names in rules.items() for name in names.split()}
    assert MAY_IMPORT.keys() == {_part(file) for file in FILES}
    assert allowed - done <= {('__init__', 'model', False)}


def test_modules_and_classes_have_names_of_their_own():
    modules = [path.stem for path in FILES if path.stem != '__init__']
    classes = [node.name for path in FILES for node in ast.walk(ast.parse(
        (PACKAGE / path).read_text(encoding='utf-8'))) if isinstance(node, ast.ClassDef)]
    for names in (modules, classes):
        assert {name for name in names if names.count(name) > 1} == set()


def test_imports_follow_the_rules(imports):
    for file, module, late in imports:
        part, top = _part(file), module[0]
        if top == NAME:
            allowed = {part, *MAY_IMPORT[part].split(),
                       *(MAY_IMPORT_LATE.get(part, '').split() if late else ())}
            assert (*module, 'model')[1] in allowed, f'{file} imports {".".join(module)}'
        elif part in NUMPY_ALONE:
            assert top in sys.stdlib_module_names | {'numpy'}, f'{file} imports {top}'
        else:
            assert part in CONFINED.get(top, part).split(), f'{file} imports {top}'


def test_imports_are_declared_and_nothing_else_is(imports):
    imported = {module[0] for _, module, _ in imports} - sys.stdlib_module_names - {NAME}
    names = {ROSDEP.get(name, name) for name in imported} - {None}
    manifest = ET.parse(Path(__file__).resolve().parents[1] / 'package.xml')
    assert {element.text for element in manifest.iter('exec_depend')} == names | NOT_IMPORTED


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
