"""
Generate the committed files of the closed form, or count the operations of its forms.

python -m tools.closed_form [sizes]
"""

import argparse
from pathlib import Path

from baxter_dynamics_ros.model import _closed_form

from .sizes import table
from .write import header_text, python_text, source_text


def generated() -> dict[Path, str]:
    """Return the generated files: path -> text."""
    path = Path(_closed_form.__file__)
    return {path: python_text(), path.with_suffix('.h'): header_text(),
            path.with_suffix('.c'): source_text()}


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog='python -m tools.closed_form',
                                     description='Generate model/_closed_form.py, .c and .h.')
    parser.add_argument('what', nargs='?', choices=['files', 'sizes'], default='files',
                        help='sizes: print the operations of each form of the dynamics')
    if parser.parse_args().what == 'sizes':
        print(table())
        return
    for path, text in generated().items():
        path.write_text(text, encoding='utf-8')
        print(f'wrote {path}')


if __name__ == '__main__':
    main()
