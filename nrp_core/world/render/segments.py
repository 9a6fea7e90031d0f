"""Segments: what each pixel of an image shows, as the label of a visual and the number of its model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.merged_bodies import Body

SegmentArray = npt.NDArray[np.uint16]
"""Labels and numbers of instances, shape ``(height, width, 2)``; 0 and 0 where nothing has a label."""


def segments_of(bodies: Mapping[str, Sequence[Body]]) -> SegmentArray:
    """Return label and instance of every visual in the order of a scene's mesh, and last of the background.

    The models with visuals of a label are its instances, numbered from 1 in the order of the scene.
    """
    rows = []
    seen: dict[int, list[str]] = {}
    for model, parts in bodies.items():
        for visual in (each for body in parts for link in body.links for each in link.visuals):
            models = seen.setdefault(visual.label, [])
            if model not in models:
                models.append(model)
            rows.append((visual.label, len(models) if visual.label else 0))
    return np.array([*rows, (0, 0)], np.uint16)
