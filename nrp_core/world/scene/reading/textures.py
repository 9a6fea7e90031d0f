"""Images on surfaces, with digests of what is in them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.meshes import digest
from nrp_core.world.scene.model import Texture


def texture_of(image: Path | None, tint: Vector = (1.0, 1.0, 1.0)) -> Texture | None:
    """Return the texture of an image file; None for none."""
    if image is None:
        return None
    try:
        return Texture(image, tint, _digest(image, image.stat().st_mtime_ns))
    except OSError:
        return Texture(image, tint)


@lru_cache(maxsize=256)
def _digest(image: Path, _changed_ns: int) -> str:
    return digest(image.read_bytes())
