"""Descriptions of PyNN's simulators, without loading them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from nrp_core.brain import PARAMETERS, STATIC, STDP, TSODYKS_MARKRAM, WEIGHTS
from nrp_core.simulation import Determinism

_LEAKY: Final = frozenset({"IF_curr_exp", "IF_curr_alpha", "IF_cond_exp", "IF_cond_alpha"})
_ADAPTIVE: Final = frozenset({"EIF_cond_exp_isfa_ista", "EIF_cond_alpha_isfa_ista"})
_MEMBRANE: Final = frozenset({"v", "u", "w", "gsyn_exc", "gsyn_inh"})


@dataclass(frozen=True)
class Simulator:
    """One of PyNN's simulators.

    Args:
        name: name of the simulator, for messages.
        package: the Python package of the simulator itself.
        install: command that installs it.
        driver: module and class of the driver.
        cells, synapses, approximate, state_variables, changes, determinism: see
            :class:`~nrp_core.brain.interface.BrainCapabilities`.
        untiring: cells that cannot have Tsodyks-Markram synapses.
    """

    name: str
    package: str
    install: str
    driver: str
    cells: frozenset[str]
    synapses: frozenset[str] = frozenset({STATIC})
    approximate: frozenset[str] = frozenset()
    state_variables: frozenset[str] = _MEMBRANE
    changes: frozenset[str] = frozenset({PARAMETERS, WEIGHTS})
    determinism: Determinism = Determinism.MACHINE
    untiring: frozenset[str] = frozenset()


NEURON: Final = Simulator(
    "NEURON", "neuron", "pip install neuron", "nrp_brain_pynn.on_neuron:NeuronDriver",
    cells=_LEAKY | _ADAPTIVE | {"Izhikevich", "HH_cond_exp"},
    synapses=frozenset({STATIC, TSODYKS_MARKRAM, STDP}),
    # exponential synapses carry dt / (2 tau) too much charge
    approximate=frozenset(
        {"IF_curr_exp", "IF_cond_exp", "EIF_cond_exp_isfa_ista", "Izhikevich", "HH_cond_exp"}
    ),
    untiring=frozenset({"Izhikevich"}),
)  # fmt: skip
BRIAN2: Final = Simulator(
    "Brian2", "brian2", "pip install brian2 'numpy<2.4'", "nrp_brain_pynn.on_brian2:Brian2Driver",
    cells=_LEAKY | _ADAPTIVE | {"IF_curr_delta", "Izhikevich", "HH_cond_exp"},
    synapses=frozenset({STATIC, TSODYKS_MARKRAM}),
    approximate=frozenset({"Izhikevich", "HH_cond_exp"}),
)  # fmt: skip
_FIXED_POINT: Final = frozenset(
    {"IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp", "Izhikevich"}
)
SPINNAKER: Final = Simulator(
    "SpiNNaker", "spynnaker", "pip install sPyNNaker", "nrp_brain_pynn.on_spinnaker:SpinnakerDriver",
    cells=_FIXED_POINT, approximate=_FIXED_POINT,
    state_variables=frozenset(), changes=frozenset(), determinism=Determinism.STATISTICAL,
)  # fmt: skip

SIMULATORS: Final[Mapping[str, Simulator]] = {
    "neuron": NEURON,
    "brian2": BRIAN2,
    "spinnaker": SPINNAKER,
}
"""Simulators by the lower-case name of PyNN's module: ``pyNN.neuron`` ..."""
