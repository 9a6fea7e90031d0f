"""The room from above, to scale: furniture, trajectories of robots, changes of colours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import Coloured, Rgb, Story, Track
from nrp_core.recording.figures.style import FAINT, INK, PAPER, points, time_colours
from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.recording.reading.shapes import RecordedShape, ShapeKind
from nrp_core.scene.meshes.stl import parse_stl
from nrp_core.scene.rigid import Pose, rotation_matrix

_OVERHEAD_M = 2.2
"""Shapes that start above this height (m) hide the scene and are left out."""
_FLAT_M = 0.06
"""Shapes that end below this height (m) are ground."""
_MARGIN_M, _MARGIN_SIZE, _MARGIN = 0.3, 0.3, 0.08
"""Margin of a map: at least this distance (m), or this share of a small robot's size; and this share of the
map's larger side."""
_STILL_M, _STILL_RAD = 0.05, 0.1
"""A robot with less motion (m, or a fifth of a small robot's size) and rotation (rad) counts as standing."""
_FIFTH = 0.2
_FAINTEST = 0.05
"""Shapes less opaque than this are not drawn."""


@dataclass(frozen=True)
class GroundOutline:
    """The outline of a shape seen from above, m, shape ``(n, 2)``, with its lowest and highest point."""

    outline: FloatArray
    bottom: float
    top: float
    shape: RecordedShape

    @property
    def is_ground(self) -> bool:
        """Whether a robot could drive over it."""
        return self.top < _FLAT_M

    @property
    def is_overhead(self) -> bool:
        """Whether a person could walk below it."""
        return self.bottom > _OVERHEAD_M


def footprint(shape: RecordedShape, frame: Pose) -> GroundOutline:
    """Return the outline of a shape whose frame has this pose in the world."""
    pose = frame @ shape.pose
    corners = _corners(shape) @ rotation_matrix(pose.orientation).T + pose.position
    hull = cv2.convexHull(corners[:, :2].astype(np.float32)).reshape(-1, 2)
    heights = corners[:, 2]
    return GroundOutline(np.asarray(hull, float), float(heights.min()), float(heights.max()), shape)


def _corners(shape: RecordedShape) -> FloatArray:
    """Return points of a shape's hull in its own frame, shape ``(n, 3)``."""
    if shape.kind is ShapeKind.MESH:
        triangles = np.zeros((1, 3)) if shape.mesh is None else parse_stl(shape.mesh.tobytes())
        return triangles.reshape(-1, 3) * shape.size
    x, y, z = np.divide(shape.size, 2)
    if shape.kind is ShapeKind.BOX:
        rim = np.array([(x, y), (-x, y), (-x, -y), (x, -y)])
    else:
        turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        rim = np.column_stack([x * np.cos(turns), y * np.sin(turns)])
    return np.vstack([np.column_stack([rim, np.full(len(rim), height)]) for height in (-z, z)])


@dataclass(frozen=True)
class RoomView:
    """The room from above: its objects, and the trajectories of robots.

    Args:
        story: of the run.
        fixed: the outlines of static objects.
        robots: outlines of each robot at its first and last pose.
    """

    story: Story
    fixed: list[GroundOutline]
    robots: dict[str, tuple[list[FloatArray], list[FloatArray]]]

    @classmethod
    def of(cls, story: Story) -> RoomView:
        """Return the view of a run."""
        seen = [shape for shape in story.scene.shapes if shape.rgba[3] > _FAINTEST]
        fixed = [footprint(shape, Pose()) for shape in seen if shape.frame == WORLD_FRAME]
        robots = {
            name: (_outlines(seen, name, story.first_poses), _outlines(seen, name, story.last_poses))
            for name in story.tracks
        }
        return cls(story, [piece for piece in fixed if not piece.is_overhead], robots)

    @property
    def moves(self) -> bool:
        """Whether a robot as a whole moved, so that a map of it shows something."""
        return any(
            max(np.ptp(track.xs), np.ptp(track.ys)) > min(_STILL_M, _FIFTH * self.size_m(name))
            or np.ptp(track.yaws) > _STILL_RAD
            for name, track in self.story.tracks.items()
        )

    def size_m(self, robot: str) -> float:
        """Return the larger side of a robot, m; infinity if it has no shapes."""
        first, _ = self.robots[robot]
        return float(np.ptp(np.concatenate(first), axis=0).max()) if first else inf

    @property
    def _margin_m(self) -> float:
        return min((_MARGIN_M, *(_MARGIN_SIZE * self.size_m(robot) for robot in self.robots)))

    def focus(self, coloured: Iterable[Coloured] = ()) -> Bounds:
        """Return the area of a map: robots, their trajectories, and changes of colours; with a margin."""
        return _bounds(self.foreground(coloured), self._margin_m)

    def whole(self) -> Bounds:
        """Return the bounds of all objects in the room."""
        standing = [piece.outline for piece in self.fixed if not piece.is_ground]
        return _bounds([*standing, *self.travelled()], self._margin_m)

    def foreground(self, coloured: Iterable[Coloured]) -> list[FloatArray]:
        """Return the outlines of objects that changed their colour, of the robots, and their trajectories."""
        bright = {interval.visual for interval in coloured}
        outlines = [piece.outline for piece in self.fixed if piece.shape.visual in bright]
        return outlines + self.travelled()

    def travelled(self) -> list[FloatArray]:
        """Return the outlines of the robots at both ends of their trajectories, and the trajectories."""
        outlines = [outline for both in self.robots.values() for each in both for outline in each]
        tracks = self.story.tracks.values()
        return outlines + [np.column_stack([track.xs, track.ys]) for track in tracks]


@dataclass(frozen=True)
class Bounds:
    """A rectangle on the ground, m."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def aspect(self) -> float:
        """Width divided by height."""
        return (self.right - self.left) / (self.top - self.bottom)

    def widened(self, aspect: float) -> Bounds:
        """Return the smallest bounds with another aspect ratio and the same middle that contain these."""
        width = max(self.right - self.left, (self.top - self.bottom) * aspect)
        x, y, height = (self.left + self.right) / 2, (self.bottom + self.top) / 2, width / aspect
        return Bounds(x - width / 2, x + width / 2, y - height / 2, y + height / 2)

    @property
    def area(self) -> float:
        """In m^2."""
        return (self.right - self.left) * (self.top - self.bottom)


def _bounds(outlines: Sequence[FloatArray], margin_m: float) -> Bounds:
    points = np.concatenate(outlines) if outlines else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(margin_m, _MARGIN * float((high - low).max()))
    (left, bottom), (right, top) = low - margin, high + margin
    return Bounds(float(left), float(right), float(bottom), float(top))


def _outlines(seen: Iterable[RecordedShape], model: str, poses: Mapping[str, Pose]) -> list[FloatArray]:
    return [
        footprint(shape, poses[shape.frame]).outline
        for shape in seen
        if shape.model == model and shape.frame != WORLD_FRAME and shape.frame in poses
    ]


_APART = 0.15
"""Closer ends of a path, as a share of the map's width, have one label."""
_BESIDE_PT = 10
_BORDER_PT = 4
_WAYS = (0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6)
"""Maximum distance of a label from its first position, in multiples of its height."""
_HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]


def label(
    axes: Axes, text: str, place: FloatArray, away: FloatArray, *, distance: float, angle: float = 0.0
) -> Annotation:
    """Write a text beside a place, at a distance in points in a direction."""
    length = float(np.hypot(*away))
    offset = away / length * distance if length else np.array([0.0, distance])
    flat = angle == 0.0 and abs(offset[0]) > abs(offset[1])
    return axes.annotate(
        text, (place[0], place[1]), (offset[0], offset[1]), textcoords="offset points", fontsize=points(8),
        ha=("left" if offset[0] > 0 else "right") if flat else "center", va="center", rotation=angle,
        rotation_mode="anchor", path_effects=_HALO, zorder=9,
    )  # fmt: skip


def separate_labels(axes: Axes, labels: Sequence[Annotation], taken: Iterable[Bbox] = ()) -> None:
    """Move labels into the axes, and up or down to avoid overlaps with taken places and each other."""
    axes.apply_aspect()
    frame, points = axes.get_window_extent(), 72 / axes.figure.dpi
    frame = frame.padded(-_BORDER_PT / points)
    taken = list(taken)
    for one in labels:
        box = one.get_window_extent()
        right = max(frame.x0 - box.x0, 0.0) or min(frame.x1 - box.x1, 0.0)
        up = max(frame.y0 - box.y0, 0.0) or min(frame.y1 - box.y1, 0.0)
        box = box.translated(right, up)
        free = next(
            (way for way in _WAYS if _is_free(box.translated(0.0, way * box.height), frame, taken)), 0
        )
        box, up = box.translated(0.0, free * box.height), up + free * box.height
        one.xyann = (one.xyann[0] + right * points, one.xyann[1] + up * points)
        taken.append(box)


def _is_free(box: Bbox, frame: Bbox, taken: Iterable[Bbox]) -> bool:
    inside = box.y0 >= frame.y0 - 1 and box.y1 <= frame.y1 + 1
    return inside and not any(box.overlaps(other) for other in taken)


def label_ends(axes: Axes, name: str, track: Track, reach_m: float) -> list[Annotation]:
    """Write the times at both ends of the robot's path; once if they are the same place."""
    start, end = (np.array([track.xs[i], track.ys[i]]) for i in (0, -1))
    axes.apply_aspect()
    distance = _BESIDE_PT + reach_m * axes.bbox.width / np.ptp(axes.get_xlim()) * 72 / axes.figure.dpi
    if not any(np.ptp(values) for values in (track.xs, track.ys, track.yaws)):
        return [label(axes, name, end, np.array([0.0, 1.0]), distance=distance)]
    texts = [(start, f"{name} {track.times_s[0]:g} s"), (end, f"{track.times_s[-1]:.3g} s")]
    if np.hypot(*(start - end)) < _APART * np.ptp(axes.get_xlim()):
        texts = [(end, f"{texts[0][1]} and {texts[1][1]}")]
    # perpendicular to the line to the other end, on its right
    across = np.array([-(end - start)[1], (end - start)[0]])
    away = across if across[0] >= 0 else -across
    return [label(axes, text, place, away, distance=distance) for place, text in texts]


_MUCH_LARGER, _INSETS = 3.0, (0.3, 0.22, 0.16)
"""A room this many times as large as the map is shown in a corner, whose width is the first of these shares
of the map's width with which it does not cover anything that moves."""
_HIGHEST = 1.3  # maximum share of the map's height, in multiples of the share of its width
_CLEAR = 0.03
"""Minimum distance of the corner from everything that moves, as a share of the map."""
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
    separate_labels(axes, labels, _draw_whole(axes, view, coloured))


def _draw_pieces(axes: Axes, view: RoomView) -> None:
    for piece in sorted(view.fixed, key=lambda each: each.top):
        _draw_piece(axes, piece)


def _draw_whole(axes: Axes, view: RoomView, coloured: Iterable[Coloured]) -> list[Bbox]:
    """Draw a room that is much larger than the map where there is most space at a side; return that place.

    It is drawn smaller if a robot or its trajectory is near, and left out if even the smallest is too near.
    """
    axes.apply_aspect()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    shown, whole = Bounds(left, right, bottom, top), view.whole()
    if whole.area < _MUCH_LARGER * shown.area:
        return []
    near = _in_axes(axes, view.foreground(coloured))
    beside = _in_axes(axes, [p.outline for p in view.fixed if not p.is_ground])
    for share in _INSETS:
        tall = axes.bbox.width / axes.bbox.height / whole.aspect  # height for each width, in axes units
        width = min(share, share * whole.aspect, _HIGHEST * share / tall)
        height = width * tall
        corner = _emptiest_side(near, beside, width, height)
        if corner is not None:
            break
    else:
        return []
    place = (*corner, width, height)
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


def _in_axes(axes: Axes, lines: Iterable[FloatArray]) -> FloatArray:
    """Return many points of lines, in axes units, shape ``(n, 2)``."""
    points = np.concatenate([np.empty((0, 2)), *(_dense(line) for line in lines)])
    at: FloatArray = axes.transAxes.inverted().transform(axes.transData.transform(points))
    return at


def _emptiest_side(
    near: FloatArray, beside: FloatArray, width: float, height: float
) -> tuple[float, float] | None:
    """Return the place at the left or right side that covers least; None if all are near what moves.

    Args:
        near: points of what moves, in axes units, shape ``(n, 2)``.
        beside: points of furniture, which may be covered if there is no free place.
        width: the width of the place, in axes units.
        height: its height.
    """
    gap = 0.015

    def covered(points: FloatArray, place: tuple[float, float], clear: float) -> int:
        low, high = np.subtract(place, clear), np.add(place, (width + clear, height + clear))
        return int(np.all((points >= low) & (points <= high), axis=1).sum())

    heights = np.linspace(1 - height - gap, gap, _PLACES)
    places = [(x, float(y)) for y in heights for x in (1 - width - gap, gap)]
    free = [place for place in places if not covered(near, place, _CLEAR)]
    return min(free, key=lambda place: covered(beside, place, 0.0), default=None)


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
