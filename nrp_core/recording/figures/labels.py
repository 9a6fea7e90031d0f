"""Names on the map: beside what they name, within the axes, and clear of each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import Track

_APART_M = 0.6
_BESIDE_PT = 10
_HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]


def label(
    axes: Axes, text: str, place: FloatArray, away: FloatArray, *, distance: float, angle: float = 0.0
) -> Annotation:
    """Write a text beside a place, so many points away from it in a direction."""
    length = float(np.hypot(*away))
    offset = away / length * distance if length else np.array([0.0, distance])
    flat = angle == 0.0 and abs(offset[0]) > abs(offset[1])
    return axes.annotate(
        text, (place[0], place[1]), (offset[0], offset[1]), textcoords="offset points", fontsize=8,
        ha=("left" if offset[0] > 0 else "right") if flat else "center", va="center", rotation=angle,
        rotation_mode="anchor", path_effects=_HALO, zorder=9,
    )  # fmt: skip


def keep_apart(axes: Axes, labels: Sequence[Annotation]) -> None:
    """Move labels into the axes, and above those that they would cover."""
    axes.apply_aspect()
    frame, points = axes.get_window_extent(), 72 / axes.figure.dpi
    taken: list[Bbox] = []
    for one in labels:
        box = one.get_window_extent()
        right = max(frame.x0 - box.x0, 0.0) or min(frame.x1 - box.x1, 0.0)
        up = max(frame.y0 - box.y0, 0.0) or min(frame.y1 - box.y1, 0.0)
        box = box.translated(right, up)
        while any(box.overlaps(other) for other in taken):
            up += box.height
            box = box.translated(0.0, box.height)
        one.xyann = (one.xyann[0] + right * points, one.xyann[1] + up * points)
        taken.append(box)


def label_ends(axes: Axes, name: str, track: Track, reach_m: float) -> list[Annotation]:
    """Write when the robot was where it started and where it ended; once, where that is one place."""
    start, end = (np.array([track.xs[i], track.ys[i]]) for i in (0, -1))
    axes.apply_aspect()
    distance = _BESIDE_PT + reach_m * axes.bbox.width / np.ptp(axes.get_xlim()) * 72 / axes.figure.dpi
    if not any(np.ptp(values) for values in (track.xs, track.ys, track.yaws)):
        return [label(axes, name, end, np.array([0.0, 1.0]), distance=distance)]
    texts = [(start, f"{name} {track.times_s[0]:g} s"), (end, f"{track.times_s[-1]:.3g} s")]
    if np.hypot(*(start - end)) < _APART_M:
        texts = [(end, f"{texts[0][1]} and {texts[1][1]}")]
    # across the way to the other end, on the side that is on the right
    across = np.array([-(end - start)[1], (end - start)[0]])
    away = across if across[0] >= 0 else -across
    return [label(axes, text, place, away, distance=distance) for place, text in texts]
