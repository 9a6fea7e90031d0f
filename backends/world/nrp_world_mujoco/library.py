"""MuJoCo itself; only this module imports it."""

from __future__ import annotations

import os
from ctypes.util import find_library
from typing import Any

VISUALS = 1
"""The geom group of visuals."""
COLLISIONS = 3
"""The geom group of collisions."""

_NEEDS = {"egl": "EGL", "osmesa": "OSMesa"}


def _import() -> Any:
    """Import MuJoCo, also if ``MUJOCO_GL`` names a missing library, which would make its import fail."""
    wanted = os.environ.get("MUJOCO_GL", "")
    needed = _NEEDS.get(wanted.lower().strip())
    if needed is not None and find_library(needed) is None:
        os.environ["MUJOCO_GL"] = "disable"
    try:
        import mujoco
    finally:
        if needed is not None:
            os.environ["MUJOCO_GL"] = wanted
    return mujoco


mujoco = _import()
