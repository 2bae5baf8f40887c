"""Times of several calls that take turns, so that a busy machine is busy for all of them."""

from collections.abc import Callable
import gc
from itertools import cycle, islice
from time import perf_counter


def over_states(call: Callable, *arguments) -> Callable:
    """Return a function (n) -> None that makes n calls, with row after row of the arguments."""
    rows = list(zip(*arguments))

    def run(n: int):
        for row in islice(cycle(rows), n):
            call(*row)

    return run


def alternate(runs: dict, rounds: int, slot: float = 0.002, budget: float = 2.0) -> dict:
    """
    Let the runs take turns and return the times of one call.

    Parameters
    ----------
    runs : dict
        Name -> function (n) -> None that makes n calls.
    rounds : int
        How often each has its turn.
    slot : float
        About how long a turn lasts [s]: as many calls are made in it, but at least one.
    budget : float
        A run that has spent so long [s] misses the remaining rounds, but for the first three.

    Returns
    -------
    dict
        Name -> times of one call [s], one a turn.

    """
    times = {name: [] for name in runs}
    spent = dict.fromkeys(runs, 0.0)
    calls = {}
    for name, run in runs.items():
        calls[name] = 1
        if _time(run, 1) < 20 * slot:  # or else it does not matter what a first call does besides
            for _ in range(2):  # of one call, then of about as many as a turn has
                calls[name] = max(1, round(slot * calls[name] / _time(run, calls[name])))
    gc.collect()
    gc.disable()
    try:
        for turn in range(rounds):
            for name, run in runs.items():
                if turn < 3 or spent[name] < budget:
                    elapsed = _time(run, calls[name])
                    spent[name] += elapsed
                    times[name].append(elapsed / calls[name])
    finally:
        gc.enable()
    return times


def _time(run: Callable, n: int) -> float:
    start = perf_counter()
    run(n)
    return perf_counter() - start
