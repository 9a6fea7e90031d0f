"""The data of the compiled code."""

from __future__ import annotations

from typing import NamedTuple

from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import Ring
from nrp_brain_spinnaker.synapses.laws import Stores


class Machine(NamedTuple):
    """The arrays of a network on the machine."""

    cells: Cells
    ring: Ring
    stores: Stores
