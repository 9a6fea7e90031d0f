"""The layout of the page: the place of each part of the figure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import inf
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpecFromSubplotSpec
from matplotlib.offsetbox import AnchoredOffsetbox, HPacker, TextArea, VPacker
from matplotlib.ticker import MaxNLocator

from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.result import Judgement, recorded_judgement
from nrp_core.recording.figures.film import CameraFrame, camera_images, image_times
from nrp_core.recording.figures.room import Bounds, RoomView, draw_room
from nrp_core.recording.figures.story import Coloured, Story
from nrp_core.recording.figures.style import (
    BAD,
    FAINT,
    GOOD,
    Panel,
    PlotOptions,
    points,
    text_scale,
    time_colours,
)
from nrp_core.recording.figures.traces import (
    draw_raster,
    draw_timeline,
    draw_values,
    height_of,
    moving,
    shade,
    value_rows,
)
from nrp_core.recording.reading.reader import RecordingReader

HEAD_TOP_IN = 0.28
_CHARACTERS_AN_IN = 15
_A_LINE_IN = 3.1
"""Width of the page for each criterion in a line."""


def draw_head(figure: Figure, story: Story, side: float) -> None:
    """Write the head; a share of the width stays free on both sides."""
    run = story.run
    name = str(run.get("experiment", "recording"))
    top = 1 - HEAD_TOP_IN / figure.get_figheight()
    figure.text(side, top, name, fontsize=points(15), weight="bold", va="top")
    sides = [str(dict(run.get(side) or {}).get("backend", "")) for side in ("brain", "world")]
    shown = f"{story.begin_s:g} to {story.end_s:g} s" if story.begin_s else f"{story.end_s:g} s"
    facts = [" \N{MULTIPLICATION SIGN} ".join(filter(None, sides)), shown]
    if "seed" in run:
        facts.append(f"seed {run['seed']}")
    below = top - points(24) / 72 / figure.get_figheight()
    text = "   ·   ".join(filter(None, facts))
    figure.text(side, below, text, color=FAINT, fontsize=points(9.5), va="top")
    judgement = recorded_judgement(run, story.end_s)
    if judgement is not None:
        _draw_problems(figure, (side, below - points(15) / 72 / figure.get_figheight()), judgement)
    _draw_verdict(figure, (1 - side, top), dict((run.get("result") or {}).get("criteria") or {}))


def _draw_problems(figure: Figure, corner: tuple[float, float], judgement: Judgement) -> None:
    """Write the judgement of a run that is not complete or ended early, and its weightiest problems."""
    groups = [group.headline for group in judgement.groups]
    if judgement.complete and judgement.covers_all:
        text, color = f"problems: {'; '.join(groups)}" if groups else "", FAINT
    else:
        text, color = "; ".join([judgement.headline, *groups]), FAINT if judgement.complete else BAD
    text = shorten(text, round(_CHARACTERS_AN_IN * figure.get_figwidth()), placeholder=" …")
    figure.text(*corner, text, color=color, fontsize=points(8.5), va="top")


def _draw_verdict(figure: Figure, corner: tuple[float, float], criteria: dict[str, Any]) -> None:
    """Write the criteria with their marks in the upper right corner, as many in a line as fit."""
    count = max(1, round(figure.get_figwidth() / _A_LINE_IN))
    words: list[Artist] = [_criterion(name, outcome) for name, outcome in criteria.items()]
    lines: list[Artist] = [
        HPacker(children=words[i : i + count], sep=14, pad=0) for i in range(0, len(words), count)
    ]
    if lines:
        box = VPacker(children=lines, align="right", sep=5, pad=0)
        figure.add_artist(
            AnchoredOffsetbox(
                "upper right", child=box, frameon=False, pad=0, borderpad=0,
                bbox_to_anchor=corner, bbox_transform=figure.transFigure,
            )
        )  # fmt: skip


def _criterion(name: str, outcome: Any) -> TextArea:
    marks = {True: ("✓", GOOD), False: ("✗", BAD), None: ("?", FAINT)}
    mark, color = marks[outcome["passed"]]
    return TextArea(f"{mark} {name}", textprops={"color": color, "fontsize": points(9.5), "weight": "bold"})


_FIGURE_SIZE = (12.0, 5.0)
_ROOM, _ROOM_EDGE = 8.0, 0.8
"""Length of the room's longer side, and the space for title and axes."""
_IMAGES, _COLUMNS = 12, 4


def draw_part(what: str, story: Story, recording: RecordingReader, options: PlotOptions) -> Figure:
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
    figure = options.figure(_FIGURE_SIZE, layout="constrained")
    axes = figure.add_subplot(title="Spikes", xlabel="simulated time (s)", xlim=story.span_s)
    figure.draw_without_rendering()  # lays it out: the height decides how many labels fit
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
    kinds = {"devices": story.sinks, "commands": moving(story.commands), "observables": story.observables}
    rows = [row for kind, series in kinds.items() for row in value_rows(kind, series)]
    if not rows:
        return None
    heights = [height_of(series, 1.6) for _, series in rows]
    figure = options.figure((_FIGURE_SIZE[0], 1.0 + sum(heights)), layout="constrained")
    stack = np.atleast_1d(figure.subplots(len(rows), sharex=True, height_ratios=heights))
    for axes, (title, _) in zip(stack, rows, strict=True):
        axes.set_title(title)
    stack[-1].set(xlim=story.span_s, xlabel="simulated time (s)")
    figure.draw_without_rendering()  # lays it out: the height decides how many labels fit
    for axes, (_, series) in zip(stack, rows, strict=True):
        draw_values(axes, series, story)
        shade(axes, story.coloured())
    stack[-1].set(xlim=story.span_s)
    return figure


def _camera(story: Story, recording: RecordingReader, options: PlotOptions) -> Figure | None:
    taken = camera_images(recording, image_times(story, _IMAGES))
    if not taken:
        return None
    rows = -(-len(taken) // _COLUMNS)
    height, width = taken[0].pixels.shape[:2]
    size = (_FIGURE_SIZE[0], 0.3 + rows * (0.3 + _FIGURE_SIZE[0] / _COLUMNS * height / width))
    figure = options.figure(size, layout="constrained")
    for number, image in enumerate(taken, 1):
        axes = figure.add_subplot(rows, _COLUMNS, number, title=f"{image.t_s:.2f} s", xticks=[], yticks=[])
        axes.imshow(image.pixels)
    return figure


SIZE_INCHES, _TALLER = (12.8, 8.0), (12.8, 10.4)
"""Height of the page, and of a page with a wide map at the top."""
IMAGES = 8
_SIDE_IN, _NAMES_IN = 0.58, 0.7
"""Margin on both sides, and space for the names of rows beside the traces, at the usual text size."""
_HEAD_IN, _FOOT_IN, _STRIP_GAP_IN, _CAPTION_IN = 0.9, 0.2, 0.08, 0.25
_AXIS_IN, _ROW_GAP_IN, _MAP_GAP_IN = 0.6, 0.3, 0.68
"""Height of the lines of the head, and of the foot; gap and caption of the camera images; labels of the time
axis; space for the title of a row, and for the labels of a wide map and the next title."""
_BORDER_IN, _BESIDE_IN = 0.08, 0.12
"""Least distance of labels from the border of the page, and from the map."""
_WIDE_ASPECT = 1.9
"""A map with a larger aspect ratio is above the traces, over the whole width."""


def draw_page(story: Story, images: Sequence[CameraFrame], options: PlotOptions) -> Figure:
    """Return the figure; parts without data are omitted, and the others use their space."""
    coloured, view = story.coloured(), RoomView.of(story)
    rows = _rows(story, coloured, options.panels)
    is_mapped = Panel.MAP in options.panels and (view.moves or bool(view.fixed and not rows))
    focus = view.focus(coloured) if is_mapped else None
    is_above = focus is not None and focus.aspect > _WIDE_ASPECT and bool(rows)
    figure = options.figure(_TALLER if is_above else SIZE_INCHES)
    side = _SIDE_IN * _scale(figure) / figure.get_figwidth()
    draw_head(figure, story, side)
    strip_in = _draw_images(figure, images, story, side)
    place, traces = _places(figure, focus, bool(rows), strip_in)
    free_in = _BORDER_IN
    if place is not None:
        axes = figure.add_subplot(place, title="Room from above")
        draw_room(axes, view, coloured)
        _clear(figure, [axes], _BORDER_IN)
        if not is_above:
            axes.apply_aspect()
            free_in = axes.get_position().x1 * figure.get_figwidth() + _BESIDE_IN
    if traces is not None:
        stack = _draw_traces(figure, traces, story, coloured, rows, [image.t_s for image in images])
        _clear(figure, stack, free_in)
    return figure


def _clear(figure: Figure, stack: Sequence[Axes], free_in: float) -> None:
    """Make axes narrower whose labels begin before a place, in inches, or leave the page on the right."""
    wide_in = figure.get_figwidth()
    labels = [axes.yaxis.get_tightbbox() for axes in stack]
    beside = [child.get_tightbbox() for axes in stack for child in axes.child_axes]
    begin_in = min((float(box.x0) for box in labels if box is not None), default=inf) / figure.dpi
    end_in = max((float(box.x1) for box in beside if box is not None), default=0.0) / figure.dpi
    left, right = max(0.0, free_in - begin_in) / wide_in, max(0.0, end_in - wide_in + _BORDER_IN) / wide_in
    for axes in stack:
        place = axes.get_position(original=True)
        axes.set_position((place.x0 + left, place.y0, place.width - left - right, place.height))


def _places(figure: Figure, focus: Bounds | None, has_rows: bool, strip_in: float) -> tuple[Any, Any]:
    """Return the places of map and traces, side by side, or a wide map above; None for a missing part."""
    scale, (wide_in, high_in) = _scale(figure), figure.get_size_inches()
    bottom, top = (
        (_FOOT_IN + strip_in + _AXIS_IN * scale) / high_in,
        1 - (HEAD_TOP_IN + _HEAD_IN * scale) / high_in,
    )
    left, names = _SIDE_IN * scale / wide_in, _NAMES_IN * scale / wide_in
    right = 1 - left
    if focus is None or not has_rows:
        left += names if has_rows else 0.0
        whole = figure.add_gridspec(1, 1, left=left, right=right, bottom=bottom, top=top)[0, 0]
        return (None, whole) if has_rows else (whole if focus else None, None)
    width, height = (right - left) * wide_in, (top - bottom) * high_in
    if focus.aspect > _WIDE_ASPECT:
        share, gap_in = min(width / focus.aspect / height, 0.36), _MAP_GAP_IN * scale
        grid = figure.add_gridspec(
            2, 1, left=left + names, right=right, bottom=bottom, top=top,
            height_ratios=(share, 1 - share), hspace=2 * gap_in / (height - gap_in),
        )  # fmt: skip
        return grid[0, 0], grid[1, 0]
    share = float(np.clip(height * focus.aspect / width, 0.24, 0.42))
    grid = figure.add_gridspec(
        1, 2, left=left, right=right, bottom=bottom, top=top, width_ratios=(share, 1 - share), wspace=0.2
    )
    return grid[0, 0], grid[0, 1]


Row = tuple[float, str, Callable[[Axes], None]]
"""The relative height of axes, their title, and the function that draws them."""


def _rows(story: Story, coloured: Sequence[Coloured], panels: Collection[Panel]) -> list[Row]:
    """Return all rows with a time axis."""
    rows: list[Row] = []
    if coloured and Panel.TIMELINE in panels:
        visuals = len({interval.visual for interval in coloured})
        rows.append((0.2 * visuals, "", lambda axes: draw_timeline(axes, story, coloured)))
    if story.spikes and Panel.SPIKES in panels:
        rows.append((1.7, "Spikes", lambda axes: draw_raster(axes, story)))
    kinds = (
        (Panel.VOLTAGES, story.voltages), (Panel.DEVICES, story.sinks),
        (Panel.COMMANDS, moving(story.commands)), (Panel.OBSERVABLES, story.observables),
    )  # fmt: skip
    values = [row for panel, series in kinds if panel in panels for row in value_rows(panel, series)]
    for title, series in values[:6]:
        height = height_of(series, 0.8)
        rows.append((height, title, lambda axes, s=series: draw_values(axes, s, story)))  # type: ignore[misc]
    return rows


def _draw_traces(
    figure: Figure, place: Any, story: Story, coloured: Sequence[Coloured], rows: Sequence[Row],
    images_s: Sequence[float],
) -> list[Axes]:  # fmt: skip
    """Stack the rows on one time axis, and return their axes and those of the time."""
    count, gap_in = len(rows) + 1, _ROW_GAP_IN * _scale(figure)
    high_in = place.get_position(figure).height * figure.get_figheight()
    hspace = gap_in / max((high_in - gap_in * (count - 1)) / count, 0.05)
    heights = [*(height for height, _, _ in rows), 0.05]
    grid = GridSpecFromSubplotSpec(count, 1, place, height_ratios=heights, hspace=hspace)
    stack: list[Axes] = []
    for number, (_, title, draw) in enumerate(rows):
        axes = figure.add_subplot(grid[number], sharex=stack[0] if stack else None)
        axes.set_title(title)
        draw(axes)
        if title:
            shade(axes, coloured)
        axes.tick_params(labelbottom=False)
        stack.append(axes)
    clock = figure.add_subplot(grid[-1], sharex=stack[0])
    _draw_clock(clock, story, images_s)
    stack[0].set_xlim(*story.span_s)
    return [*stack, clock]


def _draw_clock(axes: Axes, story: Story, images_s: Sequence[float]) -> None:
    """Draw the time axis in the colours of the track, with a mark for each image."""
    span = story.span_s
    axes.imshow(np.linspace(0, 1, 256)[np.newaxis], cmap=time_colours(), aspect="auto", extent=(*span, 0, 1))
    axes.plot(images_s, [1.9] * len(images_s), "v", color=FAINT, markersize=4, clip_on=False)
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xticks(MaxNLocator(10, steps=[1, 2, 5, 10]).tick_values(*span))
    axes.set(xlim=span, ylim=(0, 1), xlabel="simulated time (s)")


def _draw_images(figure: Figure, images: Sequence[CameraFrame], story: Story, side: float) -> float:
    """Line up the camera images, each framed in the colour of its time; return the height taken, inches."""
    if not images:
        return 0.0
    width_in, height_in = (float(side) for side in figure.get_size_inches())
    gap = _STRIP_GAP_IN / width_in
    width = (1 - 2 * side + gap) / max(len(images), IMAGES)
    rows, columns = images[0].pixels.shape[:2]
    strip_in = (width - gap) * width_in * rows / columns
    for number, image in enumerate(images):
        place = (side + number * width, _FOOT_IN / height_in, width - gap, strip_in / height_in)
        axes = figure.add_axes(place, anchor="SW", xticks=[], yticks=[])
        axes.imshow(image.pixels)
        for spine in axes.spines.values():
            spine.set(visible=True, linewidth=2, color=time_colours()(story.share_of(image.t_s)))
        axes.set_title(f"{image.t_s:.1f} s", fontsize=points(8), weight="normal", pad=4)
    return float(strip_in + _CAPTION_IN)


def _scale(figure: Figure) -> float:
    """Return the size of texts on a page of this width."""
    return text_scale(figure.get_figwidth())
