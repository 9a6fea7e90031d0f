"""One part of the page as a separate figure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from nrp_core.errors import ExperimentError
from nrp_core.recording.figures.film import camera_images, moments
from nrp_core.recording.figures.matrix import draw_values, height_of
from nrp_core.recording.figures.options import PlotOptions
from nrp_core.recording.figures.room import draw_room
from nrp_core.recording.figures.story import Story
from nrp_core.recording.figures.traces import draw_raster, moving, shade, value_rows
from nrp_core.recording.figures.view import RoomView
from nrp_core.recording.reading.recording import Recording

_WIDE = (12.0, 5.0)
_ROOM, _ROOM_EDGE = 8.0, 0.8
"""Length of the room's longer side, and the space for title and axes."""
_IMAGES, _COLUMNS = 12, 4


def draw_part(what: str, story: Story, recording: Recording, options: PlotOptions) -> Figure:
    """Return a figure of one part.

    Args:
        what: ``raster``, ``trajectory``, ``devices`` or ``camera``.
        story: the story of the run.
        recording: the recording with the images.
        options: the size of the figure.

    Raises:
        ExperimentError: the recording has no data for it.
    """
    draw: dict[str, Callable[[], Figure | None]] = {
        "raster": lambda: _raster(story, options),
        "trajectory": lambda: _trajectory(story, options),
        "devices": lambda: _devices(story, options),
        "camera": lambda: _camera(story, recording, options),
    }
    figure = draw[what]()
    if figure is None:
        raise ExperimentError(f"the recording has no data for '{what}'", path=recording.file)
    return figure


def _raster(story: Story, options: PlotOptions) -> Figure | None:
    if not any(len(ids) for parts in story.spikes.values() for ids, _ in parts):
        return None
    figure = options.figure(_WIDE, layout="constrained")
    axes = figure.add_subplot(title="Spikes", xlabel="simulated time (s)", xlim=story.span_s)
    draw_raster(axes, story)
    shade(axes, story.coloured())
    return figure


def _trajectory(story: Story, options: PlotOptions) -> Figure | None:
    if not story.tracks:
        return None
    view, coloured = RoomView.of(story), story.coloured()
    sides = np.array([min(view.focus(coloured).aspect, 1.0), min(1 / view.focus(coloured).aspect, 1.0)])
    width, height = _ROOM * np.maximum(sides, 0.3) + _ROOM_EDGE
    figure = options.figure((float(width), float(height)), layout="constrained")
    draw_room(figure.add_subplot(title="Room from above"), view, coloured)
    return figure


def _devices(story: Story, options: PlotOptions) -> Figure | None:
    rows = [*value_rows("devices", story.sinks), *value_rows("commands", moving(story.commands))]
    if not rows:
        return None
    heights = [height_of(series, 1.6) for _, series in rows]
    figure = options.figure((_WIDE[0], 1.0 + sum(heights)), layout="constrained")
    stack = np.atleast_1d(figure.subplots(len(rows), sharex=True, height_ratios=heights))
    for axes, (title, series) in zip(stack, rows, strict=True):
        axes.set_title(title)
        draw_values(axes, series, story)
        shade(axes, story.coloured())
    stack[-1].set(xlim=story.span_s, xlabel="simulated time (s)")
    return figure


def _camera(story: Story, recording: Recording, options: PlotOptions) -> Figure | None:
    taken = camera_images(recording, moments(story, _IMAGES))
    if not taken:
        return None
    rows = -(-len(taken) // _COLUMNS)
    height, width = taken[0].pixels.shape[:2]
    size = (_WIDE[0], 0.3 + rows * (0.3 + _WIDE[0] / _COLUMNS * height / width))
    figure = options.figure(size, layout="constrained")
    for number, image in enumerate(taken, 1):
        axes = figure.add_subplot(rows, _COLUMNS, number, title=f"{image.t_s:.2f} s", xticks=[], yticks=[])
        axes.imshow(image.pixels)
    return figure
