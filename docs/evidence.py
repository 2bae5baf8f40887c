"""
Print the tables of the documents: what the model, the effort and the experiment are judged by.

Run: python docs/evidence.py corrections (or effort, table_five); needs pip install '.[demo]'
"""

from __future__ import annotations

import argparse
from importlib import import_module
import sys

from baxter_dynamics_ros import BaxterDynamicsError

# What can be printed, and the module beside this file whose table() returns it.
TABLES = {
    'corrections': 'measured.model',
    'effort': 'measured.effort',
    'table_five': 'measured.experiment',
}


def main(arguments: list[str] | None = None) -> int:
    """Print the tables that are asked for; return the exit code."""
    parser = argparse.ArgumentParser(prog='evidence.py', description=__doc__.splitlines()[1])
    parser.add_argument('tables', nargs='+', choices=TABLES, metavar='TABLE',
                        help=', '.join(TABLES))
    for name in parser.parse_args(arguments).tables:
        try:
            print(import_module(TABLES[name]).table())
        except ModuleNotFoundError as error:
            print(f"evidence.py: {name} needs {error.name}: pip install '.[demo]'",
                  file=sys.stderr)
            return 1
        except BaxterDynamicsError as error:
            print(f'evidence.py: {error}', file=sys.stderr)
            return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
