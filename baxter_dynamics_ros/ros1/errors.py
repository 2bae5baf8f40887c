"""Errors of the connection to a ROS 1 robot: stage, cause and remedy."""

from enum import Enum


class Stage(Enum):
    """Stages from the master's URI to messages, in order."""

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
    """Failure at one stage of the connection to a robot, with cause and remedy."""

    def __init__(self, stage: Stage, cause: str, remedy: str) -> None:
        super().__init__(f'{stage.value}: {cause}: {remedy}')
        self.stage = stage
        self.cause = cause
        self.remedy = remedy


class Malformed(Exception):
    """Data that violate the protocol."""
