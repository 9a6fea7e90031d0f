"""The room from above, to scale: furniture, trajectories of robots, changes of colours."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.labels import keep_apart, label, label_ends
from nrp_core.recording.figures.story import Coloured, Rgb, Story, Track
from nrp_core.recording.figures.style import FAINT, INK, PAPER, time_colours
from nrp_core.recording.figures.view import Bounds, GroundOutline, RoomView

_MUCH_LARGER, _INSET = 3.0, 0.3
"""A room this many times as large as the map is shown in a corner, with this share of the map's width."""
_PLACES, _POINTS = 9, 200
"""Number of positions that are tried on a side, and of points on a line that are checked."""
_SMALL_MAP_M = 0.1
"""Maps of a smaller width have axes in millimetres."""
_NOSE_M = 0.3
"""Length of the line to the front of a robot without visuals."""


def draw_room(axes: Axes, view: RoomView, coloured: Iterable[Coloured]) -> None:
    """Draw the trajectories of robots and their surroundings; a larger room is shown in a corner."""
    story, coloured = view.story, list(coloured)
    _draw_pieces(axes, view)
    labels = _draw_coloured(axes, view.fixed, coloured, story)
    reaches = {}
    for name, track in story.tracks.items():
        _draw_track(axes, track, story)
        for index, outlines in zip((0, -1), view.robots[name], strict=True):
            reaches[name] = _draw_robot(axes, outlines, track, index, story)
    _set_limits(axes, view.focus(coloured))
    for name, track in story.tracks.items():
        labels += label_ends(axes, name, track, reaches[name])
    keep_apart(axes, labels, _draw_whole(axes, view, coloured))


def _draw_pieces(axes: Axes, view: RoomView) -> None:
    for piece in sorted(view.fixed, key=lambda each: each.top):
        _draw_piece(axes, piece)


def _draw_whole(axes: Axes, view: RoomView, coloured: Iterable[Coloured]) -> list[Bbox]:
    """Draw a room that is much larger than the map in the emptiest place at a side; return that place."""
    axes.apply_aspect()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    shown, whole = Bounds(left, right, bottom, top), view.whole()
    if whole.area < _MUCH_LARGER * shown.area:
        return []
    width = min(_INSET, _INSET * whole.aspect)
    height = width / whole.aspect * axes.bbox.width / axes.bbox.height
    place = (*_emptiest_side(axes, view.foreground(coloured), width, height), width, height)
    inset = axes.inset_axes(place, zorder=8)
    _draw_pieces(inset, view)
    for track in view.story.tracks.values():
        _draw_track(inset, track, view.story)
    inset.add_patch(
        Rectangle(
            (left, bottom), right - left, top - bottom, fill=False, edgecolor=INK, linewidth=0.8, zorder=9
        )
    )
    inset.set(
        xlim=(whole.left, whole.right), ylim=(whole.bottom, whole.top), xticks=[], yticks=[], facecolor=PAPER
    )
    for spine in inset.spines.values():
        spine.set(visible=True, edgecolor=FAINT)
    return [Bbox.from_bounds(*place).transformed(axes.transAxes)]


def _emptiest_side(
    axes: Axes, lines: Iterable[FloatArray], width: float, height: float
) -> tuple[float, float]:
    """Return the place on the left or right side of the axes that lines cover least, in axes units."""
    gap = 0.015
    heights = np.linspace(1 - height - gap, gap, _PLACES)
    places = [(x, float(y)) for y in heights for x in (1 - width - gap, gap)]
    points = np.concatenate([_dense(line) for line in lines])
    at = axes.transAxes.inverted().transform(axes.transData.transform(points))
    covered = [
        np.all((at >= place) & (at <= np.add(place, (width, height))), axis=1).sum() for place in places
    ]
    return places[int(np.argmin(covered))]


def _dense(line: FloatArray) -> FloatArray:
    """Return many points of a line through the given ones."""
    at = np.linspace(0, len(line) - 1, _POINTS)
    return np.column_stack([np.interp(at, np.arange(len(line)), line[:, axis]) for axis in (0, 1)])


def _draw_piece(axes: Axes, piece: GroundOutline) -> None:
    r, g, b, _ = piece.shape.rgba
    fill = _pale((r, g, b), 0.82 if piece.is_ground else 0.45)
    edge = "none" if piece.is_ground else _pale((r * 0.5, g * 0.5, b * 0.5), 0.3)
    axes.add_patch(Polygon(piece.outline, facecolor=fill, edgecolor=edge, linewidth=0.5, zorder=1))


def _pale(rgb: Rgb, white: float) -> Rgb:
    r, g, b = (min(1.0, channel) * (1 - white) + white for channel in rgb)
    return r, g, b


def _draw_coloured(
    axes: Axes, fixed: list[GroundOutline], coloured: list[Coloured], story: Story
) -> list[Annotation]:
    """Draw objects that changed their colour as bold bars; return their names and the times."""
    labels = []
    inside = _middle(story.tracks.values())
    for piece in fixed:
        intervals = [interval for interval in coloured if interval.visual == piece.shape.visual]
        if not intervals:
            continue
        xs, ys = _longest_axis(piece.outline)
        axes.plot(xs, ys, color=intervals[-1].rgb, linewidth=4, solid_capstyle="butt", zorder=4)
        times = ", ".join(f"{one.since_s:.3g}\N{EN DASH}{one.until_s:.3g} s" for one in intervals[:3])
        text = f"{story.name_of(piece.shape.visual)}: {times}{' …' if intervals[3:] else ''}"
        along = np.array([xs[1] - xs[0], ys[1] - ys[0]])
        centre, normal = np.array([xs.mean(), ys.mean()]), np.array([-along[1], along[0]])
        outwards = normal if normal @ (centre - inside) >= 0 else -normal
        angle = (np.degrees(np.arctan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
        labels.append(label(axes, text, centre, outwards, distance=11, angle=float(angle)))
    return labels


def _middle(tracks: Iterable[Track]) -> FloatArray:
    """Return the middle of the robots' trajectories."""
    points = [np.column_stack([track.xs, track.ys]).mean(axis=0) for track in tracks]
    return np.mean(points, axis=0) if points else np.zeros(2)


def _longest_axis(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middle line of an outline along its longer side, as xs and ys of its two ends."""
    centre = outline.mean(axis=0)
    _, _, directions = np.linalg.svd(outline - centre)
    along = (outline - centre) @ directions[0]
    ends = centre + np.outer([along.min(), along.max()], directions[0])
    return ends[:, 0], ends[:, 1]


def _draw_track(axes: Axes, track: Track, story: Story) -> None:
    points = np.column_stack([track.xs, track.ys])
    lines = LineCollection(
        np.stack([points[:-1], points[1:]], axis=1).tolist(), cmap=time_colours(), linewidth=1.6,
        capstyle="round", zorder=6,
    )  # fmt: skip
    lines.set_array(np.array(track.times_s[:-1]))
    lines.set_clim(*story.span_s)
    axes.add_collection(lines)


def _draw_robot(axes: Axes, outlines: list[FloatArray], track: Track, index: int, story: Story) -> float:
    """Draw a robot at its pose in an entry of its track, with a line to its front; return its reach, m."""
    x, y, yaw = track.xs[index], track.ys[index], track.yaws[index]
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    color = time_colours()(story.share_of(track.times_s[index]))
    for outline in outlines:
        axes.add_patch(
            Polygon(outline, facecolor=(*color[:3], 0.18), edgecolor=color, linewidth=0.6, zorder=5)
        )
    away = np.vstack([np.zeros((1, 2)), *(outline - (x, y) for outline in outlines)])
    nose = (x, y) + ahead * (float((away @ ahead).max()) if outlines else _NOSE_M)
    axes.plot([x, nose[0]], [y, nose[1]], color=color, linewidth=1.4, zorder=7)
    axes.plot(x, y, "o", color=color, markersize=3.5, zorder=7)
    return float(np.hypot(*away.T).max())


def _set_limits(axes: Axes, focus: Bounds) -> None:
    """Show the focus, and its surroundings as far as they fit into the axes."""
    bounds = focus.widened(axes.bbox.width / axes.bbox.height)
    in_mm = bounds.right - bounds.left < _SMALL_MAP_M
    unit, factor = ("mm", 1e3) if in_mm else ("m", 1.0)
    axes.set(
        xlim=(bounds.left, bounds.right), ylim=(bounds.bottom, bounds.top), aspect="equal",
        xlabel=f"x ({unit})", ylabel=f"y ({unit})",
    )  # fmt: skip
    for axis in (axes.xaxis, axes.yaxis):
        if in_mm:
            axis.set_major_formatter(lambda value, _: f"{factor * value:g}".replace("-", "\N{MINUS SIGN}"))
        axis.set_major_locator(
            MaxNLocator("auto", steps=[1, 2, 5, 10])
        )  # short numbers: the margin is narrow
    axes.yaxis.labelpad = 3
    axes.tick_params(color=FAINT)
