"""Networks that PyNN would take and a simulator would run otherwise than they say."""

from __future__ import annotations

from nrp_core.brain.changes import ParameterChange
from nrp_core.brain.network import STDP, TSODYKS_MARKRAM, Network, Population, Projection
from nrp_core.errors import CapabilityError

from nrp_brain_pynn.simulators import Simulator


def check(network: Network, simulator: Simulator) -> None:
    """Check that a simulator can hold a network.

    Raises:
        CapabilityError: it cannot; the message names population or projection and parameter.
    """
    for population in network.populations.values():
        _check_population(population, simulator)
    for projection in network.projections:
        if projection.synapse_type == STDP:
            _check_plasticity(projection, simulator)


def check_change(network: Network, simulator: Simulator, change: ParameterChange) -> None:
    """Check that parameters of cells can be changed while a simulator runs.

    Raises:
        CapabilityError: they cannot; the message names population and parameter.
    """
    where = f"population '{change.label}' ({network.populations[change.label].cell_type})"
    shared = set(simulator.uniform.get(network.populations[change.label].cell_type, ()))
    for name in shared & change.values.keys():
        raise CapabilityError(f"{where}: {simulator.name} cannot change {name} while it runs")
    for projection in network.projections:
        decay = "tau_syn_E" if projection.receptor == "excitatory" else "tau_syn_I"
        onto = projection.post == change.label and projection.synapse_type == TSODYKS_MARKRAM
        if onto and projection.size and decay in change.values:
            raise CapabilityError(
                f"{where}: {decay} cannot change while it runs, because synapses of projection "
                f"'{projection.label}' keep it"
            )


def _check_population(population: Population, simulator: Simulator) -> None:
    where = f"population '{population.label}' ({population.cell_type})"
    for name in simulator.uniform.get(population.cell_type, ()):
        values = population.parameters[name]
        if (values != values[:1]).any():
            raise CapabilityError(
                f"{where}: in PyNN's {simulator.name} all cells of a population share {name}; "
                "make one population for each value"
            )


def _check_plasticity(projection: Projection, simulator: Simulator) -> None:
    where = f"projection '{projection.label}'"
    for name, values in projection.synapse_parameters.items():
        if (values != values[:1]).any():
            raise CapabilityError(f"{where}: in PyNN all STDP synapses of a projection share {name}")
    rule = projection.plasticity
    if rule.get("timing_dependence") != "SpikePairRule" or rule.get("weight_dependence") not in (
        "AdditiveWeightDependence", "MultiplicativeWeightDependence",
    ):  # fmt: skip
        raise CapabilityError(f"{where}: {simulator.name} has no STDP of {dict(rule)} here")
