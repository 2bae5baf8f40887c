"""Evaluation of recordings: errors of both methods and of three acceleration estimators."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from .data_check import DataCheck, event_notices, Notice, RunningCheck
from .evaluation_results import (Evaluation, METHODS, RunningBands, RunningStatistics, Statistics)
from .playback import (Contact, contact_rows, find_contacts, MOST_CONTACT, play, Samples,
                       stamp_statistics, StampStatistics)
from .recording import Recording
from ..estimation.events import Event
from ..estimation.explanation import Explained, ResidualExplainer, WINDOW
from ..estimation.predictor import Prediction, Predictor
from ..estimation.settings import PredictorSettings
from ..model import Array
from ..newton_euler import NewtonEuler

# The robot's stamps deviate from a grid by 0.4 % of its period, times of arrival by over 20 %.
_IRREGULAR = 0.1
_FEW = 100  # predictions below which statistics mean little
_SPACING = 0.04  # of the residuals that are searched for contact [s]


class Evaluator:
    """
    Evaluates recordings one after another, and all of them together.

    Each recording is evaluated with the arm that it contains. Memory holds the time between
    messages, and residual and position at 25 Hz.
    """

    def __init__(self, settings: PredictorSettings) -> None:
        self._settings = replace(settings, method='lagrange_euler')
        self._total = RunningStatistics()

    def evaluate(self, recording: Recording,
                 progress: Callable[[int], object] = lambda received: None) -> Evaluation:
        """Evaluate an open recording; call progress with the number of messages read so far."""
        run = _Run(replace(self._settings, arm=recording.arm), self._total)
        for samples in play(recording, run.predictor):
            run.add(samples)
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
        self._explainer = ResidualExplainer(settings.model.arm, settings.model.effort_model)
        self._explained: list[Explained] = []
        self._next = WINDOW  # time of the next explanation [s]
        self._dt: list[Array] = []  # time since the previous measurement [s]
        self._bands = RunningBands(['measured', *METHODS, 'deviation',
                                    *(f'error_{name}' for name in METHODS)])
        self._check = RunningCheck(settings)
        self._spaced: list[list[Array]] = []  # time [s], residual [N m], position [rad]
        self._interval = -1.0  # latest interval of _SPACING that has a sample

    def add(self, samples: Samples) -> None:
        """Add consecutive samples."""
        prediction = self.predictor.predict(samples.estimate)
        efforts, terms = self._compare(samples, prediction)
        for statistics in self._statistics:
            statistics.add(self._settings.arm, efforts, terms, prediction.deviation)
        self._explain(samples.time, prediction)
        self._dt.append(samples.dt)
        predicted = [efforts[name][1] for name in METHODS]
        errors = [samples.effort - effort for effort in predicted]
        self._bands.add(samples.time, np.stack(
            [samples.effort, *predicted, prediction.deviation, *errors], axis=1))
        there = np.isfinite(samples.effort[:, 0])
        samples, residual = samples.take(there), errors[0][there]
        self._check.add(samples)
        interval = np.floor(samples.time / _SPACING)
        rows = np.flatnonzero(np.diff(interval, prepend=self._interval))
        self._interval = interval[-1] if len(interval) else self._interval
        self._spaced.append([samples.time[rows], residual[rows].astype(np.float32),
                             samples.q[rows].astype(np.float32)])

    def _compare(self, samples: Samples, prediction: Prediction
                 ) -> tuple[dict[str, tuple[Array, Array]], dict[str, Array]]:
        """Return measured and predicted effort by each method and estimator, and the terms."""
        model = self._settings.model.effort_model
        q, qd, qdd, z = samples.q, samples.qd, samples.qdd, samples.dahl
        newest_q, newest_qd = samples.newest_q, samples.usable_qd
        # The closed form predicts once; the rest uses the faster method, equal within 1e-12.
        still = np.zeros_like(q)
        tau, unaccelerated, gravity, live, difference = self._newton_euler.inverse_dynamics(
            np.stack([q, q, q, newest_q, newest_q]),
            np.stack([qd, qd, still, newest_qd, newest_qd]),
            np.stack([qdd, still, still, qdd, samples.first_difference]))
        live = model.effort(live, newest_q, newest_qd, qdd, z)
        difference = model.effort(difference, newest_q, newest_qd, samples.first_difference, z)
        aligned = prediction.effort if self._settings.align else np.full_like(q, np.nan)
        efforts = {'lagrange_euler': (samples.effort, prediction.effort),
                   'newton_euler': (samples.effort, model.effort(tau, q, qd, qdd, z)),
                   'first_difference': (samples.newest_effort, difference),
                   'butterworth_live': (samples.newest_effort, live),
                   'butterworth_aligned': (samples.effort, aligned)}
        terms = {'inertial': tau - unaccelerated, 'coriolis': unaccelerated - gravity,
                 'gravity': gravity.round(12),  # exactly zero at s0
                 'spring': model.spring(q), 'friction': model.friction(qd, z)}
        effort = tau + terms['spring'] + terms['friction'] + model.other(q, qdd)
        terms['other'] = model.other(q, qdd) + model.coupled(effort) - effort
        return efforts, terms

    def _explain(self, time: Array, prediction: Prediction) -> None:
        """Explain the residual every ten seconds."""
        batch: Any = prediction
        for now, *values in zip(time, *batch):
            one: Any = Prediction(*values)
            has_effort = np.isfinite(one.residual[0])
            self._explainer.add(one if has_effort else one._replace(residual=None))
            if now >= self._next:
                self._explained.append(self._explainer.explain())
                self._next = now + WINDOW

    def result(self, recording: Recording) -> Evaluation:
        """Return the results."""
        time, bands = self._bands.result()
        is_wrong = any(notice.refuses for notice in event_notices(self.predictor.counts))
        check = None if is_wrong else self._check.result()
        contacts = [] if is_wrong else self._contacts(check)
        stamps = stamp_statistics(np.concatenate(self._dt))
        return Evaluation(
            **vars(self._statistics[0].result()), name=recording.name, topic=recording.topic,
            duration=stamps.duration, rate=stamps.rate,
            counts={getattr(key, 'value', key): n for key, n in self.predictor.counts.items()},
            notices=tuple(self._notices(stamps, check, contacts)), time=time, bands=bands,
            check=check, contacts=tuple(contacts),
            # A recording shorter than the window is explained as a whole.
            explained=tuple(self._explained or [self._explainer.explain()]))

    def _contacts(self, check: 'DataCheck | None') -> list[Contact]:
        """Return the contacts, unless errors of the model would look like them."""
        time, residual, q = map(np.concatenate, zip(*self._spaced))
        contacts = find_contacts(time, residual, q)
        refused = check is not None and any(one.refuses for one in check.problems)
        mostly = contact_rows(time, contacts).sum() > MOST_CONTACT * len(time)
        return [] if refused or mostly else contacts

    def _notices(self, stamps: StampStatistics, check: 'DataCheck | None',
                 contacts: list[Contact]) -> Iterator[Notice]:
        if check is not None:
            yield from check.problems
        for contact in contacts:
            yield Notice('contact', f'contact: {contact}', (contact.joint,))
        counts = self.predictor.counts
        if not counts['predicted']:
            yield Notice('nothing', f'nothing could be predicted: {counts["taken"]} of '
                         f'{counts["received"]} joint states are valid, too few or too often '
                         'interrupted for the filter to settle')
        elif counts['predicted'] < _FEW:
            yield Notice('few', f'only {counts["predicted"]} predictions: too few for statistics')
        if not counts[Event.REPEATED_STAMP] and stamps.irregularity > _IRREGULAR:
            yield Notice('stamps', 'stamps are irregular: they deviate from a regular period by '
                         f'{100 * stamps.irregularity:.0f} %. They appear to be times of arrival, '
                         "which blur the accelerations: record with the robot's own stamps")
        elif stamps.lost and not counts[Event.REPEATED_STAMP]:
            yield Notice('lost', f'{stamps.lost} messages missing (period {stamps.period:.3g} s)')
        yield from event_notices(counts)
