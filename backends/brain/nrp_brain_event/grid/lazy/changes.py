"""Changes of the lazy grid between two runs."""

from __future__ import annotations

from nrp_brain_event.grid.lazy.neuron import bring, watch
from nrp_brain_event.grid.lazy.records import Lazy
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.jit import jit


@jit
def set_currents(places: Array, own: Array, currents: Array) -> None:
    """Set constant currents (nA, by row)."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    lazy.clock[0].driven = 0
    for row in range(len(currents)):
        neuron = lazy.neurons[row]
        if currents[row] != grid.drive[row]:
            kind = lazy.kinds[neuron.kind]
            bring(neuron, lazy.courses, kind, grid.drive[row], grid.clock[0].step)
            grid.drive[row] = currents[row]
            if not neuron.listed:
                watch(lazy, neuron, kind, row, currents[row])
        if currents[row] != 0.0:
            lazy.clock[0].driven = 1
