"""Input from devices: events with weights that the network's shifts know nothing of.

A device is no part of the network and leaves no trace in it, so its input does not go through the 16-bit
ring buffer, where it would take headroom from the network's weights or lose its bits to them. Its weight
becomes s16.15, as the host converts any number (conductances times 1024), and joins the buffer's value
after the shift. Several events in one tick add up.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_spinnaker.cells import Grid
from nrp_brain_spinnaker.conversion import to_accum
from nrp_brain_spinnaker.kinds import Cells
from nrp_brain_spinnaker.models import CellModel
from nrp_brain_spinnaker.weights import weight_factors
from nrp_core.brain.network import RECEPTORS, IntArray
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
        self._grid, self._n = grid, cells.ids.size
        self._neuron_of = np.full(n_sources, -1, np.int64)
        self._neuron_of[cells.ids] = np.arange(self._n)
        self._factor = np.ones((2, self._n))
        """What a weight onto each neuron is multiplied by, per receptor."""
        for (first, last), model in zip(cells.populations[:, :2].tolist(), models, strict=True):
            own = slice(first, last)
            factors = weight_factors(cells, own, model)
            size = model.weight_scale * (1.0 if factors is None else factors)
            # PyNN's inhibitory currents are negative; the machine keeps sizes and subtracts them
            self._factor[:, own] = [[1.0], [1.0 if model.is_conductance_based else -1.0]] * np.atleast_2d(
                size
            )

    def convert(self, parts: Sequence[SynapticEvents]) -> IntArray:
        """Return tick, line and s16.15 value of each event, shape ``(3, n)``.

        Raises:
            CapabilityError: an event is for a source cell or too large for the machine's numbers.
        """
        receptors = [RECEPTORS.index(part.receptor) for part in parts]
        receptor = np.repeat(receptors, [len(part) for part in parts])
        neurons = self._neuron_of[np.concatenate([part.neurons for part in parts])]
        weights = np.concatenate([part.weights for part in parts])
        if neurons.min() < 0:
            raise CapabilityError("source cells only emit spikes; a device cannot act on them")
        try:
            values = to_accum(weights * self._factor[receptor, neurons], "the weight of a device")
        except ValueError as error:
            raise CapabilityError(str(error)) from None
        self.lost = self.lost or bool(((values == 0) & (weights != 0)).any())
        ticks = self._grid.first_tick_at(np.concatenate([part.times_ms for part in parts]))
        return np.stack([ticks, receptor * self._n + neurons, values])
