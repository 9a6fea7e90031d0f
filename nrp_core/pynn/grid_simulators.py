"""The time steps of a PyNN simulator whose place this one takes in a script.

NEST, NEURON and Brian2 advance cells in steps of ``setup(timestep=...)``, and most of their cells fire on
these steps only. A script that was tuned in such a simulator gives other results at exact times.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from nrp_core.clock import NS_PER_MS, from_milliseconds
from nrp_core.network.data import Network

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

    def resolution(
        self, network: Network, timestep_ms: float, setup: Mapping[str, Any], options: Mapping[str, Any]
    ) -> dict[str, str]:
        """Return the option that gives a network the steps of the first simulator; report it once.

        Args:
            network: the network.
            timestep_ms: the time step of the script.
            setup: further arguments of the script's ``setup``.
            options: those that the user chose; a ``resolution`` or ``tolerance`` stays.
        """
        if not self.names:
            return {}
        if options.keys() & {"resolution", "tolerance"}:
            self.report("with the chosen options")
        elif _has_exact_times(self.names[0], network, setup):
            self.report(f"with exact spike times, as {self.names[0]} has them for these cells")
        elif from_milliseconds(timestep_ms) > _LONGEST_NS:
            self.report(f"with exact spike times; {self.names[0]} has steps of {timestep_ms:g} ms")
        else:
            self.report(f"in steps of {timestep_ms:g} ms, as {self.names[0]} does")
            return {"resolution": f"{timestep_ms!r} ms"}
        return {}

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
