"""Copies of a scene in MuJoCo, whose states are read and changed together."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core._support.arrays import FloatArray
from nrp_core.world.copies import Copies
from nrp_core.world.rigid.motion import BodyVelocity
from nrp_world_mujoco.drive import aim_all
from nrp_world_mujoco.motion import Floating, read_all


class MujocoCopies(Copies):
    """Copies of a scene in MuJoCo."""

    def read_motions(self, model: str, rows: FloatArray) -> None:
        motions = [engine.motions[model] for engine in self._engines]
        if all(type(motion) is Floating for motion in motions):
            read_all(motions, rows)
        else:
            super().read_motions(model, rows)

    def set_drives(self, model: str, drive: str, velocities: Sequence[BodyVelocity]) -> None:
        drives = [engine.drives[model, drive] for engine in self._engines]
        servo = drives[0].servo
        if all(one.servo == servo for one in drives):
            aim_all(drives, velocities)
        else:  # an event replaced the robot in a copy by another one
            super().set_drives(model, drive, velocities)
