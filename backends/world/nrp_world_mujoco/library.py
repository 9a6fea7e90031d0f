"""MuJoCo itself; only this module imports it."""

from __future__ import annotations

import ctypes
import os
import warnings
from collections.abc import Mapping
from ctypes.util import find_library
from typing import Any

from nrp_core.scene.rigid import Pose, Quaternion

COLLISIONS = 3
"""The geom group of collisions."""

SAID: dict[str, None] = {}
"""What MuJoCo warned of beside the warnings that it counts, each once, until an engine reports it.

Without a handler MuJoCo prints them and writes a file into the current folder.
"""

_OF_SAVING = "prevent the model from being saved"
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


def note(message: str) -> None:
    """Note a warning until an engine reports it, unless it is about files that MuJoCo would write."""
    if _OF_SAVING not in message:
        SAID[" ".join(message.split())] = None


def compile_spec(spec: Any) -> Any:
    """Compile a specification and note MuJoCo's warnings.

    Raises:
        ValueError: MuJoCo refuses it.
    """
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model = spec.compile()
    for each in told:
        note(str(each.message))
    return model


def halves_of_step() -> tuple[int, int] | None:
    """Return the addresses of ``mj_step1`` and ``mj_step2`` for compiled code; None if missing."""
    try:
        library = ctypes.CDLL(mujoco._functions.__file__)  # finds what its own libraries have, too
        first, second = (ctypes.cast(each, ctypes.c_void_p) for each in (library.mj_step1, library.mj_step2))
    except (AttributeError, OSError):
        return None
    return first.value or 0, second.value or 0


def structures() -> Mapping[str, Any]:
    """Return the descriptions of MuJoCo's structures in C, by name.

    Raises:
        ImportError: the package has none.
    """
    from mujoco.introspect.structs import STRUCTS  # most scenes do not need them

    described: Mapping[str, Any] = STRUCTS
    return described


def pos_quat(pose: Pose) -> dict[str, Any]:
    """Return a pose as MuJoCo's arguments."""
    return {"pos": pose.position, "quat": scalar_first(pose.orientation)}


def scalar_first(orientation: Quaternion) -> Quaternion:
    """Return a quaternion in MuJoCo's order, w first."""
    x, y, z, w = orientation
    return w, x, y, z


mujoco = _import()
mujoco.set_mju_user_warning(note)
