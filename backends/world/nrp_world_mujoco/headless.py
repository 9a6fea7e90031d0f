"""Find the OpenGL library that draws without a display on this machine."""

from __future__ import annotations

import os
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

from nrp_core._support.probe import probe_succeeds

LIBRARIES = ("egl", "osmesa")
_OFF = ("disable", "disabled", "off", "false", "0")


def library() -> str | None:
    """Return the first of MuJoCo's headless libraries that works here, None if none does.

    MuJoCo's variable ``MUJOCO_GL`` is respected: ``egl`` or ``osmesa`` allows only that one, ``disable``
    none.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wanted in _OFF or find_spec("OpenGL") is None:
        return None
    candidates = (wanted,) if wanted in LIBRARIES else LIBRARIES
    return next((name for name in candidates if works(name)), None)


def works(name: str) -> bool:
    """Return whether a library draws an image on this machine; the result is cached."""
    settings = ("MUJOCO_EGL_DEVICE_ID", "PYOPENGL_PLATFORM", "CUDA_VISIBLE_DEVICES")
    facts = [_version("mujoco-core"), _version("PyOpenGL"), *(os.environ.get(s, "") for s in settings)]
    return probe_succeeds("nrp_world_mujoco.try_gl", name, depends_on=" ".join(facts))


@cache
def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "none"
