"""
Sphinx project of the pages and the Python reference.

Build: sphinx-build -W docs build/html, or rosdoc2 build -p . on a machine with ROS.
"""

from pathlib import Path
import re
import sys

# rosdoc2 copies this folder beside a conf.py that executes this file.
original = re.search(r'exec\(open\("(.*)/docs/conf.py"', Path(__file__).read_text('utf-8'))
ROOT = Path(original[1]) if original else Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

project = 'baxter_dynamics_ros'
author = copyright = 'the contributors'  # noqa: A001 (Sphinx asks for this name)
extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.mathjax', 'sphinx.ext.napoleon',
              'sphinx.ext.viewcode']
source_suffix = {'.rst': 'restructuredtext', '.md': 'markdown', '.txt': 'markdown'}
exclude_patterns = ['drawing']
html_static_path = [str(ROOT / 'docs' / '_static')]
html_theme_options = {'description': "The dynamics of the Baxter robot's arms",
                      'page_width': '1240px', 'sidebar_width': '270px', 'body_max_width': 'none'}
myst_enable_extensions = ['amsmath', 'dollarmath']
myst_heading_anchors = 3
autodoc_default_options = {'members': True}
autodoc_typehints = 'none'  # the docstrings have shapes and units
napoleon_use_ivar = True


def page(text):
    """Return a page as MyST wants it: equations, links to the README and out of this folder."""
    # equation*: its only number is the paper's, from \tag.
    text = re.sub(r'```math\n(.*?)```', r'\\begin{equation*}\n\1\\end{equation*}', text,
                  flags=re.DOTALL)
    text = re.sub(r'\$`(.*?)`\$', r'$\1$', text, flags=re.DOTALL)
    text = re.sub(r'\]\((?:\.\./)?README\.md', '](index.txt', text).replace('](docs/', '](')
    return re.sub(r'(?<!!)\[([^\]]*)\]\(([^)]*)\)', local_link, text)


def local_link(match):
    """Return a link, or its text alone if it leads out of this folder."""
    words, target = match.groups()
    is_kept = re.match('https?:|#', target) or (
        not target.startswith('..') and (ROOT / 'docs' / target.partition('#')[0]).exists())
    return match[0] if is_kept else words


def read_page(app, docname, source):
    """Change a page before it is parsed; the first page begins with the README."""
    if docname == 'index':
        source[0] = (ROOT / 'README.md').read_text(encoding='utf-8') + source[0]
    source[0] = page(source[0])


def setup(app):
    """Connect the changes to Sphinx's event."""
    app.connect('source-read', read_page)
