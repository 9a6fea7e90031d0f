"""Visuals that are valid and show what is not meant: colours of bytes, invisible things, things elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from nrp_core.world.scene.implausible_shapes import box_around
from nrp_core.world.scene.model import Link, Model

_BRIGHTEST: Final = 2.0
"""Files say a little more than 1 for something bright; colours of bytes are above 2 unless they are black."""

_TIMES: Final = 50.0
"""How many times larger than it is felt a thing of a room is seen, along each axis, in another unit."""
_THIN_M: Final = 1e-3


def of_looks(model: Model) -> Iterator[str]:
    """Yield a sentence for each visual that does not show its body.

    Raises:
        SceneError: a mesh cannot be read.
    """
    visuals = [(link, one) for link in model.links for one in link.visuals]
    if visuals and not any(one.rgba[3] > 0 for _, one in visuals):
        yield f"nothing of '{model.name}' is seen: the opacity of each of its visuals is 0"
    for link, one in visuals:
        if max(one.rgba[:3]) > _BRIGHTEST:
            color = " ".join(f"{channel:g}" for channel in one.rgba[:3])
            yield (
                f"the colour of the visual '{one.name}' of '{model.name}/{link.name}' is {color}, and 1 is "
                "full brightness; is it meant in 0 to 255?"
            )
            break
    for link in model.links:
        yield from _of_place(link, model)


def _of_place(link: Link, model: Model) -> Iterator[str]:
    """Yield that a link is seen farther from where it is felt than either is large, or in another unit."""
    seen, felt = (
        box_around((one.pose, one.geometry) for one in shapes) for shapes in (link.visuals, link.collisions)
    )
    if seen is None or felt is None:
        return
    shown, touched = (np.maximum(high - low, _THIN_M) for low, high in (seen, felt))
    times = shown / touched
    if model.static and (times.min() > _TIMES or times.max() < 1 / _TIMES):
        yield (
            f"the visuals of the link '{link.name}' of '{model.name}' are {shown.max():.2g} m large, and its "
            f"collision shapes {touched.max():.2g} m; is one of them in another unit?"
        )
        return
    gap_m = float(np.linalg.norm(np.maximum(0.0, np.maximum(seen[0] - felt[1], felt[0] - seen[1]))))
    if gap_m > max(float(np.linalg.norm(high - low)) for low, high in (seen, felt)):
        yield (
            f"the link '{link.name}' of '{model.name}' is seen {gap_m:.2g} m away from its collision shapes, "
            "where it is touched; has one of them another <pose>?"
        )
