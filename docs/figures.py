"""
Draw the figures of the documentation, or print its tables.

Run: python docs/figures.py [NAME ...] [-o DIR]; needs pip install '.[demo]'
"""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
import sys

from baxter_dynamics_ros import BaxterDynamicsError
from baxter_dynamics_ros.files import staged

FOLDER = Path(__file__).resolve().parent / 'figures'

# File -> module and function that draws it into a path.
FIGURES = {
    'report.png': ('drawing.commands', 'report'),
    'watch.svg': ('drawing.commands', 'watch'),
    'panel.png': ('drawing.commands', 'panel'),
    'residual.png': ('drawing.residual', 'causes'),
    'residual_band.svg': ('drawing.residual', 'band'),
    'arm_as_printed.svg': ('drawing.model', 'arm_as_printed'),
    'torque_as_printed.svg': ('drawing.model', 'torque_as_printed'),
    'joints.png': ('drawing.joints', 'draw'),
    'spring.svg': ('drawing.effort', 'spring'),
    'friction.svg': ('drawing.effort', 'friction'),
    'experiment_circle.png': ('drawing.experiment', 'circle'),
    'table_five.svg': ('drawing.experiment', 'table_five'),
}
# Name of a table -> module with a function table() that returns it.
TABLES = {'table_five_rows': 'drawing.table_five'}


def draw(file: str, folder: Path) -> Path:
    """Draw a figure into a folder, once complete, and return its path."""
    module, function = FIGURES[file]
    with staged(folder, file) as stage:
        getattr(import_module(module), function)(stage / file)
    return folder / file


def main(arguments: list[str] | None = None) -> int:
    """Draw or print what is named; return the exit code."""
    files = {Path(file).stem: file for file in FIGURES}
    parser = argparse.ArgumentParser(description='Draw the figures of the documentation, or '
                                     'print its tables.')
    parser.add_argument('names', nargs='*', metavar='NAME', choices=[*files, *TABLES, []],
                        help=f'{", ".join((*files, *TABLES))} (default: all figures)')
    parser.add_argument('-o', '--output', type=Path, default=FOLDER, metavar='DIR',
                        help='folder for the figures (default: docs/figures)')
    options = parser.parse_args(arguments)
    try:
        for name in options.names or files:
            print(import_module(TABLES[name]).table() if name in TABLES else
                  draw(files[name], options.output))
    except (ModuleNotFoundError, OSError, BaxterDynamicsError) as error:
        print(f'figures.py: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
