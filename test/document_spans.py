"""Commands that a document names within a sentence: they are not run, but could be."""

from importlib.util import find_spec
import re

from document_processes import Failure
from document_rules import accepted, installable, RULES, starts
from document_setup import executables, PACKAGE
from markdown_blocks import spans, words as words_of

# What stands for something else: a name in capitals, a choice, what is left out.
_PLACEHOLDER = re.compile(r'[{}…]|(?<![\w$.:/-])[A-Z]{2,}(?![\w=])')


def wrong(text: str, root) -> list:
    """Return the commands within the sentences of a page that could not be run, and why."""
    found = []
    for line, code in spans(text):
        try:
            words = words_of(code)
            while words and re.match(r'[A-Z_]+=', words[0]):
                words.pop(0)
            if len(words) > 1 and words[0].removeprefix('.venv/bin/') in RULES:
                _check([words[0].removeprefix('.venv/bin/'), *words[1:]], code, root)
        except ValueError:
            pass  # no command: a quote without an end
        except Failure as error:
            found.append(f'line {line}: `{code}`: {error}')
    return found


def _check(words, code, root):
    program, first, *rest = words
    vague = _PLACEHOLDER.search(code)
    if program == 'baxter_dynamics' and not vague and not (
            first in ('evaluate', 'calibrate', 'experiment') and not _positional(rest)):
        accepted(words[1:])
    elif program in ('python', 'python3') and first == '-m':
        if rest[0].startswith(PACKAGE) and find_spec(rest[0]) is None:
            raise Failure(f'there is no {rest[0]}')
    elif program in ('python', 'python3', 'pytest'):
        for word in words[1:]:
            if '/' in word and not (root / word.split('::')[0]).exists():
                raise Failure(f'there is no {word}')
        if (root / first).is_file() and not vague:
            source = (root / first).read_text(encoding='utf-8')
            for word in rest:
                if word not in source:
                    raise Failure(f'{first} knows no {word}')
    elif program == 'pip' and not vague:
        installable(words, root)
    elif words[:2] == ['ros2', 'run'] and rest[:1] == [PACKAGE]:
        if rest[1] not in executables():
            raise Failure(f'there is no executable {rest[1]}')
    elif words[:2] == ['ros2', 'launch'] and rest[:1] == [PACKAGE] and not vague:
        starts(words)


def _positional(words):
    return [word for word in words if not word.startswith('-')]
