"""The membrane of a cell and the weights of a projection, read on request."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.running.run import Run

BINS = 24


class Looks:
    """Reads the state of a brain between two steps; reading changes nothing.

    Args:
        run: the run.
    """

    def __init__(self, run: Run) -> None:
        self._run = run

    def membrane(self, population: str, index: int) -> dict[str, Any]:
        """Return the membrane potential of a cell, mV, and the time.

        Raises:
            ExperimentError: the cell does not exist.
            CapabilityError: the brain cannot read it.
        """
        network = self._run.brain.network
        if population not in network.populations:
            hint = did_you_mean(population, network.populations)
            raise ExperimentError(f"the brain has no population '{population}'{hint}")
        size = network.populations[population].size
        if not 0 <= index < size:
            raise ExperimentError(f"the cells of '{population}' are 0 to {size - 1}, not {index}")
        neuron = int(network.offsets[population]) + index
        (v_mv,) = self._run.brain.read_state("v", [neuron]).tolist()
        return {"t_s": seconds(self._run.loop.now_ns), "v_mv": v_mv}

    def weights(self, projection: str) -> dict[str, Any]:
        """Return the current weights of a projection as a histogram.

        Returns:
            The number of synapses in each bin, the borders of the bins, and a summary: smallest, mean and
            largest weight.

        Raises:
            NetworkError: the projection does not exist.
            CapabilityError: they change, and the brain cannot read them.
        """
        weights = self._run.brain.read_synapses(projection).weight
        counts, borders = np.histogram(weights, BINS) if len(weights) else (np.zeros(0), np.zeros(0))
        summary = [float(f(weights)) for f in (np.min, np.mean, np.max)] if len(weights) else None
        return {"counts": counts.tolist(), "borders": borders.tolist(), "summary": summary}
