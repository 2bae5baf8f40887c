"""Recordings and settings that evaluate and calibrate read."""

import argparse
from pathlib import Path
from typing import Any

from .printing import say
from ..model.exceptions import BaxterDynamicsError
from ..recordings.parameter_file import read_parameters
from ..recordings.reader import open_recordings, Recordings


def read_inputs(args: argparse.Namespace) -> tuple[dict[str, Any], Recordings]:
    """Return settings and recordings named by the arguments of add_recordings."""
    def warn(line: str) -> None:
        say(f'warning: {line}')

    paths = [Path(path).expanduser() for path in args.params]
    values = read_parameters(paths, args.node, warn) if paths else {}
    if args.arm and values.get('arm', args.arm) != args.arm:
        warn(f"the parameters are of the {values['arm']} arm; friction, bias and tilt differ "
             'between arms')
    recordings = open_recordings([Path(bag).expanduser() for bag in args.bags], args.topic,
                                 args.arm or values.get('arm'))
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(map(str, args.bags))}: no recordings')
    return values, recordings
