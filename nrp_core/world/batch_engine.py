"""What is done to copies of a scene at once, each in an engine of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid import BodyVelocity


class BatchEngine:
    """Copies of a scene; each gets and gives, bit for bit, what it would alone.

    A backend may override the methods, if there is a faster way than one engine after the other.

    Args:
        engines: an engine for each copy, all of the same class.
    """

    def __init__(self, engines: Sequence[Any]) -> None:
        self._engines = engines

    def read_motions(self, model: str, rows: FloatArray) -> None:
        """Write pose and velocity of a model in every copy, shape ``(copies, 13)``."""
        for engine, row in zip(self._engines, rows, strict=True):
            engine.read_motion(model, row)

    def set_drives(self, model: str, drive: str, velocities: Sequence[BodyVelocity]) -> None:
        """Set the target velocity of a drive in every copy."""
        for engine, velocity in zip(self._engines, velocities, strict=True):
            engine.set_drive(model, drive, velocity)


def batch_engine_of(engines: Sequence[Any]) -> BatchEngine:
    """Return copies of a scene as their backend does several at once."""
    batch_engine: BatchEngine = engines[0].batch_engine(engines)
    return batch_engine
