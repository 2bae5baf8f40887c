"""Figure of the demo."""

import io
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np

from ..files import write_file
from ..model.arrays import Array
from ..model.joints import JOINTS
from ..report.drawing import frame, styled, zero_line

_COLORS = {'measured': '#9aa5b1', 'predicted': '#0b6e99', 'residual': '#b3401f',
           'first difference': '#e4d3c8'}


def plot_effort(path: Path, signals: dict[str, tuple[Array, Array]], title: str) -> None:
    """
    Save a figure of measured and predicted effort and of the residual, one row per joint.

    Parameters
    ----------
    path : Path
        File ending in .png, .pdf or .svg.
    signals : dict
        For measured, predicted, residual and first difference: time (n,) [s] and values (n, 7)
        [N m].
    title : str
        Title.

    Raises
    ------
    BaxterDynamicsError
        If the file cannot be written.

    """
    with styled():
        figure = Figure(figsize=(12, 10), layout='constrained')
        figure.suptitle(title)
        axes = figure.subplots(len(JOINTS), 2, sharex=True)
        for i, (joint, row) in enumerate(zip(JOINTS, axes)):
            for axis, names in zip(row, (('measured', 'predicted'),
                                         ('first difference', 'residual'))):
                for name, width in zip(names, (2.0, 1.2)):
                    time, values = signals[name]
                    axis.plot(time, values[:, i], color=_COLORS[name], lw=width, label=name)
            residual = signals['residual'][1][:, i]
            limit = 2.5 * float(np.abs(residual).max())  # cuts off the first difference
            zero_line(row[1])
            frame(row[0], f'{joint} [N m]')
            frame(row[1], f'RMS {np.sqrt(np.mean(residual ** 2)):.3f}', (-limit, limit))
        for axis, name in zip(axes[0], ('effort', 'measured - predicted')):
            axis.set_title(name, loc='left')
            axis.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        for axis in axes[-1]:
            axis.set_xlabel('time [s]')
        buffer = io.BytesIO()
        figure.savefig(buffer, format=path.suffix[1:], dpi=85)
    write_file(path, buffer.getvalue())
