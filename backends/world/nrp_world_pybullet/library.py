"""PyBullet itself; the one place that imports it."""

from __future__ import annotations

from typing import Any

from nrp_core._support.quiet import quiet


def _import() -> Any:
    """Import PyBullet without its greeting."""
    with quiet():
        import pybullet
    return pybullet


bullet = _import()
