"""The list of neurons that spiked."""

from __future__ import annotations

from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_core._support.jit import jit


@jit
def note_spike(cells: Cells, i: int) -> None:
    """Add neuron ``i`` to those that spiked in this tick."""
    cells.fired[cells.n_fired[0]] = i
    cells.n_fired[0] += 1
