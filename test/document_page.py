"""A page of the documents as a reader works through it: in a checkout, command after command."""

import json
import os
import re
import shutil
import subprocess

from document_checks import check
from document_processes import Background, Failure, run
from document_rules import RULES, starts
from markdown_blocks import blocks, commands, words as words_of

NOT_RUN = ('text', 'math')  # kinds of blocks
LOGGED = r'\[INFO\] \[[\d.]+\] \[([\w.]+)\]'  # by a node that has started
FILTERS = ('grep', 'head', 'sort', 'tail', 'wc')  # behind a pipe
_ASSIGNMENT = re.compile(r'[A-Z_]+=')
_PYTHON = """
import json, sys
for line, source in json.load(open(sys.argv[1])):
    exec(compile('\\n' * (line - 1) + source, sys.argv[2], 'exec'), globals())
"""


class Started:
    """
    A command that is left running.

    It may rest, without a process, while nobody listens: it was seen to start before.
    """

    def __init__(self, words, executables_, block, command):
        self.words, self.executables = words, executables_
        self.block, self.command = block, command
        self.process = None


class Page:
    """
    A page that is worked through.

    Parameters
    ----------
    name : str
        Of the file, for what is said about failures.
    text : str
        Its text.
    root : Path
        A checkout of its own.
    path : Path
        The folder of the launchers.
    stand_ins : StandIns
        What the reader has.

    """

    def __init__(self, name, text, root, path, stand_ins):
        self.name, self.root, self.stand_ins = name, root, stand_ins
        self.blocks = blocks(text)
        self.folder = root  # where the reader is
        self.environment = {
            **os.environ, 'COLUMNS': '100',
            'PATH': os.pathsep.join([str(path), os.environ['PATH']]),
            'PYTHONPATH': os.pathsep.join([str(root), os.environ.get('PYTHONPATH', '')])}
        self.failures = []
        self.said = {}  # command -> what it printed
        self._started = []
        self._block = None
        self._command = None

    def work_through(self) -> list:
        """Do what every block says; return what failed, a text each."""
        try:
            for self._block in self.blocks:
                self._command = self._block
                if self._block.kind == 'bash':
                    self._shell(commands(self._block))
                elif self._block.kind not in ('python', *NOT_RUN):
                    self._try(check, self._block)
            self._try(self._python, [block for block in self.blocks if block.kind == 'python'])
            for started in self._started:
                self._command = started.command
                self._try(self._check, started)
        finally:
            awake = [started.process for started in self._started if started.process]
            for process in awake:
                process.ask_to_end()
            for process in awake:
                process.end()
        return self.failures

    def run(self, words) -> str:
        """Run a command to its end; return what it prints."""
        return run(self._found(words), self.folder, self.environment)

    def start(self, words) -> Started:
        """
        Start a command and leave it running; end its like of an earlier block before.

        What has been seen to start on another page, too, waits until somebody listens.
        """
        new = Started(words, starts(words), self._block, self._command)
        for started in list(self._started):
            if started.executables & new.executables and started.block is not self._block:
                self._try(self._check, started)
                self.stop(started)
        self._started.append(new)
        if tuple(words) not in self.stand_ins.seen:
            self._wake(new)
        return new

    def wait_for(self, started, sign, times=1) -> str:
        """Return what a command has said, as soon as it says something; end it otherwise."""
        try:
            started.process.wait_for(sign, times)
        except Failure:
            self.stop(started)
            raise
        return started.process.output

    def stop(self, started):
        """End what was started."""
        self._started.remove(started)
        if started.process:
            started.process.end()

    def rest(self):
        """End for a while what earlier blocks have started: nobody listens."""
        for started in self._started:
            if started.process and started.block is not self._block:
                self._try(self._check, started)
                started.process.end()
                started.process = None

    def need_robot(self):
        """See that all is awake, and a robot and the predictor where a page never starts them."""
        for executable in ('fake_baxter', 'torque_predictor'):
            if not any(executable in self._starts(command.text) for block in self.blocks
                       if block.kind == 'bash' for command in commands(block)) and not any(
                           executable in started.executables for started in self._started):
                self._wake(self.start([executable]))
        for started in self._started:
            self._wake(started)

    def _wake(self, started):
        if started.process is None:
            started.process = Background(self._found(started.words), self.folder,
                                         self.environment)

    def _check(self, started):
        if started.process:
            started.process.check()

    def _starts(self, text):
        return set().union(*(starts(words) for words, _ in self._parts(text, lambda text: '.')))

    def _shell(self, lines):
        for self._command in lines:
            self._try(self._line, self._command.text)
        for started in list(self._started):
            if started.block is self._block and started.process:
                self._command, count = started.command, len(started.executables)
                if self._try(self.wait_for, started, LOGGED if count else '.', count or 1):
                    self.stand_ins.seen.add(tuple(started.words))

    def _line(self, text) -> str:
        output = ''
        for words, pipe in self._parts(text, self._line):
            if pipe:
                output = self._filtered(words, output)
                continue
            before = dict(self.environment)
            while _ASSIGNMENT.match(words[0]):
                name, _, value = words.pop(0).partition('=')
                self.environment[name] = value
            words[0] = words[0].removeprefix('.venv/bin/')
            if words[0] not in RULES:
                raise Failure(f'{words[0]}: say in document_rules.py how it is run')
            output = RULES[words[0]](self, words) or ''
            if words[0] != 'export':
                self.environment = before
        self.said[text] = output.strip() if isinstance(output, str) else ''
        return self.said[text]

    def _parts(self, text, substitute):
        """Return a line's commands, each its words, and whether it reads what was said before."""
        text = re.sub(r'\$\(([^()]*)\)', lambda match: substitute(match[1]), text)
        parts = [([], False)]
        for word in words_of(text):
            if word in ('&&', '&', '|'):
                parts.append(([], word == '|'))
            elif not set(word) - set('|;<>&') or word.startswith(('$', '*')):
                raise Failure(f'{word}: say in document_page.py what it does')
            else:
                parts[-1][0].append(re.sub('^~/', f'{self.root}/home/', word))
        return [part for part in parts if part[0]]

    def _filtered(self, words, text):
        if words[0] not in FILTERS:
            raise Failure(f'| {words[0]}: say in document_page.py what it does')
        return subprocess.run(self._found(words), input=text, capture_output=True, text=True,
                              check=True, env=self.environment, timeout=10.0).stdout

    def _python(self, found):
        if found:
            self._command = found[0]
            if any('rclpy' in block.text for block in found):
                self.need_robot()
            source = self.root.parent / f'{self.root.name}.json'
            source.write_text(json.dumps([(block.line, block.text) for block in found]))
            self.run(['python', '-c', _PYTHON, source, self.name])

    def _found(self, words):
        program = shutil.which(words[0], path=self.environment['PATH'])
        if program is None:
            raise Failure(f'{words[0]} is not there')
        return [program, *map(str, words[1:])]

    def _try(self, function, *arguments):
        try:
            return function(*arguments)
        except Exception as error:  # whatever it is, the page and the line belong to it
            kind = '' if isinstance(error, Failure) else f'{type(error).__name__}: '
            what = getattr(self._command, 'text', '').strip().split('\n')[0]
            self.failures.append(
                f'{self.name}:{self._command.line}: {what}\n{kind}{error}'.rstrip())
