"""One part of the story on a page of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from nrp_core.errors import ExperimentError
from nrp_core.recording.figures.matrix import draw_values, height_of
from nrp_core.recording.figures.page import DPI
from nrp_core.recording.figures.room import draw_room
from nrp_core.recording.figures.story import Story, moments, pictures
from nrp_core.recording.figures.traces import by_unit, draw_raster, moving, shade
from nrp_core.recording.reading.recording import Recording

_WIDE = (12.0, 5.0)
_ROOM, _ROOM_EDGE = 8.0, 0.8
"""Longer side of the room, and what title and axes take beside it."""
_PICTURES, _COLUMNS = 12, 4


def draw_part(what: str, story: Story, recording: Recording) -> Figure:
    """Return a figure of one part.

    Args:
        what: ``raster``, ``trajectory``, ``devices`` or ``camera``.
        story: of the run.
        recording: of the same, for the pictures.

    Raises:
        ExperimentError: the recording has nothing of it.
    """
    draw: dict[str, Callable[[], Figure | None]] = {
        "raster": lambda: _raster(story),
        "trajectory": lambda: _trajectory(story),
        "devices": lambda: _devices(story),
        "camera": lambda: _camera(story, recording),
    }
    figure = draw[what]()
    if figure is None:
        raise ExperimentError(f"there is nothing to draw for '{what}' in it", path=recording.file)
    return figure


def _raster(story: Story) -> Figure | None:
    if not any(len(ids) for parts in story.spikes.values() for ids, _ in parts):
        return None
    figure = Figure(figsize=_WIDE, dpi=DPI, layout="constrained")
    axes = figure.add_subplot(title="Spikes", xlabel="simulated time (s)", xlim=(0, story.end_s or 1.0))
    draw_raster(axes, story)
    shade(axes, story.coloured())
    return figure


def _trajectory(story: Story) -> Figure | None:
    if not story.tracks:
        return None
    figure = Figure(figsize=(_ROOM, _ROOM), dpi=DPI, layout="constrained")
    axes = figure.add_subplot(title="Room from above")
    draw_room(axes, story, story.coloured())
    sides = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    figure.set_size_inches(_ROOM * np.maximum(sides / sides.max(), 0.3) + _ROOM_EDGE)
    return figure


def _devices(story: Story) -> Figure | None:
    kinds = (("Devices", story.sinks), ("Commands", moving(story.commands)))
    rows = [
        (f"{kind} ({unit})" if series[0].unit else unit, series)
        for kind, all_series in kinds
        for unit, series in by_unit(all_series).items()
    ]
    if not rows:
        return None
    heights = [height_of(series, 1.6) for _, series in rows]
    figure = Figure(figsize=(_WIDE[0], 1.0 + sum(heights)), dpi=DPI, layout="constrained")
    stack = np.atleast_1d(figure.subplots(len(rows), sharex=True, height_ratios=heights))
    for axes, (title, series) in zip(stack, rows, strict=True):
        axes.set_title(title)
        draw_values(axes, series, story.end_s)
        shade(axes, story.coloured())
    stack[-1].set(xlim=(0, story.end_s or 1.0), xlabel="simulated time (s)")
    return figure


def _camera(story: Story, recording: Recording) -> Figure | None:
    taken = pictures(recording, moments(story, _PICTURES))
    if not taken:
        return None
    rows = -(-len(taken) // _COLUMNS)
    height, width = taken[0].pixels.shape[:2]
    size = (_WIDE[0], 0.3 + rows * (0.3 + _WIDE[0] / _COLUMNS * height / width))
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    for number, picture in enumerate(taken, 1):
        axes = figure.add_subplot(rows, _COLUMNS, number, title=f"{picture.t_s:.2f} s", xticks=[], yticks=[])
        axes.imshow(picture.pixels)
    return figure
