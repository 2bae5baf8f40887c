"""Errors of the connection to a ROS 1 robot: step, cause and remedy."""

from enum import Enum


class Step(Enum):
    """Steps from the master's URI to messages, in order."""

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
    Failure of one step of the connection to a robot.

    Attributes
    ----------
    step : Step
        Step that failed.
    found : str
        Cause.
    remedy : str
        Remedy.

    """

    def __init__(self, step: Step, found: str, remedy: str) -> None:
        super().__init__(f'{step.value}: {found}: {remedy}')
        self.step = step
        self.found = found
        self.remedy = remedy


class Malformed(Exception):
    """Data that violate the protocol."""
