"""
Compare the model's speed with that of other engines: one table, in one run.

All engines have our parameters and must agree before they are timed; one that is not installed
is left out and named. Run: python benchmarks/model.py [--quick] [--markdown] [--json PATH]
"""

import argparse
import os
from pathlib import Path
import sys

# Read when the libraries are loaded, so that what loads them is imported after this is set.
ONE_THREAD = ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'NUMBA_NUM_THREADS')


def main() -> int:
    """Print the table; return 1 if one of our own calls does not agree."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--quick', action='store_true',
                        help='see that it works: too few rounds for its numbers to mean anything')
    parser.add_argument('--markdown', action='store_true', help='print Markdown')
    parser.add_argument('--json', type=Path, metavar='PATH', help='write all numbers, too')
    arguments = parser.parse_args()
    os.environ.update(dict.fromkeys(ONE_THREAD, '1'))
    from speed import comparison, table
    extent = comparison.QUICK if arguments.quick else comparison.Extent()
    rows = comparison.compare(extent)
    print((table.as_markdown if arguments.markdown else table.as_text)(rows, extent.batch))
    if arguments.json:
        arguments.json.write_text(table.as_json(rows, extent.batch) + '\n', encoding='utf-8')
    refused = [row for row in rows if row.engine.startswith(comparison.OURS)
               and row.difference is not None and row.seconds is None]
    return 1 if refused else 0


if __name__ == '__main__':
    sys.exit(main())
