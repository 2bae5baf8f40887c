"""Launch files in XML, as far as this package's go: read strictly, and run as processes."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

from document_setup import executables, PACKAGE, REPOSITORY

# Element -> the attributes that it may have.
KNOWN = {
    'launch': {'version'},
    'arg': {'name', 'default', 'description', 'value', 'if', 'unless'},
    'choice': {'value'},
    'node': {'pkg', 'exec', 'name', 'namespace', 'output', 'args', 'ros_args', 'if', 'unless'},
    'param': {'name', 'value', 'from'},
    'remap': {'from', 'to'},
    'include': {'file', 'if', 'unless'},
    'group': {'if', 'unless'},
}
_TRUTH = {'true': True, '1': True, 'false': False, '0': False}
_GRACE = 5.0  # [s] between being asked to end and being killed


class LaunchError(Exception):
    """A launch file, or an argument for it, is wrong."""


def nodes(file, given: dict) -> list:
    """Return the command lines of the nodes that a launch file starts, each a list."""
    if not file.is_file():
        raise LaunchError(f'there is no {file}')
    root = ET.parse(file).getroot()
    for element in root.iter():
        unknown = set(element.attrib) - KNOWN.get(element.tag, set())
        if element.tag not in KNOWN or unknown:
            raise LaunchError(f'{file.name}: <{element.tag}> {unknown or "is unknown"}')
    declared = {argument.get('name') for argument in root.findall('arg')}
    if not given.keys() <= declared:
        raise LaunchError(f'{file.name}: has no arguments {set(given) - declared}')
    return _nodes(root, {**given}, file)


def launch(file, given: dict) -> int:
    """Run a launch file's nodes until they end, or all as soon as one fails."""
    commands = nodes(file, given)
    running = [subprocess.Popen([shutil.which(command[0]), *command[1:]]) for command in commands]
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    code = 0
    try:
        while code == 0 and any(process.poll() is None for process in running):
            time.sleep(0.1)
            code = max((process.poll() or 0 for process in running), key=abs)
    except KeyboardInterrupt:
        pass
    if code:
        print(f'[ERROR] [launch]: process has died, exit code {code}', file=sys.stderr)
    for process in running:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
    for process in running:
        try:
            process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
    return code and 1


def _nodes(parent, variables, file):
    found = []
    for element in parent:
        def value(name, element=element):
            return _substituted(element.get(name), variables, file)
        if _TRUTH[(value('unless') or 'false').lower()] or not _TRUTH[
                (value('if') or 'true').lower()]:
            continue
        if element.tag == 'arg' and element.get('name') not in variables:
            if element.get('default') is None:
                raise LaunchError(f"{file.name}: argument {element.get('name')} is not given")
            variables[element.get('name')] = value('default')
        if element.tag == 'arg':
            choices = {choice.get('value') for choice in element}
            if choices and variables[element.get('name')] not in choices:
                raise LaunchError(f"{file.name}: {element.get('name')} is none of {choices}")
        elif element.tag == 'node':
            found.append(_node(element, variables, file))
        elif element.tag == 'group':
            found += _nodes(element, variables, file)
        elif element.tag == 'include':
            inner = {argument.get('name'): _substituted(argument.get('value'), variables, file)
                     for argument in element}
            found += nodes(type(file)(value('file')), inner)
        else:
            raise LaunchError(f'{file.name}: <{element.tag}> in <{parent.tag}>')
    return found


def _node(element, variables, file):
    def of(part, name):
        return _substituted(part.get(name), variables, file)
    if of(element, 'pkg') != PACKAGE or of(element, 'exec') not in executables():
        raise LaunchError(f"{file.name}: no {of(element, 'exec')} in {of(element, 'pkg')}")
    words = (of(element, 'ros_args') or '').split()
    if '--params-file' in words and not os.path.isfile(words[words.index('--params-file') + 1]):
        raise LaunchError(f"{file.name}: there is no {words[words.index('--params-file') + 1]}")
    if element.get('name'):
        words += ['-r', f"__node:={of(element, 'name')}"]
    if of(element, 'namespace'):
        words += ['-r', f"__ns:=/{of(element, 'namespace').strip('/')}"]
    for part in element:
        if part.tag == 'remap':
            words += ['-r', f"{of(part, 'from')}:={of(part, 'to')}"]
        elif part.tag == 'param' and part.get('from'):
            if not os.path.isfile(of(part, 'from')):
                raise LaunchError(f"{file.name}: there is no {of(part, 'from')}")
            words += ['--params-file', of(part, 'from')]
        elif part.tag == 'param':
            words += ['-p', f"{of(part, 'name')}:={of(part, 'value')}"]
        else:
            raise LaunchError(f'{file.name}: <{part.tag}> in <node>')
    return [of(element, 'exec'), *(of(element, 'args') or '').split(), '--ros-args', *words]


def _substituted(text, variables, file):
    def put(match):
        name, *words = match[1].split()
        if name == 'var' and words[0] in variables:
            return variables[words[0]]
        if name == 'find-pkg-share' and words == [PACKAGE]:
            return str(REPOSITORY)
        compared = re.fullmatch(r'eval "\'(.*)\' == \'(.*)\'"', match[1])
        if compared:
            return str(compared[1] == compared[2]).lower()
        raise LaunchError(f'{file.name}: {match[0]} is not known')
    before = None
    while text is not None and text != before:
        before, text = text, re.sub(r'\$\(([^()]*)\)', put, text)
    return text
