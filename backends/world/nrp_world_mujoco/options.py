"""Options of the ``mujoco`` backend, and the OpenGL library that draws without a display."""

from __future__ import annotations

import os
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Annotated, Literal

from pydantic import Field

from nrp_core._support.probe import probe_succeeds
from nrp_core.world.engine_kit.jointed import PhysicsOptions

HEADLESS_LIBRARIES = ("egl", "osmesa")
_OFF = ("disable", "disabled", "off", "false", "0")


def headless_library() -> str | None:
    """Return the first of MuJoCo's headless libraries that works here, None if none does.

    MuJoCo's variable ``MUJOCO_GL`` is respected: ``egl`` or ``osmesa`` allows only that one, ``disable``
    none.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wanted in _OFF or find_spec("OpenGL") is None:
        return None
    candidates = (wanted,) if wanted in HEADLESS_LIBRARIES else HEADLESS_LIBRARIES
    return next((name for name in candidates if library_works(name)), None)


def library_works(name: str) -> bool:
    """Return whether a library draws an image on this machine; the result is cached."""
    settings = ("MUJOCO_EGL_DEVICE_ID", "PYOPENGL_PLATFORM", "CUDA_VISIBLE_DEVICES")
    facts = [_version("mujoco-core"), _version("PyOpenGL"), *(os.environ.get(s, "") for s in settings)]
    return probe_succeeds("nrp_world_mujoco.gl", name, depends_on=" ".join(facts))


@cache
def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "none"


class MujocoOptions(PhysicsOptions):
    """Options of the ``mujoco`` backend."""

    renderer: Annotated[
        Literal["auto", "raster", "realistic", "gl", "rays"],
        Field(
            description="of cameras: raster draws flat colours on the CPU, realistic light and shadows, "
            "gl flat ones by EGL or OSMesa, rays by MuJoCo's ray casts"
        ),
    ] = "auto"
