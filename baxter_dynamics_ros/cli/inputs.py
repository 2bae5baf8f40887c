"""Recordings and settings that evaluate and calibrate read."""

import argparse
from pathlib import Path
from typing import Any

from .printing import say
from ..model.exceptions import BaxterDynamicsError
from ..recordings.parameter_file import read_parameters
from ..recordings.reader import open_recordings, Recordings


def read_inputs(args: argparse.Namespace) -> tuple[dict[str, Any], Recordings]:
    """
    Return the settings of the predictor, by name, and the recordings, to be opened.

    Parameters
    ----------
    args : Namespace
        With the arguments of :func:`.options.add_recordings`.

    Raises
    ------
    BaxterDynamicsError
        If something cannot be read or used, or there is no recording.

    """
    def warn(line: str) -> None:
        say(f'warning: {line}')

    paths = [Path(path).expanduser() for path in args.params]
    values = read_parameters(paths, args.node, warn) if paths else {}
    if args.arm and values.get('arm', args.arm) != args.arm:
        warn(f"the parameters are of the {values['arm']} arm: friction, bias and tilt belong to "
             'one arm')
    recordings = open_recordings([Path(bag).expanduser() for bag in args.bags], args.topic,
                                 args.arm or values.get('arm'))
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(map(str, args.bags))}: no recordings')
    return values, recordings
