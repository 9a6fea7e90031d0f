"""The membranes of cells, the weights of projections and the synapses between groups, read on request."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np

from nrp_cockpit.session.groups import connections
from nrp_core.brain import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.network.data import Population

BINS = 24
MOST_CELLS = 16
"""Cells whose membranes are read at once."""


class Looks:
    """Reads the state of a brain between two steps; reading changes nothing.

    Args:
        run: the run.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._connections: dict[str, Any] | None = None

    def connections(self) -> dict[str, Any]:
        """Return the synapses between the groups of cells, see :func:`connections`."""
        if self._connections is None:
            self._connections = connections(self._run.brain.network)
        return self._connections

    def positions(self, population: str) -> dict[str, Any]:
        """Return the positions of the cells of a population, um, as base64 of 32-bit numbers ``x y z x ...``.

        Raises:
            ExperimentError: the population does not exist, or its cells have no positions.
        """
        positions_um = self._population(population).positions_um
        if positions_um is None:
            raise ExperimentError(f"the cells of '{population}' have no positions")
        return {"base64": b64encode(positions_um.astype("<f4").tobytes()).decode()}

    def _population(self, label: str) -> Population:
        populations = self._run.brain.network.populations
        if label not in populations:
            raise ExperimentError(f"the brain has no population '{label}'{did_you_mean(label, populations)}")
        return populations[label]

    def membrane(self, population: str, indices: list[int]) -> dict[str, Any]:
        """Return the membrane potentials of some cells, mV, and the time.

        Raises:
            ExperimentError: a cell does not exist, or there are more than :data:`MOST_CELLS`.
            CapabilityError: the brain cannot read them.
        """
        size = self._population(population).size
        if not 0 < len(indices) <= MOST_CELLS:
            raise ExperimentError(f"indices: 1 to {MOST_CELLS} cells, not {len(indices)}")
        for index in indices:
            if not 0 <= index < size:
                raise ExperimentError(f"the cells of '{population}' are 0 to {size - 1}, not {index}")
        neurons = int(self._run.brain.network.offsets[population]) + np.array(indices)
        v_mv = self._run.brain.read_state("v", neurons).tolist()
        return {"t_s": seconds(self._run.brain.now_ns), "v_mv": v_mv}

    def weights(self, projection: str) -> dict[str, Any]:
        """Return the current weights of a projection as a histogram.

        Returns:
            The time, the number of synapses in each bin, the borders of the bins, and a summary: smallest,
            mean and largest weight.

        Raises:
            NetworkError: the projection does not exist.
            CapabilityError: they change, and the brain cannot read them.
        """
        weights = self._run.brain.read_synapses(projection).weight
        summary = [float(f(weights)) for f in (np.min, np.mean, np.max)] if len(weights) else None
        counts, borders = _histogram(weights) if len(weights) else (np.zeros(0), np.zeros(0))
        t_s = seconds(self._run.brain.now_ns)
        return {"t_s": t_s, "counts": counts.tolist(), "borders": borders.tolist(), "summary": summary}


def _histogram(weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the number of weights in each bin and the borders; the axis of equal weights has their size."""
    least, most = float(weights.min()), float(weights.max())
    margin = (abs(least) / 2 or 0.5) if least == most else 0.0
    counts, borders = np.histogram(weights, BINS, (least - margin, most + margin))
    return counts, borders
