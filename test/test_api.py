"""The public interface is what docs/api.md says, no less and no more."""

import importlib
import inspect
from pathlib import Path
import re
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.cli import main
import pytest

NAME = baxter_dynamics_ros.__name__
REPOSITORY = Path(__file__).resolve().parents[1]
PAGE = (REPOSITORY / 'docs' / 'api.md').read_text(encoding='utf-8')
FIRST_CELLS = [cells[1] for cells in re.findall(r'^(\| `([^`]+)` \|)', PAGE, re.MULTILINE)]


def test_the_version_is_named():
    major, minor, _ = baxter_dynamics_ros.__version__.split('.')
    assert f'version {major}.{minor}\n' in PAGE


def test_names_of_the_package_are_documented():
    plain = [cell for cell in FIRST_CELLS if cell.isidentifier()]
    assert sorted(plain) == sorted(baxter_dynamics_ros.__all__)
    for name in plain:
        assert getattr(baxter_dynamics_ros, name).__class__ is not None


def test_methods_are_documented_with_their_arguments():
    documented = {cell for cell in FIRST_CELLS if re.fullmatch(r'\w+\([\w, ]+\)', cell)}
    methods = inspect.getmembers(BaxterArm, inspect.isfunction)
    assert documented == {
        f'{name}({", ".join(list(inspect.signature(method).parameters)[1:])})'
        for name, method in methods if not name.startswith('_')}


def test_constructor_is_documented_with_its_defaults():
    constructor, = (cell for cell in FIRST_CELLS if cell.startswith('BaxterArm('))
    arguments = dict(re.findall(r"(\w+)=(\([^)]*\)|[\w']+)", constructor))
    parameters = inspect.signature(BaxterArm).parameters
    assert list(arguments) == list(parameters)
    for name, default in arguments.items():
        value = parameters[name].default
        expected = tuple(value) if name == 'gravity' else value
        assert eval(default.replace('−', '-')) == expected


@pytest.mark.parametrize('name', [cell for cell in FIRST_CELLS if cell.startswith(NAME + '.')])
def test_names_elsewhere_exist(name):
    module, _, attribute = name.rpartition('.')
    if '.simulation.' in name:
        pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
    assert inspect.getdoc(getattr(importlib.import_module(module), attribute))


def test_attributes_are_there():
    listed = re.search(r'and the attributes (.*)\.$', PAGE, re.MULTILINE)[1]
    for name in re.findall(r'`(\w+)`', listed):
        assert getattr(BaxterArm(), name) is not None


def test_subcommands_are_documented():
    section = PAGE.split('## Commands')[1].split('their options')[0]
    commands = list(main.VERBS)
    assert re.findall(r'`(\w+)`', section) == ['baxter_dynamics', *commands]


@pytest.mark.parametrize('path', sorted((REPOSITORY / 'launch').iterdir()), ids=lambda p: p.name)
def test_launch_files_are_documented_with_their_arguments(path):
    listed = re.search(rf'`{re.escape(path.name)}` \(([^)]*)\)', PAGE)[1]
    documented = set(re.findall(r'`(\w+)`', listed))
    assert documented == {argument.get('name') for argument in ET.parse(path).findall('arg')}
