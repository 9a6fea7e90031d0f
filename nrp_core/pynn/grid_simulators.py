"""The time steps of a PyNN simulator whose place this one takes in a script.

NEST, NEURON and Brian2 advance cells in steps of ``setup(timestep=...)``, and most of their cells fire on
these steps only. A script that was tuned in such a simulator gives other results at exact times.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from nrp_core.clock import NS_PER_MS, from_milliseconds
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.grid import Grid
from nrp_core.network.limits import distinct

_PRECISE = frozenset({"IF_curr_exp", "IF_curr_delta"})
"""Cells whose spikes ``pyNN.nest`` puts between its steps, unless ``spike_precision`` is ``on_grid``."""
_LONGEST_NS = NS_PER_MS
"""Longest step of a grid."""


class ReplacedSimulators:
    """The simulators that a script imports, for which ``nrp_core.pynn`` stands.

    Attributes:
        names: such as ``pyNN.nest``, in the order of their imports.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self._is_reported = False

    def adapted(
        self, network: Network, timestep_ms: float, setup: Mapping[str, Any], options: Mapping[str, Any]
    ) -> tuple[Network, dict[str, str]]:
        """Return a network as the first simulator runs it, and the option that sets its time step.

        In NEST, delays and refractory periods are whole steps even for cells that spike between steps. The
        steps are reported once.

        Args:
            network: the network.
            timestep_ms: the time step of the script.
            setup: further arguments of the script's ``setup``.
            options: those that the user chose; a ``resolution`` or ``tolerance`` stays.
        """
        if not self.names:
            return network, {}
        if options.keys() & {"resolution", "tolerance"}:
            self.report("with the chosen options")
        elif _has_exact_times(self.names[0], network, setup):
            self.report(f"with exact spike times, as {self.names[0]} has them for these cells")
            if self.names[0] == "pyNN.nest":
                return _in_steps(network, Grid(from_milliseconds(timestep_ms))), {}
        elif from_milliseconds(timestep_ms) > _LONGEST_NS:
            self.report(f"with exact spike times; {self.names[0]} has steps of {timestep_ms:g} ms")
        else:
            self.report(f"in steps of {timestep_ms:g} ms, as {self.names[0]} does")
            return network, {"resolution": f"{timestep_ms!r} ms"}
        return network, {}

    def report(self, how: str = "") -> None:
        """Print that simulators are replaced, and how the network runs, unless it has been printed."""
        if self.names and not self._is_reported:
            how = how and f", {how}; random numbers differ"
            text = (
                f"{' and '.join(self.names)} is nrp_core.pynn here, which runs the network in nrp-core{how}"
            )
            print(f"note: {text}", file=sys.stderr)
            self._is_reported = True


def _has_exact_times(simulator: str, network: Network, setup: Mapping[str, Any]) -> bool:
    """Return whether a simulator does not round the spike times of a network's cells to its steps."""
    if simulator == "pyNN.nest" and setup.get("spike_precision") != "on_grid":
        return all(one.is_source or one.cell_type in _PRECISE for one in network.populations.values())
    return simulator == "pyNN.neuron" and bool(setup.get("use_cvode"))


def _in_steps(network: Network, grid: Grid) -> Network:
    """Return a network with refractory periods rounded up, and delays rounded to the nearest, whole step."""

    def in_steps(population: Population) -> Population:
        given = population.parameters
        if "tau_refrac" not in given:
            return population
        longer_ms = grid.time_ms(grid.first_at(given["tau_refrac"]))
        return replace(population, parameters={**given, "tau_refrac": longer_ms})

    def with_steps(projection: Projection) -> Projection:
        if projection.is_continuous:
            return projection
        delay_ms = grid.time_ms(grid.delays(distinct(projection.delay_ms)))
        return replace(projection, delay_ms=np.broadcast_to(delay_ms, projection.size))

    populations = {label: in_steps(population) for label, population in network.populations.items()}
    return replace(network, populations=populations, projections=tuple(map(with_steps, network.projections)))
