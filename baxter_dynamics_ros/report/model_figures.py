"""The calibrated model, drawn: parameters, the spring at s1, friction, the links' masses."""

from collections.abc import Iterable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
import numpy as np

from .calibration_terms import PER_JOINT, per_joint, term_name, unit_name
from .drawing import FAINT, Picture, place, sheet, styled, svg, zero_line
from .gain_figures import AFTER, BEFORE
from ..calibration.calibration_results import Calibration
from ..calibration.term import Fitted
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.joints import JOINTS, N_JOINTS, S1
from ..model.presliding import Presliding

_FASTEST = 1.0  # of the friction's axis [rad/s]
# A joint swings to and fro over so much, slowly [rad, rad/s].
_SWING, _SWING_SPEED = 0.1, 0.2
_SMALLEST = 1e-3  # half of the least height of a panel [N m]


def parameters_picture(name: str, calibration: Calibration) -> 'Picture | None':
    """Draw what was fitted to the joints, a panel a term; None where nothing was."""
    terms = [term for term in PER_JOINT if per_joint(calibration, term)]
    if not terms:
        return None
    panel, gap, bottom, top = 0.92, 0.46, 0.28, 0.56  # [in]
    height = top + len(terms) * panel + (len(terms) - 1) * gap + bottom
    with styled():
        figure = sheet('', height)
        for i, term in enumerate(terms):
            fitted = per_joint(calibration, term)
            axis = figure.add_axes(place(
                figure, 0.62, height - top - panel - i * (panel + gap), panel))
            values = getattr(calibration.after.effort_model, term)
            _dots(axis, fitted, {k: value for k, value in enumerate(values) if k not in fitted})
            unit = unit_name(next(iter(fitted.values())).unit)
            axis.set_title(f'{term_name(term)} [{unit}]', loc='left', pad=4)
            axis.set_xticks(range(N_JOINTS), JOINTS)
            axis.set_xlim(-0.5, N_JOINTS - 0.5)
        _legend(figure, figure.axes, 3)
        return Picture(name, 'Parameters of each joint with their uncertainties: '
                       + ', '.join(map(term_name, terms)), svg(figure))


def masses_picture(name: str, calibration: Calibration) -> 'Picture | None':
    """Draw the links' masses before and after; None where they were not fitted."""
    fitted = {one.joint + 1: one for one in calibration.of_term('inertial')
              if one.component == 'mass' and one.joint is not None}
    if not fitted:
        return None
    with styled():
        figure = sheet('', 2.7)
        axis = figure.add_axes(place(figure, 0.5, 0.28, 1.86))
        _dots(axis, fitted, {})
        axis.set_title('mass [kg]', loc='left', pad=4)
        axis.set_xticks(list(fitted), [f'link {link}' for link in fitted])
        axis.set_ylim(bottom=0.0)
        _legend(figure, [axis], 3)
        return Picture(name, "The links' masses before and after, with their uncertainties",
                       svg(figure))


def spring_picture(name: str, calibration: Calibration) -> 'Picture | None':
    """Draw the spring at s1 with the bias there, and what changed; None where there is none."""
    before = calibration.before.model.effort_model
    after = calibration.after.model.effort_model
    if not (before.has_spring or after.has_spring):
        return None
    lower, upper = after.spring_range.tolist()
    low, high = np.clip(calibration.s1_range, lower, upper)
    angle = np.linspace(lower, upper, 241)
    old, new = (spring_effort(model, angle) for model in (before, after))
    seen = (angle >= low) & (angle <= high)
    with styled():
        figure = sheet('', 3.5)
        main = figure.add_axes(place(figure, 0.62, 1.5, 1.56))
        rest = figure.add_axes(place(figure, 0.62, 0.44, 0.8))
        main.plot(angle, old, color=BEFORE, linewidth=2.6, label='before')
        for axis, values in ((main, new), (rest, new - old)):
            axis.plot(angle, values, color=AFTER, alpha=0.35, linewidth=1.2)
            axis.plot(angle[seen], values[seen], color=AFTER, linewidth=1.8, label='after')
        for axis in (main, rest):
            axis.axvspan(low, high, color='#e6eef6', linewidth=0.0, zorder=0,
                         label='where s1 was')
            axis.set_xlim(lower, upper)
            axis.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        zero_line(rest)
        _least_height(rest)
        main.tick_params(labelbottom=False)
        main.set_title('spring and bias at s1 [N m]', loc='left', pad=4)
        rest.set_title('after − before [N m]', loc='left', pad=4)
        rest.set_xlabel('angle of s1 [rad]', labelpad=2)
        _legend(figure, [main], 3)
        return Picture(name, f'Spring and bias at s1 over its angle, before and after; s1 was '
                       f'between {low:.2f} and {high:.2f} rad', svg(figure))


def friction_picture(name: str, calibration: Calibration, joint: int) -> Picture:
    """Draw one joint's friction: over the velocity, and while it turns round and back."""
    models = {'before': calibration.before.model.effort_model,
              'after': calibration.after.model.effort_model}
    with styled():
        figure = sheet(JOINTS[joint], 2.1)
        steady = figure.add_axes(place(figure, 0.62, 0.44, 1.3, right=2.32))
        turning = figure.add_axes(place(figure, 2.42, 0.44, 1.3))
        for label, model in models.items():
            if not has_friction(model, joint) and label == 'before':
                continue
            color, width = (BEFORE, 2.6) if label == 'before' else (AFTER, 1.6)
            qd = np.linspace(-_FASTEST, _FASTEST, 161)
            steady.plot(qd, model.friction(np.repeat(qd[:, None], N_JOINTS, 1))[:, joint],
                        color=color, linewidth=width, label=label)
            turning.plot(*friction_loop(model, joint), color=color, linewidth=width)
        reach = max(np.abs(line.get_ydata()).max() for axis in figure.axes for line in axis.lines)
        for axis in (steady, turning):
            zero_line(axis)
            axis.set_ylim(*(1.1 * max(reach, _SMALLEST) * np.array([-1.0, 1.0])))
            axis.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        steady.set_xticks([-_FASTEST, 0.0, _FASTEST])
        turning.set_xticks([-_SWING, 0.0, _SWING])
        turning.tick_params(labelleft=False)
        steady.set_ylabel('friction [N m]')
        steady.yaxis.set_label_coords(-0.48 / 1.66, 0.5)
        steady.set_xlabel('velocity [rad/s]', labelpad=2)
        turning.set_xlabel('angle [rad], to and fro', labelpad=2)
        if has_friction(models['before'], joint):
            _legend(figure, [steady], 2)
        return Picture(name, f'Friction of {JOINTS[joint]}, up to {reach:.3f} N m: over the '
                       'velocity, and over the angle while the joint turns round and back',
                       svg(figure))


def has_friction(model: EffortModel, joint: int) -> bool:
    """Return whether a joint has friction of any kind."""
    return bool(model.coulomb[joint] or model.viscous[joint] or model.dahl[joint])


def spring_effort(model: EffortModel, angle: Array) -> Array:
    """Return spring and bias at s1 (n,) [N m] over its angle (n,) [rad]."""
    q = np.zeros((len(angle), N_JOINTS))
    q[:, S1] = angle
    return model.spring(q)[:, S1] + model.bias[S1]


def _dots(axis: Axes, fitted: dict[int, Fitted], others: dict[int, float]) -> None:
    """Draw values with their uncertainties, by place; of others, which were kept, the value."""
    if others:
        axis.plot(list(others), list(others.values()), 'x', color=FAINT, markersize=5.0,
                  label='not fitted')
    axis.plot(list(fitted), [one.before for one in fitted.values()], 'o', color='white',
              markeredgecolor=BEFORE, markeredgewidth=1.6, markersize=7.5, label='before')
    axis.errorbar(list(fitted), [one.value for one in fitted.values()],
                  yerr=[one.deviation for one in fitted.values()], fmt='o', color=AFTER,
                  markersize=5.0, elinewidth=1.4, capsize=3.5, label='after, ± uncertainty')
    zero_line(axis)
    axis.grid(axis='x', visible=False)
    axis.margins(y=0.12)
    axis.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))


def friction_loop(model: EffortModel, joint: int) -> tuple[Array, Array]:
    """Return angle [rad] and friction [N m] of a joint that swings to and fro, settled."""
    phase = np.linspace(0.0, 4 * np.pi, 401)
    q = _SWING * np.repeat(np.sin(phase)[:, None], N_JOINTS, 1)
    qd = _SWING_SPEED * np.repeat(np.cos(phase)[:, None], N_JOINTS, 1)
    state = Presliding(model.dahl_length)
    friction = model.friction(qd, np.array([state.update(row) for row in q]))
    return q[200:, joint], friction[200:, joint]


def _least_height(axis: Axes) -> None:
    low, high = axis.get_ylim()
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), 10 * _SMALLEST)
    axis.set_ylim(middle - half, middle + half)


def _legend(figure: Figure, axes: Iterable[Axes], columns: int) -> None:
    """Put one legend above all, of what any of the panels has."""
    handles: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc='upper right', ncols=columns,
                  frameon=False, handlelength=1.3, columnspacing=1.4, borderaxespad=0.15)
