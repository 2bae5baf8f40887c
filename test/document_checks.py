"""Blocks that are no programs are what they say they are."""

import json
import xml.etree.ElementTree as ET

from document_processes import Failure
import yaml


def check(block):
    """See that a block which is no program is what it says it is."""
    if block.kind == 'json':
        json.loads(block.text)
    elif block.kind == 'xml':
        ET.fromstring(block.text)
    elif block.kind == 'yaml':
        _parameters(yaml.safe_load(block.text))
    else:
        raise Failure(f'a block of kind "{block.kind}": say what it is, by a fence with bash, '
                      'python, yaml, xml, json, text or math')


def _parameters(read):
    """See that YAML is a parameter file, or a part of one, for the predictor."""
    from baxter_dynamics_ros.estimation.settings import PredictorSettings
    from baxter_dynamics_ros.recordings.parameter_file import flat
    while isinstance(read, dict) and len(read) == 1 and not isinstance(
            next(iter(read.values())), (str, float, int, list)):
        (name, inner), = read.items()
        if name not in ('/**', '/*', 'torque_predictor', '/torque_predictor', 'ros__parameters'):
            break
        read = inner
    if not isinstance(read, dict):
        raise Failure('no parameters')
    PredictorSettings(dict(flat(read)))
