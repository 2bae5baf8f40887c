"""What a calibration says about the robot, in sentences: lag, tilt, friction, what it carries."""

import math

import numpy as np

from .calibration_terms import per_joint, value_text
from .findings import Finding, percent, torque
from .page import change, number, plus_minus
from ..calibration.calibration_results import Calibration
from ..calibration.joint_terms import GAIN
from ..estimation.settings import PredictorSettings
from ..model.joints import JOINTS
from ..recordings.data_check import USUAL_LAG


def remarks(calibration: Calibration) -> list[Finding]:
    """Return what is known of this robot now; as findings."""
    found = [_lag(calibration), _tilt(calibration), _offset(calibration), _friction(calibration),
             _spring(calibration), _payload(calibration)]
    return [finding for finding in found if finding is not None]


def tilt(settings: PredictorSettings) -> tuple[float, ...]:
    """Return by how much the base leans: in all, forward and to the left [degrees]."""
    x, y, z = settings.gravity
    return tuple(math.degrees(math.atan2(part, abs(z))) for part in (math.hypot(x, y), x, y))


def _lag(calibration: Calibration) -> Finding:
    used = 1e3 * calibration.after.acceleration.velocity_lag
    lag = calibration.lag
    if lag is None:
        return Finding('Velocity lag', 'Not measured: there is no measured velocity, or no joint '
                       f'moves. The settings have {number(used, 1)}\u00a0ms.')
    text = (f'{plus_minus(1e3 * lag.value, 1e3 * lag.uncertainty)}\u00a0ms, measured; '
            f'{number(1e3 * USUAL_LAG, 0)}\u00a0ms are usual on Baxter. ')
    apart = abs(used - 1e3 * lag.value)
    if apart < 0.1:
        text += 'The settings have what was measured; before and after are judged with it.'
    elif apart < 1.1:
        text += (f'The settings keep {number(used, 1)}\u00a0ms: a difference of less than '
                 '1\u00a0ms does not matter.')
    else:
        text += f'The settings have {number(used, 1)}\u00a0ms.'
    odd = np.flatnonzero(np.abs(lag.per_joint - lag.value) > 0.003)  # none where NaN
    if len(odd):
        text += ' Other than the rest: ' + ', '.join(
            f'{JOINTS[i]} ({number(1e3 * lag.per_joint[i], 1)}\u00a0ms)' for i in odd) + '.'
    return Finding('Velocity lag', text)


def _tilt(calibration: Calibration) -> 'Finding | None':
    fitted = {one.component: one for one in calibration.of_term('tilt')}
    if not fitted:
        return None
    (before, *_), (total, forward, left) = tilt(calibration.before), tilt(calibration.after)
    size = math.hypot(*calibration.after.gravity)
    sigma = [math.degrees(fitted[axis].deviation / size) for axis in 'xy']
    return Finding('Tilt of the base', f'{number(total, 1)}° ({number(before, 1)}° before): '
                   f'{number(abs(forward), 1)} ± {number(sigma[0], 1)}° '
                   f'{"forward" if forward >= 0 else "backward"} and '
                   f'{number(abs(left), 1)} ± {number(sigma[1], 1)}° to the '
                   f'{"left" if left >= 0 else "right"}.')


def _offset(calibration: Calibration) -> 'Finding | None':
    bias = per_joint(calibration, 'bias')
    if not bias:
        return None
    most = max(bias, key=lambda i: abs(bias[i].value))
    return Finding('Offset', f'The largest is at {JOINTS[most]}, {value_text(bias[most])}.')


def _friction(calibration: Calibration) -> 'Finding | None':
    model = calibration.after.effort_model
    slow = np.add(model.coulomb, model.dahl)
    if not slow.any() or not model.enabled:
        return None
    most = int(slow.argmax())
    memory = model.dahl[most] / slow[most]
    return Finding('Friction', f'{JOINTS[most]} has most, {torque(slow[most])} (Coulomb and Dahl '
                   f'together); {percent(memory)} of it has a memory, which shows as '
                   'hysteresis.')


def _spring(calibration: Calibration) -> 'Finding | None':
    fitted = calibration.of_term('spring')
    if not fitted:
        return None
    if fitted[0].component != GAIN:
        return Finding('Spring', 'Its shape was fitted to this robot; the figure below shows '
                       'what changed.')
    gain = fitted[0]
    return Finding('Spring', f'{change(gain.before, gain.value)} against the shape it had '
                   f'(gain {value_text(gain)}).')


def _payload(calibration: Calibration) -> 'Finding | None':
    fitted = {one.component: one for one in calibration.of_term('payload')}
    if not fitted:
        return None
    text = f'{value_text(fitted["mass"])}'
    if 'center x' in fitted:
        centers = [fitted[f'center {axis}'] for axis in 'xyz']
        center = ', '.join(f'{number(1e3 * one.value, 0)} ± {number(1e3 * one.deviation, 0)}'
                           for one in centers)
        text += f", its centre of mass at ({center})\u00a0mm in the hand's frame"
    return Finding('Payload', f'{text}.')
