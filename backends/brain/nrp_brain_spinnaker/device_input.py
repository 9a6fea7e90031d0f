"""Input from devices: events whose weights were unknown when the shifts were chosen.

A device is not part of the network and must not change it, so its input does not pass through the 16-bit ring
buffer, where it would use headroom of the network's weights or lose bits. Its weight is converted to s16.15,
as the host converts any number (conductances times 1024), and is added to the buffer's value after the shift.
Several events in one tick are summed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_spinnaker.host.cells import Grid
from nrp_brain_spinnaker.host.conversion import to_accum
from nrp_brain_spinnaker.host.weights import weight_factors
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.models import CellModel
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import RECEPTORS
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import CapabilityError


class DeviceInput:
    """Converts events for the neurons of a machine.

    Args:
        cells: the neurons.
        models: the cell type of each population.
        grid: the time step.
        n_sources: number of global ids.

    Attributes:
        lost: whether a weight was below the machine's resolution.
    """

    def __init__(self, cells: Cells, models: Sequence[CellModel], grid: Grid, n_sources: int) -> None:
        self.lost = False
        self._grid, self._n_sources = grid, n_sources
        n = cells.ids.size
        self._line_of = np.full(2 * n_sources, -1, np.int64)
        self._line_of[cells.ids], self._line_of[cells.ids + n_sources] = np.arange(n), np.arange(n, 2 * n)
        factor = np.ones((2, n))
        for population, model in enumerate(models):
            own = cells.neurons(population)
            factors = weight_factors(cells, own, model)
            factor[:, own] = model.weight_scale * (1.0 if factors is None else factors)
            if not model.is_conductance_based:
                factor[1, own] *= -1  # PyNN's inhibitory currents are negative; the machine subtracts
        self._factor = factor.ravel()

    def convert(self, parts: Sequence[SynapticEvents]) -> IntArray:
        """Return tick, line and s16.15 value of each event, shape ``(3, n)``.

        Raises:
            CapabilityError: an event is for a source cell or too large for the machine's numbers.
        """
        lines = self._line_of[np.concatenate([self._places(part) for part in parts])]
        if lines.min() < 0:
            raise CapabilityError("source cells only emit spikes; a device cannot act on them")
        sizes = np.concatenate([part.weights for part in parts]) * self._factor[lines]
        entries = np.empty((3, lines.size), np.int64)
        entries[0] = self._grid.first_tick_at(np.concatenate([part.times_ms for part in parts]))
        entries[1] = lines
        try:
            entries[2] = to_accum(sizes, "the weight of a device")
        except ValueError as error:
            raise CapabilityError(str(error)) from None
        if not entries[2].all():
            self.lost = self.lost or bool(sizes[entries[2] == 0].any())
        return entries

    def _places(self, events: SynapticEvents) -> IntArray:
        """Return the indices of the targets' lines in the table."""
        inhibitory = RECEPTORS.index(events.receptor)
        return events.neurons + self._n_sources if inhibitory else events.neurons
