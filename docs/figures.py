"""
Make the figures of the documents again: all of them, or those that are named.

Run: python docs/figures.py [NAME ...] [-o DIR] [--list]; needs pip install '.[demo]'
"""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
import subprocess
import sys

from baxter_dynamics_ros import BaxterDynamicsError
from baxter_dynamics_ros.files import staged

FOLDER = Path(__file__).resolve().parent / 'figures'

# File -> the module beside this one, and its function that draws the file whose path it is given.
FIGURES = {
    'demo.png': ('drawing.commands', 'demo'),
    'report.png': ('drawing.commands', 'report'),
    'watch.svg': ('drawing.watch', 'draw'),
    'architecture.svg': ('drawing.architecture', 'draw'),
    'residual.png': ('drawing.residual', 'draw'),
    'arm_as_printed.svg': ('drawing.model', 'arm_as_printed'),
    'torque_as_printed.svg': ('drawing.model', 'torque_as_printed'),
    'inertia_as_printed.svg': ('drawing.model', 'inertia_as_printed'),
    'spring.svg': ('drawing.effort', 'spring'),
    'friction.svg': ('drawing.effort', 'friction'),
    'sensors.svg': ('drawing.effort', 'sensors'),
    'control_loop.svg': ('drawing.control', 'control_loop'),
    'trajectories.svg': ('drawing.experiment', 'trajectories'),
    'experiment_circle.png': ('drawing.experiment', 'circle'),
    'experiment_switch.png': ('drawing.experiment', 'switch'),
    'experiment_lift.png': ('drawing.experiment', 'lift'),
    'table_five.svg': ('drawing.experiment', 'table_five'),
}


def draw(file: str, folder: Path) -> Path:
    """
    Draw a figure of the table into a folder, and return its path.

    It is there when it is complete: what fails leaves what was there before.
    """
    module, function = FIGURES[file]
    with staged(folder, file) as stage:
        getattr(import_module(module), function)(stage / file)
    return folder / file


def main(arguments: list[str] | None = None) -> int:
    """Draw what is asked for; return the exit code."""
    files = {Path(file).stem: file for file in FIGURES}
    parser = argparse.ArgumentParser(prog='figures.py', description=__doc__.splitlines()[1])
    parser.add_argument('names', nargs='*', metavar='NAME', help='which; all by default')
    parser.add_argument('-o', '--output', type=Path, default=FOLDER, metavar='DIR',
                        help='the folder (default: docs/figures)')
    parser.add_argument('--list', action='store_true', help='print the names, and draw nothing')
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in files]
    if unknown:
        parser.error(f'no figure {unknown[0]}; there are {", ".join(files)}')
    if options.list:
        print('\n'.join(options.names or files))
        return 0
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        for name in options.names or files:
            print(draw(files[name], options.output))
    except ModuleNotFoundError as error:
        print(f"figures.py: {error.name} is missing: pip install '.[demo]'", file=sys.stderr)
        return 1
    except OSError as error:
        where = f'{error.filename}: ' if error.filename else ''
        print(f'figures.py: {where}{error.strerror}', file=sys.stderr)
        return 1
    except (BaxterDynamicsError, subprocess.SubprocessError) as error:
        print(f'figures.py: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
