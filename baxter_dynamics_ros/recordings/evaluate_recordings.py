"""Evaluation of recordings: errors of both methods and of three acceleration estimators."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from .bands import RunningBands
from .contact_intervals import Contact, contact_rows, find_contacts, MOST
from .data_check import DataCheck, DataChecker
from .evaluation_results import Evaluation, METHODS, Statistics
from .notices import Notice
from .playback import Block, play
from .recording import Recording
from .running import RunningStatistics
from .stamp_statistics import StampClock, StampStatistics
from ..estimation.events import Event
from ..estimation.explanation import Explained, ResidualExplainer, WINDOW
from ..estimation.predictor import Prediction, Predictor
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array
from ..newton_euler import NewtonEuler

# The robot's stamps deviate from a grid by 0.4 % of its period, times of arrival by over 20 %.
_IRREGULAR = 0.1
_FEW = 100  # predictions below which statistics mean little
_SPACING = 0.04  # of the residuals that are searched for contact [s]


class Evaluator:
    """
    Evaluates recordings one after another, and all of them together.

    Parameters
    ----------
    settings : PredictorSettings
        Settings of the predictor; the arm is that of each recording.

    """

    def __init__(self, settings: PredictorSettings) -> None:
        self._settings = replace(settings, method='lagrange_euler')
        self._total = RunningStatistics()

    def evaluate(self, recording: Recording,
                 progress: Callable[[int], object] = lambda received: None) -> Evaluation:
        """Evaluate an open recording; call progress with the number of messages read so far."""
        run = _Run(replace(self._settings, arm=recording.arm), self._total)
        for block in play(recording, run.predictor):
            run.add(block)
            progress(run.predictor.counts['received'])
        return run.result(recording)

    def total(self) -> Statistics:
        """Return the statistics over all recordings so far."""
        return self._total.result()


class _Run:
    """Evaluation of one recording."""

    def __init__(self, settings: PredictorSettings, total: RunningStatistics) -> None:
        self.predictor = Predictor(settings)
        self._settings = settings
        self._newton_euler = NewtonEuler(settings.model.arm)
        self._statistics = RunningStatistics(), total
        self._bands = RunningBands(['measured', *METHODS,
                                    *('error_' + name for name in METHODS), 'deviation'])
        self._clock = StampClock()
        self._checker = DataChecker(settings)
        self._residuals = _ThinnedResiduals()
        self._explanations = _Explanations(settings)

    def add(self, block: Block) -> None:
        """Add a block of estimates."""
        estimate = block.estimate
        prediction = self.predictor.predict(estimate)
        pairs, terms = self._compare(block, prediction)
        for statistics in self._statistics:
            statistics.add(self._settings.arm, pairs, terms, prediction.deviation)
        time = self._clock.elapsed(estimate.stamp_ns, block.dt)
        measured = pairs['lagrange_euler'][0]
        efforts = [pairs[name][1] for name in METHODS]
        self._bands.add(time, np.stack([
            measured, *efforts, *(measured - effort for effort in efforts),
            prediction.deviation], axis=1))
        there = np.isfinite(measured[:, 0])
        state = np.stack([estimate.q, estimate.qd, estimate.qdd, measured], axis=1)
        self._checker.add(time[there], state[there], block.q[there], block.measured_qd[there])
        self._residuals.add(time[there], (measured - prediction.effort)[there], estimate.q[there])
        self._explanations.add(time, prediction)

    def _compare(self, block: Block, prediction: Prediction
                 ) -> tuple[dict[str, tuple[Array, Array]], dict[str, Array]]:
        """Return measured and predicted effort by each method and estimator, and the terms."""
        model = self._settings.model.effort_model
        _, q, qd, qdd, measured, z = block.estimate
        assert measured is not None  # in a block it is NaN instead
        # The closed form predicts once; the rest uses the faster method, equal within 1e-12.
        still = np.zeros_like(q)
        tau, unaccelerated, gravity, live, difference = self._newton_euler.inverse_dynamics(
            np.stack([q, q, q, block.q, block.q]),
            np.stack([qd, qd, still, block.qd, block.qd]),
            np.stack([qdd, still, still, qdd, block.first_difference]))
        live = model.effort(live, block.q, block.qd, qdd, z)
        difference = model.effort(difference, block.q, block.qd, block.first_difference, z)
        aligned = prediction.effort if self._settings.align else np.full_like(q, np.nan)
        pairs = {'lagrange_euler': (measured, prediction.effort),
                 'newton_euler': (measured, model.effort(tau, q, qd, qdd, z)),
                 'first_difference': (block.effort, difference),
                 'butterworth_live': (block.effort, live),
                 'butterworth_aligned': (measured, aligned)}
        terms = {'inertial': tau - unaccelerated, 'coriolis': unaccelerated - gravity,
                 'gravity': gravity.round(12),  # exactly zero at s0
                 'spring': model.spring(q), 'friction': model.friction(qd, z)}
        effort = tau + terms['spring'] + terms['friction'] + model.other(q, qdd)
        terms['other'] = model.other(q, qdd) + model.coupled(effort) - effort
        return pairs, terms

    def result(self, recording: Recording) -> Evaluation:
        """Return the results."""
        time, bands = self._bands.result()
        stamps = self._clock.result()
        check = self._checker.result()
        contacts, share = self._residuals.contacts()
        if share > MOST or check is not None and any(one.refuses for one in check.problems):
            contacts = []  # errors of the model would be reported as contact
        return Evaluation(
            **vars(self._statistics[0].result()) | {'arm': recording.arm},
            name=recording.name, topic=recording.topic,
            duration=stamps.duration, rate=stamps.rate,
            counts={getattr(key, 'value', key): n for key, n in self.predictor.counts.items()},
            notices=tuple(self._notices(stamps, check, contacts)), time=time, bands=bands,
            check=check, contacts=tuple(contacts),
            explained=self._explanations.result())

    def _notices(self, stamps: StampStatistics, check: 'DataCheck | None',
                 contacts: list[Contact]) -> Iterator[Notice]:
        if check is not None:
            yield from check.problems
        for contact in contacts:
            yield Notice('contact', f'contact: {contact}', (contact.joint,))
        counts = self.predictor.counts
        if not counts['predicted']:
            yield Notice('nothing', "nothing could be predicted: the arm's joint states are too "
                         'few, or too often interrupted for the filter to settle')
        elif counts['predicted'] < _FEW:
            yield Notice('few', f'only {counts["predicted"]} predictions: these statistics mean '
                         'little')
        if not counts[Event.REPEATED_STAMP] and stamps.irregularity > _IRREGULAR:
            yield Notice('stamps', 'stamps are irregular: they deviate from a regular period by '
                         f'{100 * stamps.irregularity:.0f} %. They appear to be times of arrival, '
                         "which blur the accelerations: record with the robot's own stamps")
        elif stamps.lost and not counts[Event.REPEATED_STAMP]:
            yield Notice('lost', f'{stamps.lost} messages are lost: stamps are missing from their '
                         f'regular period of {1e3 * stamps.period:.1f} ms')
        for event in Event:
            if event.remedy and counts[event]:
                yield Notice(event.value, f'{counts[event]} x {event.value}: {event.remedy}')


class _Explanations:
    """Explanations of the residual, one for every ten seconds."""

    def __init__(self, settings: PredictorSettings) -> None:
        self._explainer = ResidualExplainer(settings.model.arm, settings.model.effort_model)
        self._found: list[Explained] = []
        self._next = WINDOW  # time of the next explanation [s]

    def add(self, time: Array, prediction: Prediction) -> None:
        """Add predictions at times (n,) [s]."""
        for i, now in enumerate(time):
            one: Any = Prediction(*(field[i] for field in prediction))  # type: ignore[index]
            if np.isfinite(one.residual[0]):
                self._explainer.add(one)
            if now >= self._next:
                self._found.append(self._explainer.explain())
                self._next = now + WINDOW

    def result(self) -> tuple[Explained, ...]:
        """Return the explanations; that of the whole recording if it is shorter."""
        return tuple(self._found or [self._explainer.explain()])


class _ThinnedResiduals:
    """Residuals at 25 Hz in single precision: an hour of them is 6 MB."""

    def __init__(self) -> None:
        self._last = -1.0  # interval of the latest residual
        self._parts: list[tuple[Array, Any, Any]] = []

    def add(self, time: Array, residual: Array, q: Array) -> None:
        """Add samples (n,), (n, 7), (n, 7), most of which are dropped."""
        intervals = np.floor(time / _SPACING)
        new = np.flatnonzero(np.diff(intervals, prepend=self._last))
        if len(new):
            self._last = intervals[-1]
            self._parts.append((time[new], residual[new].astype(np.float32),
                                q[new].astype(np.float32)))

    def contacts(self) -> tuple[list[Contact], float]:
        """Return the contacts, and the share of the time in contact."""
        if not self._parts:
            return [], 0.0
        time, residual, q = (np.concatenate(column) for column in zip(*self._parts))
        contacts = find_contacts(time, residual, q)
        return contacts, float(contact_rows(time, contacts).mean())
