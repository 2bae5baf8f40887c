"""The errors this package raises."""


class BaxterDynamicsError(Exception):
    """Base class: catches whatever this package raises on purpose."""


class ArgumentError(BaxterDynamicsError, ValueError):
    """
    An argument cannot be used.

    Attributes
    ----------
    argument : str
        The name of the argument.
    problem : str
        Why it cannot be used.

    """

    def __init__(self, argument: str, problem: str) -> None:
        super().__init__(f'{argument}: {problem}')
        self.argument = argument
        self.problem = problem
