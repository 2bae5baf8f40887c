"""Imports point one way: as the table of rooms in docs/architecture.md says; core is NumPy."""

import ast
import os
from pathlib import Path
import subprocess
import sys

import baxter_dynamics_ros
import pytest
from rooms import rooms

PACKAGE = Path(baxter_dynamics_ros.__file__).resolve().parent
NAME = PACKAGE.name

# The rule is the table in docs/architecture.md. The root's __init__ re-exports the model.
MAY_IMPORT = {'__init__': {'model'}, **{
    name: {name, *room.imports} for name, room in rooms().items()}}
# ... and inside a function only, so that the import waits until someone asks for it.
MAY_IMPORT_LATE = {name: set(room.late) for name, room in rooms().items()}

# Parts that import nothing but themselves, NumPy and the standard library.
NUMPY_ALONE = {'__init__', 'model', 'estimation'}
# What is confined -> the parts it is confined to.
CONFINED = {
    **{library: {name} for name, room in rooms().items() for library in room.libraries},
    'rclpy': {'nodes', 'cli'},
    'matplotlib': {'report', 'cli'},
}

FILES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob('*.py'))


def test_the_files_are_found():
    assert Path('model', 'arm.py') in FILES


def test_the_documented_rooms_are_those_there_are():
    assert MAY_IMPORT.keys() == {_part(file) for file in FILES}
    assert list(rooms())[0] == 'model' and 'pinocchio' in CONFINED


def test_a_room_may_import_what_is_documented_and_does():
    done = {part: {(module[1], late) for file in FILES if _part(file) == part
                   for module, late in _imports(file)
                   if module[0] == NAME and module[1:2] not in ((), (part,))}
            for part in rooms()}
    for name, room in rooms().items():
        assert {part for part, late in done[name] if not late} >= set(room.imports), name
        assert {part for part, late in done[name] if late} >= set(room.late), name


def test_what_imports_numpy_alone_is_documented_so():
    for name in NUMPY_ALONE - {'__init__'}:
        assert rooms()[name].libraries == ()


@pytest.mark.parametrize('file', FILES, ids=str)
def test_imports_within_the_package(file):
    part = _part(file)
    assert part in MAY_IMPORT, f'{file}: say in docs/architecture.md what it may import'
    for module, late in _imports(file):
        if module[0] != NAME:
            continue
        allowed = MAY_IMPORT[part] | (MAY_IMPORT_LATE.get(part, set()) if late else set())
        imported = module[1] if len(module) > 1 else 'model'
        assert imported in allowed, f'{file} imports {".".join(module)}'


@pytest.mark.parametrize('file', FILES, ids=str)
def test_imports_from_elsewhere(file):
    part = _part(file)
    for module, _ in _imports(file):
        top = module[0]
        if part in NUMPY_ALONE:
            assert top in sys.stdlib_module_names | {'numpy', NAME}, f'{file} imports {top}'
        assert part in CONFINED.get(top, {part}), f'{file} imports {top}'


def test_the_package_loads_numpy_alone():
    assert _loaded_by(NAME) == {'numpy', NAME}


def test_core_and_signals_load_numpy_alone():
    modules = ['.'.join((NAME, *file.with_suffix('').parts)) for file in FILES
               if _part(file) in NUMPY_ALONE and file.stem != '__init__']
    assert _loaded_by(*modules) == {'numpy', NAME}


def _part(file):
    """Return the folder, or the module in the root, that a file belongs to."""
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
