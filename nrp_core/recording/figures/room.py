"""The room from above, to scale: furniture, where the robots went, what changed its colour."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.labels import keep_apart, label, label_ends
from nrp_core.recording.figures.story import Coloured, Rgb, Story, Track
from nrp_core.recording.figures.style import FAINT, time_colours
from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.world.messages.visualization_msgs import CYLINDER, SPHERE, Marker
from nrp_core.world.rigid.pose import Pose

_OVERHEAD_M = 2.2
"""What begins above this height hides what happens below, and is left out."""
_FLAT_M = 0.06
"""What does not rise above this is ground."""
_MARGIN_M = 0.35


@dataclass(frozen=True)
class GroundOutline:
    """The outline of a visual seen from above, shape ``(n, 2)``, and how far it reaches up and down."""

    outline: FloatArray
    bottom: float
    top: float
    marker: Marker

    @property
    def is_ground(self) -> bool:
        """Whether one could drive over it."""
        return self.top < _FLAT_M

    @property
    def is_overhead(self) -> bool:
        """Whether one would walk below it."""
        return self.bottom > _OVERHEAD_M


def footprint(marker: Marker) -> GroundOutline:
    """Return the outline of a marker in its own frame; a mesh is a point."""
    p, q = marker.pose.position, marker.pose.orientation
    pose = Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    corners = np.array([np.add(pose.rotate(corner), pose.position) for corner in _corners(marker)])
    hull = cv2.convexHull(corners[:, :2].astype(np.float32)).reshape(-1, 2)
    heights = corners[:, 2]
    return GroundOutline(np.asarray(hull, float), float(heights.min()), float(heights.max()), marker)


def _corners(marker: Marker) -> list[tuple[float, float, float]]:
    half = (marker.scale.x / 2, marker.scale.y / 2, marker.scale.z / 2)
    if marker.type in (CYLINDER, SPHERE):
        turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        rim = [(half[0] * np.cos(a), half[1] * np.sin(a)) for a in turns]
    else:
        rim = [(sx * half[0], sy * half[1]) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    return [(float(x), float(y), z) for z in (-half[2], half[2]) for x, y in rim]


def draw_room(axes: Axes, story: Story, coloured: Iterable[Coloured]) -> None:
    """Draw the room with everything in it."""
    prints = [footprint(marker) for marker in story.markers if marker.color.a > 0.05]
    fixed = [p for p in prints if p.marker.header.frame_id == WORLD_FRAME and not p.is_overhead]
    for piece in sorted(fixed, key=lambda p: p.top):
        _draw_piece(axes, piece)
    labels = _draw_coloured(axes, fixed, list(coloured), story)
    standing = [piece.outline for piece in fixed if not piece.is_ground]
    reaches = {}
    for name, track in story.tracks.items():
        _draw_track(axes, track, story.end_s)
        body = [p for p in prints if p.marker.header.frame_id == name]
        for index in (0, -1):
            standing += _draw_robot(axes, body, track, index, story.end_s)
        reaches[name] = max((float(np.hypot(*p.outline.T).max()) for p in body), default=0.0)
    _set_limits(axes, standing, story.tracks.values())
    for name, track in story.tracks.items():
        labels += label_ends(axes, name, track, reaches[name])
    keep_apart(axes, labels)


def _draw_piece(axes: Axes, piece: GroundOutline) -> None:
    color = piece.marker.color
    fill = _pale((color.r, color.g, color.b), 0.82 if piece.is_ground else 0.45)
    edge = "none" if piece.is_ground else _pale((color.r * 0.5, color.g * 0.5, color.b * 0.5), 0.3)
    axes.add_patch(Polygon(piece.outline, facecolor=fill, edgecolor=edge, linewidth=0.5, zorder=1))


def _pale(rgb: Rgb, white: float) -> Rgb:
    r, g, b = (min(1.0, channel) * (1 - white) + white for channel in rgb)
    return r, g, b


def _draw_coloured(
    axes: Axes, fixed: list[GroundOutline], coloured: list[Coloured], story: Story
) -> list[Annotation]:
    """Draw what changed its colour as a bold bar; return its names and when that was."""
    labels = []
    inside = _middle(story.tracks.values())
    for piece in fixed:
        intervals = [interval for interval in coloured if interval.visual == piece.marker.ns]
        if not intervals:
            continue
        xs, ys = _longest_axis(piece.outline)
        axes.plot(xs, ys, color=intervals[-1].rgb, linewidth=4, solid_capstyle="butt", zorder=4)
        times = ", ".join(f"{one.since_s:.3g}\N{EN DASH}{one.until_s:.3g} s" for one in intervals[:3])
        text = f"{story.name_of(piece.marker.ns)}: {times}{' …' if intervals[3:] else ''}"
        along = np.array([xs[1] - xs[0], ys[1] - ys[0]])
        centre, normal = np.array([xs.mean(), ys.mean()]), np.array([-along[1], along[0]])
        outwards = normal if normal @ (centre - inside) >= 0 else -normal
        angle = (np.degrees(np.arctan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
        labels.append(label(axes, text, centre, outwards, distance=11, angle=float(angle)))
    return labels


def _middle(tracks: Iterable[Track]) -> FloatArray:
    """Return the middle of where the robots were."""
    points = [np.column_stack([track.xs, track.ys]).mean(axis=0) for track in tracks]
    return np.mean(points, axis=0) if points else np.zeros(2)


def _longest_axis(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middle line of an outline along its longer side, as xs and ys of its two ends."""
    centre = outline.mean(axis=0)
    _, _, directions = np.linalg.svd(outline - centre)
    along = (outline - centre) @ directions[0]
    ends = centre + np.outer([along.min(), along.max()], directions[0])
    return ends[:, 0], ends[:, 1]


def _draw_track(axes: Axes, track: Track, end_s: float) -> None:
    points = np.column_stack([track.xs, track.ys])
    lines = LineCollection(
        np.stack([points[:-1], points[1:]], axis=1).tolist(), cmap=time_colours(), linewidth=1.6,
        capstyle="round", zorder=6,
    )  # fmt: skip
    lines.set_array(np.array(track.times_s[:-1]))
    lines.set_clim(0, end_s)
    axes.add_collection(lines)


def _draw_robot(
    axes: Axes, body: list[GroundOutline], track: Track, index: int, end_s: float
) -> list[FloatArray]:
    """Draw a robot where it was at an entry of its track, with a line to its front; return its outlines."""
    x, y, yaw = track.xs[index], track.ys[index], track.yaws[index]
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    color = time_colours()(track.times_s[index] / end_s if end_s else 0.0)
    outlines = [piece.outline @ turn.T + (x, y) for piece in body]
    for outline in outlines:
        axes.add_patch(
            Polygon(outline, facecolor=(*color[:3], 0.18), edgecolor=color, linewidth=0.6, zorder=5)
        )
    front = max((float(piece.outline[:, 0].max()) for piece in body), default=0.3)
    nose = turn @ np.array([front, 0.0]) + (x, y)
    axes.plot([x, nose[0]], [y, nose[1]], color=color, linewidth=1.4, zorder=7)
    axes.plot(x, y, "o", color=color, markersize=3.5, zorder=7)
    return outlines


def _set_limits(axes: Axes, standing: Iterable[FloatArray], tracks: Iterable[Track]) -> None:
    corners = [*standing, *(np.column_stack([track.xs, track.ys]) for track in tracks)]
    points = np.concatenate(corners) if corners else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(
            MaxNLocator("auto", steps=[1, 2, 5, 10])
        )  # short numbers, for the margin is narrow
    axes.yaxis.labelpad = 3
    axes.tick_params(color=FAINT)
