"""Messages of a perfect robot, played to a predictor, and checks of the results."""

from typing import NamedTuple

from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import measured, trajectory, VELOCITY_LAG
import pytest

START = 1_700_000_000_000_000_000  # [ns]
RIGHT = joint_names('right')
DELAY = VELOCITY_LAG + np.sqrt(2) / (2 * np.pi * 5.0)  # of predictions, behind the newest [s]
SETTINGS = {mode: PredictorSettings(stamps=mode) for mode in ('auto', 'header', 'arrival')}


def motion(t) -> tuple:
    """Return q, qd, qdd (n, 7) of the robot at times t (n,) [s]."""
    return trajectory(t, 1.25)


def robot(t, stamps):
    """Return the messages of a perfect robot at times t [s] with these stamps [s after START]."""
    stamps = [START + round(stamp * 1e9) for stamp in stamps]
    rows = measured(SETTINGS['auto'], t, motion)
    return [(stamp, RIGHT, *row) for stamp, *row in zip(stamps, *rows)]


class Run(NamedTuple):
    """A predictor and its results, by the index of the message that produced them."""

    predictor: object
    predictions: dict
    external: dict

    def since(self, first: int) -> 'Run':
        """Return the results of messages from index ``first`` on, which becomes zero."""
        return Run(self.predictor, *({i - first: made for i, made in of.items() if i >= first}
                                     for of in self[1:]))

    def withheld(self, after: int) -> int:
        """Return the number of messages from index ``after`` to the next prediction."""
        return min(i for i in self.predictions if i >= after) - after

    def counts(self) -> dict:
        """Return the counts of events, except of messages that wait for the period of stamps."""
        return {event: n for event, n in self.predictor.counts.items()
                if isinstance(event, Event) and event is not Event.AWAITING_PERIOD}


def play(messages, mode) -> Run:
    """Play messages to a new predictor."""
    run = Run(Predictor(SETTINGS[mode], external=True), {}, {})
    for i, message in enumerate(messages):
        step = run.predictor.handle(*message)
        if step.prediction is not None:
            assert step.delay_of(step.estimate) == pytest.approx(DELAY, abs=1e-6)
            run.predictions[i] = step.prediction
        if step.external is not None:
            run.external[i] = step.external
    return run


def stacked(made: dict, *names) -> list:
    """Return fields of results as arrays, one row per result."""
    return [np.array([getattr(each, name) for each in made.values()]) for name in names]


def assert_same(run: Run, wanted: Run):
    """Assert that the results of two runs are equal to the last bit."""
    assert wanted.predictions.keys() == run.predictions.keys() and wanted.predictions
    assert wanted.external.keys() == run.external.keys()
    names = 'stamp_ns', 'q', 'qd', 'qdd', 'effort', 'residual'
    for found, array in zip(stacked(run.predictions, *names), stacked(wanted.predictions, *names)):
        np.testing.assert_array_equal(found, array)
    names = 'stamp_ns', 'q', 'effort'
    for found, array in zip(stacked(run.external, *names), stacked(wanted.external, *names)):
        np.testing.assert_array_equal(found, array)


def back_steps(of: dict) -> dict:
    """Return by how much stamps step back [s], by the index of the message."""
    numbers = list(of)
    steps = np.diff([of[i].stamp_ns for i in numbers])
    return {numbers[k + 1]: -steps[k] * 1e-9 for k in np.flatnonzero(steps <= 0)}


def instants(made: dict) -> np.ndarray:
    """Return the stamps of results [s after START]."""
    return np.array([each.stamp_ns - START for each in made.values()]) * 1e-9


def lags(made: dict, ahead: float) -> np.ndarray:
    """Return how far stamps, less ``ahead``, are behind the instants of the positions [s]."""
    truth, qd, _ = motion(instants(made) - ahead)
    q, = stacked(made, 'q')
    return ((truth - q) * qd).sum(1) / (qd * qd).sum(1)


def assert_right(run: Run, ahead: float = 0.0, late: float = 0.0):
    """
    Assert that results equal the true motion at their stamps less ``ahead`` [s].

    Re-timed stamps may lag by ``late`` [s], the mean delay of the messages.
    """
    margin = 0.016 if late else 1e-4  # [s]; as long after a lock as the line needs
    for made in run[1:]:
        lag = lags(made, ahead)
        print(f'lag {lag.mean() * 1e3:.2f} ms in the mean, {lag.min() * 1e3:.2f} ... '
              f'{lag.max() * 1e3:.2f} ms, of {late * 1e3:.1f} ms')
        assert -margin / 3 < lag.mean() < late + margin / 3
        assert -margin < lag.min() and lag.max() < late + margin
    truth = motion(instants(run.predictions) - ahead - lags(run.predictions, ahead))
    found = stacked(run.predictions, 'q', 'qd', 'qdd', 'residual')
    for x, wanted, error in zip(found, (*truth, 0.0), (5e-4, 0.05, 0.5, 0.4)):
        assert np.abs(x - wanted).max() < error * (1.0 if late else 0.15)
