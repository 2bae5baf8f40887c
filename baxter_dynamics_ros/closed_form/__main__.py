"""
Write the generated module anew, or print how large each form of the dynamics is.

python -m baxter_dynamics_ros.closed_form [sizes]
"""

import argparse

from .module import PATH, write_module
from .sizes import table


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog='python -m baxter_dynamics_ros.closed_form',
                                     description='Write model/_closed_form.py anew.')
    parser.add_argument('what', nargs='?', choices=['module', 'sizes'], default='module',
                        help='sizes: print how large each form of the dynamics is')
    if parser.parse_args().what == 'sizes':
        print(table())
    else:
        write_module()
        print(f'wrote {PATH}')


if __name__ == '__main__':
    main()
