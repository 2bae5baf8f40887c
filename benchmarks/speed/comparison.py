"""The comparison as a whole: build the engines, hold them to agree, time them in turns."""

from dataclasses import dataclass
from functools import partial
from math import inf
from statistics import median

from baxter_dynamics_ros import BaxterArm
from engines import load, MODULES

from .agreement import random_states, Reference
from .memory import extra_memory
from .timing import alternate, over_states

BASE = 'Pinocchio'
OURS = 'ours'  # the names of our engines begin with it
BATCH = 'batch'
GROWTH = 'growth'  # rows of batches of several sizes


@dataclass(frozen=True)
class Extent:
    """How much is measured."""

    rounds: int = 150  # turns of each call on one state
    batch_rounds: int = 9
    states: int = 200  # on which agreement is judged, and over which calls on one state go
    batch: int = 100_000
    growth_rounds: int = 5
    sizes: tuple = (10_000, 100_000, 1_000_000)  # of batches that grow
    slot: float = 0.002  # about how long a turn of calls on one state lasts [s]
    batch_slot: float = 0.05  # ... or of batches: the caches are whose turn it is


QUICK = Extent(rounds=3, batch_rounds=3, states=5, batch=10_000, growth_rounds=3,
               sizes=(10_000, 20_000), slot=0.0002, batch_slot=0.002)


@dataclass(frozen=True)
class Row:
    """A line of the table; what does not apply is None."""

    call: str
    engine: str
    size: int = 1  # states at a time
    seconds: float = None  # for one state, median
    best: float = None  # for one state, least
    # One state: its time over that of BASE's tau. Batch: its rate over BASE's. Growth: its time
    # for one state over that in the smallest batch.
    ratio: float = None
    difference: float = None  # from the equations as printed, largest [N m]
    memory: float = None  # beyond arguments and result [bytes]
    note: str = ''


def compare(extent: Extent) -> list:
    """Return the rows of the table, one for each call of each engine."""
    arm = BaxterArm(engine='python')
    built, missing = _build(arm)
    reference = Reference(arm, extent.states)
    agreeing, refused = sort_out(built, reference)
    return missing + refused + _one_state(agreeing, reference, extent) + _batch(
        agreeing, extent) + _growth(agreeing, extent)


def sort_out(built: list, reference: Reference) -> tuple:
    """
    Hold every call of every engine to the reference.

    Returns
    -------
    tuple
        (call, engine's name) -> (engine, difference) of what agrees; rows of what does not.

    """
    agreeing, refused = {}, []
    for engine in built:
        for call, difference in reference.differences(engine).items():
            if difference <= engine.tolerance:  # not so where it is no number
                agreeing[call, engine.name] = engine, difference
            else:
                refused.append(Row(
                    call, engine.name, difference=difference,
                    note=f'NOT TIMED: differs by more than {engine.tolerance:g} N m'))
    return agreeing, refused


def _build(arm) -> tuple:
    """Return the engines, and a row for each that is not installed."""
    built, missing = [], []
    for name in MODULES:
        try:
            built += load(name, arm)
        except ImportError as error:
            missing.append(Row('tau', name, note=f'not installed: {error}'))
    return built, missing


def _one_state(agreeing: dict, reference: Reference, extent: Extent) -> list:
    """Let all calls of all engines take turns on one state, and the next, and the next."""
    q, qd, qdd = reference.states
    arguments = {'tau': (q, qd, qdd), 'split': (q, qd), 'matrices': (q, qd),
                 'forward': (q, qd, reference.tau)}
    runs = {}
    for (call, name), (engine, _) in agreeing.items():
        if call != BATCH:
            over = engine.loops.get(call, partial(over_states, getattr(engine, call)))
            runs[call, name] = over(*arguments[call])
    times = alternate(runs, extent.rounds, extent.slot)
    base = median(times['tau', BASE]) if ('tau', BASE) in times else None
    rows = []
    for (call, name), each in times.items():
        engine, difference = agreeing[call, name]
        rows.append(Row(call, name, 1, median(each), min(each), base and median(each) / base,
                        difference, note=engine.notes.get(call, '')))
    return rows


def _batch(agreeing: dict, extent: Extent) -> list:
    """Let all engines take turns on one batch."""
    states = random_states(extent.batch)
    times = alternate({name: over_states(engine.batch, *([x] for x in states))
                       for (call, name), (engine, _) in agreeing.items() if call == BATCH},
                      extent.batch_rounds, extent.batch_slot)
    base = times.get(BASE)
    rows = []
    for name, each in times.items():
        engine, difference = agreeing[BATCH, name]
        rows.append(Row(
            BATCH, name, extent.batch, median(each) / extent.batch, min(each) / extent.batch,
            base and median(base) / median(each), difference,
            note=engine.notes.get(BATCH, '')))
    return rows


def _growth(agreeing: dict, extent: Extent) -> list:
    """Let our engines take turns on batches of all sizes: to see time and memory grow."""
    states = {size: random_states(size) for size in extent.sizes}
    ours = {name: engine.batch for (call, name), (engine, _) in agreeing.items()
            if call == BATCH and name.startswith(OURS)}
    times = alternate({(size, name): over_states(batch, *([x] for x in states[size]))
                       for name, batch in ours.items() for size in extent.sizes},
                      extent.growth_rounds, extent.batch_slot, budget=inf)
    rows = []
    for (size, name), each in times.items():
        smallest = times[extent.sizes[0], name]  # a moment ago, on a machine as busy
        growth = median(t / s for t, s in zip(each, smallest)) * extent.sizes[0] / size
        rows.append(Row(GROWTH, name, size, median(each) / size, min(each) / size, growth,
                        agreeing[BATCH, name][1],
                        extra_memory(partial(ours[name], *states[size]))))
    return rows
