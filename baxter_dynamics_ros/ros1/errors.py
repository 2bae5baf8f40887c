"""Failures on the way to a ROS 1 robot: the step that failed, the finding and the remedy."""

from enum import Enum


class Step(Enum):
    """Steps from a master's URI to its messages, in order."""

    NAME = 'name'
    ROUTE = 'route'
    PORT = 'port'
    MASTER = 'master'
    ADDRESS = 'address'
    TOPIC = 'topic'
    PUBLISHER = 'publisher'
    TYPE = 'type'
    STREAM = 'stream'


class Ros1Error(Exception):
    """
    A step towards the robot's messages failed.

    Attributes
    ----------
    step : Step
        The step.
    found : str
        What was found instead of what is needed.
    remedy : str
        What to do.

    """

    def __init__(self, step: Step, found: str, remedy: str) -> None:
        super().__init__(f'{step.value}: {found}: {remedy}')
        self.step = step
        self.found = found
        self.remedy = remedy


class Malformed(Exception):
    """Bytes that are not what the protocol says."""
