"""Pictures of effort and residual."""

from pathlib import Path

from matplotlib.figure import Figure
import matplotlib.style
import numpy as np

from ..model.arrays import Array
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS

_MEASURED, _PREDICTED, _RESIDUAL, _DIFFERENCE = '#9aa5b1', '#0b6e99', '#b3401f', '#e4d3c8'


def plot_effort(path: Path, series: dict[str, Array], title: str) -> None:
    """
    Save a picture of measured and predicted effort and of the residual, a row a joint.

    Parameters
    ----------
    path : Path
        Where to; the ending says which kind.
    series : dict
        time (n,) [s]; measured, predicted, residual (n, 7) [N m]; first_difference_time (m,) and
        first_difference_residual (m, 7).
    title : str
        Above the picture.

    Raises
    ------
    BaxterDynamicsError
        If the file cannot be written.

    """
    try:
        with matplotlib.style.context('default'):  # whatever the user's settings are
            _draw(series, title).savefig(path, dpi=85)
    except OSError as error:
        raise BaxterDynamicsError(f'{path}: cannot be written ({error})') from None


def _draw(series: dict[str, Array], title: str) -> Figure:
    figure = Figure(figsize=(12, 10), layout='constrained')
    axes = figure.subplots(len(JOINTS), 2, sharex=True)
    figure.suptitle(title, fontsize=14)
    for i, (joint, (left, right)) in enumerate(zip(JOINTS, axes)):
        left.plot(series['time'], series['measured'][:, i], color=_MEASURED, lw=2.2,
                  label='measured')
        left.plot(series['time'], series['predicted'][:, i], color=_PREDICTED, lw=1.2,
                  label='predicted')
        left.set_ylabel(f'{joint}   [N m]')
        right.plot(series['first_difference_time'], series['first_difference_residual'][:, i],
                   color=_DIFFERENCE, lw=0.8, label="with the paper's first difference (cut off)")
        right.plot(series['time'], series['residual'][:, i], color=_RESIDUAL, lw=1.2,
                   label='residual')
        right.axhline(0.0, color='black', lw=0.6)
        limit = 2.5 * np.abs(series['residual'][:, i]).max()
        right.set_ylim(-limit, limit)  # to show the residual; the first difference goes beyond
        rms = np.sqrt(np.mean(series['residual'][:, i] ** 2))
        right.annotate(f'RMS {rms:.3f} N m', (0.01, 0.86), xycoords='axes fraction', fontsize=9,
                       color=_RESIDUAL)
        for axis in (left, right):
            axis.grid(alpha=0.25)
            axis.margins(x=0)
    axes[0, 0].set_title('effort', pad=22)
    axes[0, 1].set_title('measured - predicted', pad=22)
    for axis in axes[0]:
        axis.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize=9,
                    frameon=False, borderaxespad=0.2)
    for axis in axes[-1]:
        axis.set_xlabel('time [s]')
    return figure
