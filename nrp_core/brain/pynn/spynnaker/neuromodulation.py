"""Synapses that reward or punish, as sPyNNaker's scripts make them."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

from nrp_core.brain.network.neuromodulation import MODULATORY
from nrp_core.brain.network.neuromodulation import Neuromodulation as Modulation
from nrp_core.brain.pynn.arguments import require_names
from nrp_core.brain.pynn.invalid import InvalidValueError, raising
from nrp_core.brain.pynn.simulator import Simulator

_ORDER = ("weight", "tau_c", "tau_d", "w_min", "w_max")


def neuromodulation(simulator: Simulator) -> type:
    """Return the type of synapses that reward or punish; their delay is a time step."""
    static = simulator.types["StaticSynapse"]

    def begin(self: Any, *values: Any, **given: Any) -> None:
        require_names("Neuromodulation", given, _ORDER)
        given |= zip(_ORDER, values, strict=False)
        static.__init__(self, weight=given.pop("weight", 0.0), delay=simulator.state.dt)
        with raising(InvalidValueError):
            self.neuromodulation = Modulation(**given)

    doc = "Synapses onto ``reward`` or ``punishment``: their spikes decide on changes by STDP."
    return type("Neuromodulation", (static,), {"__init__": begin, "__doc__": doc, "receptors": MODULATORY})
