"""What each part of measured effort costs where it is ignored: a fake Baxter has them all."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from baxter_dynamics_ros import JOINTS
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.recordings.playback import play
from baxter_dynamics_ros.simulation.plant import COULOMB
from baxter_dynamics_ros.simulation.recorder import record
from baxter_dynamics_ros.simulation.robot import FakeBaxter
import numpy as np

Settings = dict[str, Any]  # of the node, by name
Rows = dict[str, np.ndarray]  # what is ignored -> RMS of the residual (7,) [N m]

SIDE, RATE = 'right', 100.0  # [Hz]
WIDE, FAST = 'exciting', 'switch'  # a motion that shows each term, and one of quick changes
DURATION = {WIDE: 15.0, FAST: 8.0}  # [s]

# What this robot's effort has beyond tau, besides the springs, in the units of EffortModel.
TRUE: dict[str, tuple[float, ...]] = {
    'bias': (0.3, -0.4, 0.3, 0.2, -0.1, 0.1, 0.05),
    'coulomb': COULOMB,
    'dahl': (0.2, 0.6, 0.2, 0.1, 0.05, 0.05, 0.02),
    'viscous': (0.2, 0.2, 0.1, 0.1, 0.02, 0.02, 0.01),
    'stiffness': (0.3, 0.0, 0.2, 0.1, 0.05, 0.05, 0.02),
    'added_inertia': (0.1, 0.0, 0.05, 0.05, 0.01, 0.01, 0.005),
}

_NO_LAG: Settings = {'acceleration.velocity_lag': 0.0}
_NOT_ALIGNED: Settings = {'align': False}


@lru_cache(maxsize=None)
def messages(trajectory: str, noise: bool) -> tuple[tuple[Any, ...], ...]:
    """Return what the fake Baxter publishes, as a recording's joint states."""
    truth = PredictorSettings(told()).effort_model
    robot = FakeBaxter(SIDE, trajectory, truth=truth, noise=noise)
    return tuple((stamp, *fields, stamp)
                 for stamp, *fields in record(robot, DURATION[trajectory], RATE))


def told(without: str = '') -> Settings:
    """Return the node's settings that know the truth, but for one term."""
    settings: Settings = {f'effort_model.{name}': value
                          for name, value in TRUE.items() if name != without}
    if without == 'spring':
        settings['effort_model.spring_coefficients'] = (0.0,) * 5
    return settings


def rms(settings: Settings, trajectory: str = WIDE,
        noise: bool = False) -> tuple[np.ndarray, ...]:
    """Return the RMS of the residual and of the effort, each (7,) [N m], as the node has them."""
    predictor = PredictorSettings({'arm': SIDE, **settings}).predictor()
    measured, predicted = [], []
    for part in play(messages(trajectory, noise), predictor):
        measured.append(np.asarray(part.estimate.measured))
        predicted.append(predictor.predict(part.estimate).effort)
    effort = np.concatenate(measured)
    residual = effort - np.concatenate(predicted)
    return tuple(np.sqrt(np.mean(x ** 2, axis=0)) for x in (residual, effort))


def wide() -> Rows:
    """Return the RMS of the residual (7,) [N m] on the wide motion, by what is ignored."""
    none, effort = rms(told())
    found = {'(effort itself)': effort, 'nothing': none}
    found |= {name.replace('_', ' '): rms(told(without=name))[0] for name in ('spring', *TRUE)}
    found['lag of velocity'] = rms(told() | _NO_LAG)[0]
    found['delay of filter'] = rms(told() | _NOT_ALIGNED)[0]
    return found


def fast() -> Rows:
    """Return the same on the motion of quick changes, of what has to do with time."""
    none, effort = rms(told(), FAST)
    return {'(effort itself)': effort, 'nothing': none,
            'lag of velocity': rms(told() | _NO_LAG, FAST)[0],
            'delay of filter': rms(told() | _NOT_ALIGNED, FAST)[0]}


def noisy() -> Rows:
    """Return the same on the wide motion as the robot's sensors show it."""
    return {'nothing': rms(told(), noise=True)[0],
            'all but spring': rms({}, noise=True)[0],
            'all': rms({'effort_model.enabled': False}, noise=True)[0]}


def table() -> str:
    """Return the evidence as text."""
    return '\n'.join(['RMS of the residual [N m]', *block(f'{WIDE}, ignored:', wide()),
                      *block(f'{FAST}, ignored:', fast()),
                      *block(f'{WIDE}, with noise:', noisy())])


def block(head: str, rows: Rows) -> list[str]:
    """Return the lines of one part of the table."""
    return [f'{head:22}' + ''.join(f'{joint:>8}' for joint in JOINTS),
            *(f'  {name:20}' + ''.join(f'{x:8.3f}' for x in values)
              for name, values in rows.items())]
