"""Markdown taken apart: its blocks, the commands in them, and what is wrong with its form."""

from collections import Counter
from dataclasses import dataclass
import re
import shlex

from markdown_it import MarkdownIt

INDENTED = 'indented code'  # the kind of a block that has no fence
# Up to a comment: it begins with # after a space, outside of quotes.
_UNCOMMENTED = re.compile(r"""(?:'[^']*'|"[^"]*"|\\.|(?<=\S)\#|[^#'"\\])*""")


@dataclass(frozen=True)
class Block:
    """A block of code: what its fence says it is, the line where its text begins, its text."""

    kind: str
    line: int
    text: str


@dataclass(frozen=True)
class Command:
    """A line of a shell, continued lines joined and comments taken off, and where it stands."""

    line: int
    text: str


def blocks(text: str) -> list:
    """Return the blocks of code of a Markdown text, in order."""
    found = []
    for token in MarkdownIt('commonmark').parse(text):
        if token.type == 'fence':
            found.append(Block(token.info.strip(), token.map[0] + 2, token.content))
        elif token.type == 'code_block':
            found.append(Block(INDENTED, token.map[0] + 1, token.content))
    return found


def commands(block: Block) -> list:
    """Return the commands in a block, each a line of a shell."""
    found, first, joined = [], None, ''
    for number, line in enumerate(block.text.splitlines(), block.line):
        first = number if first is None else first
        if line.endswith('\\'):
            joined += line[:-1] + ' '
            continue
        text = _UNCOMMENTED.match(joined + line)[0].strip()
        if text:
            found.append(Command(first, text))
        first, joined = None, ''
    if joined:
        found.append(Command(first, joined.strip()))
    return found


def words(text: str) -> list:
    """Return a command's words; the operators of the shell (&, &&, |, ;, <, >) are their own."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars='&|;<>')
    lexer.whitespace_split, lexer.commenters = True, ''
    return list(lexer)


def links(text: str) -> list:
    """Return the links and images of a Markdown text: (line, address, is an image, its text)."""
    found = []
    for token in MarkdownIt('commonmark').enable('table').parse(text):
        for child in token.children or ():
            if child.type in ('link_open', 'image'):
                image = child.type == 'image'
                found.append((token.map[0] + 1, child.attrs['src' if image else 'href'], image,
                              child.content))
    return found


def spans(text: str) -> list:
    """Return the code within the lines of a Markdown text: (line, code)."""
    return [(token.map[0] + 1, child.content)
            for token in MarkdownIt('commonmark').enable('table').parse(text)
            for child in token.children or () if child.type == 'code_inline']


def anchors(text: str) -> list:
    """Return the anchors that a forge gives the headings of a Markdown text."""
    tokens = MarkdownIt('commonmark').parse(text)
    found = []
    for heading, inline in zip(tokens, tokens[1:]):
        if heading.type == 'heading_open':
            said = ''.join(child.content for child in inline.children).lower()
            found.append(re.sub(r'[^\w\- ]', '', said).replace(' ', '-'))
    return found


def faults(text: str) -> list:
    """Return what is wrong with the form of a Markdown text, a line each."""
    found = [f'two headings with the anchor #{anchor}'
             for anchor, count in Counter(anchors(text)).items() if count > 1]
    lines = text.splitlines()
    for token in MarkdownIt('commonmark').enable('table').parse(text):
        if token.type == 'table_open':
            rows = range(*token.map)
            widths = [_cells(lines[row]) for row in rows]
            found += [f'line {row + 1}: {width} cells in a table of {widths[0]} columns'
                      for row, width in zip(rows, widths) if width != widths[0]]
        elif token.type in ('html_block', 'html_inline'):
            found.append(f'line {token.map[0] + 1}: HTML: {token.content.strip()}')
        for child in token.children or ():
            if child.type == 'html_inline' and child.content != '<br>':
                found.append(f'line {token.map[0] + 1}: HTML: {child.content}')
            elif child.type == 'image' and not child.content:
                found.append(f"line {token.map[0] + 1}: no text for {child.attrs['src']}")
    return found


def _cells(row: str) -> int:
    inner = re.sub(r'^\||(?<!\\)\|$', '', row.strip())
    return len(re.findall(r'(?<!\\)\|', inner)) + 1
