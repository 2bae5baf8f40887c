"""What an engine of the benchmark is: its calls, as bare as it hands them out."""

from collections.abc import Callable
from dataclasses import dataclass, field

CALLS = ('tau', 'split', 'matrices', 'forward', 'batch')


@dataclass(frozen=True)
class Engine:
    """
    One engine's calls on float arrays; what it cannot do is None.

    One state is q, qd, qdd, tau of shape (7,) [rad, rad/s, rad/s^2, N m]; a batch has shape
    (n, 7) and is in C order. A result may be overwritten by the next call.
    """

    name: str
    tau: Callable = None  # (q, qd, qdd) -> tau
    split: Callable = None  # (q, qd) -> M (7, 7), C qd (7,), G (7,)
    matrices: Callable = None  # (q, qd) -> M (7, 7), C (7, 7), G (7,)
    forward: Callable = None  # (q, qd, tau) -> qdd
    batch: Callable = None  # (q, qd, qdd) -> tau
    # Of a call that is timed without Python: call -> (*arrays of states) -> (n) -> None, n calls.
    loops: dict = field(default_factory=dict)
    notes: dict = field(default_factory=dict)  # call -> what it is, and what goes with it
    tolerance: float = 1e-9  # within which it must agree to be timed [N m]
