"""Values over time: few as curves, many as rows of colours."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import StepSeries, Story
from nrp_core.recording.figures.style import points
from nrp_core.recording.figures.traces import draw_series, short_labels

_MOST_CURVES = 4
"""Maximum number of curves that can be distinguished and labelled."""
_ROW = 0.13
_COLUMNS = 1200
_MOST_LABELS = 24
"""Maximum number of rows with a label each."""
_LONGEST_LABEL, _LARGEST_PT, _LEAST_PT, _LINE_PT = 28, 7.0, 4.5, 140.0
"""The longest label, the sizes of labels, and the characters that fit in a line times their size."""
_LINE = 1.15
"""Height of a line in units of the size of its text."""


def height_of(series: Sequence[StepSeries], least: float) -> float:
    """Return the height of the axes of some values, in units of the smallest height."""
    return least if len(series) <= _MOST_CURVES else max(least, _ROW * min(len(series), _MOST_LABELS))


def draw_values(axes: Axes, series: Sequence[StepSeries], story: Story) -> None:
    """Draw values as steps."""
    draw = draw_series if len(series) <= _MOST_CURVES else draw_matrix
    draw(axes, series, story)


def draw_matrix(axes: Axes, series: Sequence[StepSeries], story: Story) -> None:
    """Draw a row for each series; all share the scale beside them."""
    values = np.array([sampled(one, *story.span_s) for one in series])
    shown = values[np.isfinite(values)]
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 0.0)
    image = axes.imshow(
        values, cmap="cividis", aspect="auto", interpolation="nearest",
        extent=(*story.span_s, len(series), 0.0), vmin=low, vmax=high if high > low else low + 1.0,
    )  # fmt: skip
    row_pt = axes.bbox.height * 72 / axes.figure.dpi / len(series)
    every = max(-(-len(series) // _MOST_LABELS), ceil(_LINE * _LEAST_PT / row_pt))
    rows = np.arange(0, len(series), every)
    labels = short_labels(series, _LONGEST_LABEL)[::every]
    longest = max((len(label) for label in labels), default=1)
    size = np.clip(min(every * row_pt / _LINE, _LINE_PT / longest), _LEAST_PT, _LARGEST_PT)
    axes.set_yticks(rows + 0.5, labels, fontsize=float(size))
    axes.tick_params(axis="y", length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    point = axes.figure.dpi / 72 / axes.bbox.width
    scale = axes.figure.colorbar(image, cax=axes.inset_axes((1 + 4 * point, 0.0, 5 * point, 1.0)))
    scale.set_label(series[0].unit, labelpad=1, fontsize=points(7))
    scale.outline.set_visible(False)
    scale.ax.tick_params(length=2, pad=1, labelsize=points(6.5))


def sampled(one: StepSeries, begin_s: float, end_s: float) -> FloatArray:
    """Return the value at equal steps of time; NaN before the first."""
    times = np.linspace(begin_s, end_s, _COLUMNS, endpoint=False)
    index = np.searchsorted(one.times_s, times, side="right") - 1
    return np.where(index >= 0, np.asarray(one.values, float)[np.maximum(index, 0)], np.nan)
