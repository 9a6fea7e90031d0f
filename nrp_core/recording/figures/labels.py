"""Labels on the map: beside their objects, inside the axes, without overlaps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import Track
from nrp_core.recording.figures.style import points

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


def keep_apart(axes: Axes, labels: Sequence[Annotation], taken: Iterable[Bbox] = ()) -> None:
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
