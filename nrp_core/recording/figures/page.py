"""The page: where each part of the figure goes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpecFromSubplotSpec
from matplotlib.offsetbox import AnchoredOffsetbox, HPacker, TextArea, VPacker
from matplotlib.ticker import MaxNLocator

from nrp_core.recording.figures.matrix import draw_values, height_of
from nrp_core.recording.figures.room import draw_room
from nrp_core.recording.figures.story import CameraFrame, Coloured, Story
from nrp_core.recording.figures.style import BAD, FAINT, GOOD, time_colours
from nrp_core.recording.figures.traces import (
    by_unit,
    draw_raster,
    draw_timeline,
    moving,
    shade,
)

SIZE_INCHES = (12.8, 8.0)
DPI = 150
PICTURES = 8
_LEFT, _RIGHT = 0.045, 0.985
_NAMES = 0.055
"""Room for the names of rows beside the traces."""


def draw_page(story: Story, pictures: Sequence[CameraFrame]) -> Figure:
    """Return the figure; what a run does not have is left out, and the rest takes its place."""
    figure = Figure(figsize=SIZE_INCHES, dpi=DPI)
    _draw_head(figure, story)
    bottom = 0.262 if pictures else 0.075
    has_room = bool(story.markers or story.tracks)
    grid = figure.add_gridspec(
        1, 2 if has_room else 1, left=_LEFT if has_room else _LEFT + _NAMES, right=_RIGHT, bottom=bottom,
        top=0.865, width_ratios=(1.0, 1.3) if has_room else (1.0,), wspace=0.22,
    )  # fmt: skip
    coloured = story.coloured()
    if has_room:
        axes = figure.add_subplot(grid[0, 0], anchor="NW")
        axes.set_title("Room from above")
        draw_room(axes, story, coloured)
    _draw_traces(figure, grid[0, -1], story, coloured, [picture.t_s for picture in pictures])
    _draw_pictures(figure, pictures, story.end_s)
    return figure


def _draw_head(figure: Figure, story: Story) -> None:
    run = story.run
    name = str(run.get("experiment", "recording"))
    figure.text(_LEFT, 0.955, name, fontsize=15, weight="bold", va="center")
    sides = [str(dict(run.get(side) or {}).get("backend", "")) for side in ("brain", "world")]
    facts = [" \N{MULTIPLICATION SIGN} ".join(filter(None, sides)), f"{story.end_s:g} s"]
    if "seed" in run:
        facts.append(f"seed {run['seed']}")
    if run.get("state") not in ("finished", None):
        facts.append(str(run["state"]))
    figure.text(_LEFT, 0.919, "   ·   ".join(filter(None, facts)), color=FAINT, fontsize=9.5, va="center")
    _draw_verdict(figure, dict((run.get("result") or {}).get("criteria") or {}))


def _draw_verdict(figure: Figure, criteria: dict[str, Any]) -> None:
    """Write the criteria with their marks in the upper right corner, four to a line."""
    words: list[Artist] = [_criterion(name, outcome) for name, outcome in criteria.items()]
    lines: list[Artist] = [HPacker(children=words[i : i + 4], sep=14, pad=0) for i in range(0, len(words), 4)]
    if lines:
        box = VPacker(children=lines, align="right", sep=5, pad=0)
        corner = (_RIGHT, 0.965)
        figure.add_artist(
            AnchoredOffsetbox(
                "upper right", child=box, frameon=False, pad=0, borderpad=0,
                bbox_to_anchor=corner, bbox_transform=figure.transFigure,
            )
        )  # fmt: skip


def _criterion(name: str, outcome: Any) -> TextArea:
    marks = {True: ("✓", GOOD), False: ("✗", BAD), None: ("?", FAINT)}
    mark, color = marks[outcome["passed"]]
    return TextArea(f"{mark} {name}", textprops={"color": color, "fontsize": 9.5, "weight": "bold"})


def _draw_traces(
    figure: Figure, place: Any, story: Story, coloured: Sequence[Coloured], pictures_s: Sequence[float]
) -> None:
    """Stack everything that happens over time on one time axis."""
    rows: list[tuple[float, str, Any]] = []
    if coloured:
        visuals = len({interval.visual for interval in coloured})
        rows.append((0.2 * visuals, "", lambda axes: draw_timeline(axes, story, coloured)))
    if story.spikes:
        rows.append((1.7, "Spikes", lambda axes: draw_raster(axes, story)))
    rows += _value_rows(story)
    if not rows:
        return
    grid = GridSpecFromSubplotSpec(
        len(rows) + 1, 1, place, height_ratios=[*(height for height, _, _ in rows), 0.05], hspace=0.4
    )
    stack: list[Axes] = []
    for number, (_, title, draw) in enumerate(rows):
        axes = figure.add_subplot(grid[number], sharex=stack[0] if stack else None)
        axes.set_title(title)
        draw(axes)
        if number or not coloured:
            shade(axes, coloured)
        axes.tick_params(labelbottom=False)
        stack.append(axes)
    _draw_clock(figure.add_subplot(grid[-1], sharex=stack[0]), story.end_s, pictures_s)
    stack[0].set_xlim(0, story.end_s or 1.0)


def _value_rows(story: Story) -> list[tuple[float, str, Any]]:
    rows: list[tuple[float, str, Any]] = []
    for kind, all_series in (("Devices", story.sinks), ("Commands", moving(story.commands))):
        for unit, series in by_unit(all_series).items():
            title = f"{kind} ({unit})" if series[0].unit else unit
            height = height_of(series, 0.8)
            rows.append((height, title, lambda axes, s=series: draw_values(axes, s, story.end_s)))
    return rows[:6]


def _draw_clock(axes: Axes, end_s: float, pictures_s: Sequence[float]) -> None:
    """Draw the time axis in the colours of the track, with a mark for each picture."""
    span = (0, end_s or 1.0)
    axes.imshow(np.linspace(0, 1, 256)[np.newaxis], cmap=time_colours(), aspect="auto", extent=(*span, 0, 1))
    axes.plot(pictures_s, [1.9] * len(pictures_s), "v", color=FAINT, markersize=4, clip_on=False)
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xticks(MaxNLocator(10, steps=[1, 2, 5, 10]).tick_values(*span))
    axes.set(xlim=span, ylim=(0, 1), xlabel="simulated time (s)")


def _draw_pictures(figure: Figure, pictures: Sequence[CameraFrame], end_s: float) -> None:
    """Line up what the camera saw, each framed in the colour of its time."""
    gap, bottom, height = 0.006, 0.03, 0.16
    width = (_RIGHT - _LEFT + gap) / max(len(pictures), PICTURES)
    for number, picture in enumerate(pictures):
        axes = figure.add_axes((_LEFT + number * width, bottom, width - gap, height), anchor="SW")
        axes.imshow(picture.pixels)
        axes.set(xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set(visible=True, linewidth=2, color=time_colours()(picture.t_s / end_s if end_s else 0.0))
        axes.set_title(f"{picture.t_s:.1f} s", fontsize=8, weight="normal", pad=4)
