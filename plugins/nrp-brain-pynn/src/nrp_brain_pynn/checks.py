"""Checks for networks that PyNN accepts and a simulator would run incorrectly."""

from __future__ import annotations

from nrp_core.brain import STDP, TSODYKS_MARKRAM, Network, ParameterChange, Population, Projection
from nrp_core.errors import CapabilityError

from nrp_brain_pynn.simulators import Simulator


def check(network: Network, simulator: Simulator) -> None:
    """Check that a simulator can simulate a network.

    Raises:
        CapabilityError: it cannot; the message names projection and parameter.
    """
    for projection in network.projections:
        if projection.synapse_type == STDP:
            _check_plasticity(projection, simulator)
        if projection.synapse_type == TSODYKS_MARKRAM:
            _check_target(projection, network.populations[projection.post], simulator)


def check_change(network: Network, change: ParameterChange) -> None:
    """Check that parameters of cells can be changed while a brain runs.

    Raises:
        CapabilityError: they cannot; the message names population and parameter.
    """
    where = f"population '{change.label}' ({network.populations[change.label].cell_type})"
    for projection in network.projections:
        decay = "tau_syn_E" if projection.receptor == "excitatory" else "tau_syn_I"
        onto = projection.post == change.label and projection.synapse_type == TSODYKS_MARKRAM
        if onto and projection.size and decay in change.values:
            raise CapabilityError(
                f"{where}: {decay} cannot change while it runs, because synapses of projection "
                f"'{projection.label}' keep it"
            )


def _check_target(projection: Projection, post: Population, simulator: Simulator) -> None:
    if post.cell_type in simulator.untiring and projection.size:
        raise CapabilityError(
            f"projection '{projection.label}': PyNN's {simulator.name} does not support Tsodyks-Markram "
            f"synapses on cells whose voltage jumps by the weight, such as {post.cell_type} ('{post.label}')"
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
