"""The drives that engines move on the ground."""

from __future__ import annotations

from nrp_core.world.drives.ackermann import Ackermann
from nrp_core.world.drives.mecanum import MecanumDrive
from nrp_core.world.drives.planar_move import PlanarMove
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.scene.model import Model

PlanarDrive = WheelDrive | PlanarMove | Ackermann | MecanumDrive


def planar_drives(model: Model) -> tuple[PlanarDrive, ...]:
    """Return the drives of a model that move it on the ground."""
    return tuple(drive for drive in model.drives if isinstance(drive, PlanarDrive))
