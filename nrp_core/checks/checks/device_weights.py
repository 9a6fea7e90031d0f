"""Mappings of transfer functions with a neuron twice or an unlikely weight."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from nrp_core.brain.network.data import Network, Population
from nrp_core.checks.network_units import too_strong
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.checks.unreachable_thresholds import too_weak
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import ParameterMapping
from nrp_core.dsl.selection import BrainRoot, Selection, select
from nrp_core.errors import NrpError
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP211, Code.NRP297, Code.NRP377)
def mappings_have_effects(static: StaticExperiment) -> Iterator[Finding]:
    """Check the mappings of all functions."""
    if static.network is not None:
        for declared in static.declared:
            yield from unlikely_mappings(declared.function, static.network)


def unlikely_mappings(function: TransferFunction, network: Network) -> Iterator[Finding]:
    """Yield findings about mappings with a neuron twice or an unlikely weight."""
    for name, mapping in function.mappings.items():
        match mapping:
            case MapSpikeSource() | MapSpikeSink():
                verb = "drives" if mapping.drives else "reads"
                for ids in _chosen(mapping, network):
                    most = int(np.unique(ids, return_counts=True)[1].max())
                    if most > 1:
                        message = f"'{name}' {verb} the same neuron {most} times: {mapping.selector!r}"
                        yield _at(mapping, Code.NRP211, message)
                        break
                if size := too_strong_source(mapping, network):
                    yield _at(mapping, Code.NRP297, f"weight of '{name}' is {size}")
                elif size := _too_weak_source(mapping, network):
                    yield _at(mapping, Code.NRP377, f"weight of '{name}' is {size}")


def too_strong_source(mapping: MapSpikeSource | MapSpikeSink, network: Network) -> str:
    """Return the weight of a source with its effect on its cells if that is implausibly large."""
    return next(filter(None, _sizes(too_strong, mapping, network)), "")


def _too_weak_source(mapping: MapSpikeSource | MapSpikeSink, network: Network) -> str:
    """Return the weight of a source if it takes none of its cells to their threshold at any rate."""
    sizes = list(_sizes(too_weak, mapping, network))
    return sizes[0] if sizes and all(sizes) else ""


def _sizes(
    judge: Callable[[float, Population], str], mapping: MapSpikeSource | MapSpikeSink, network: Network
) -> Iterator[str]:
    """Yield the judgement of the weight of a source for each population that it drives."""
    weight = mapping.options.get("weight")
    if not isinstance(mapping, MapSpikeSource) or not isinstance(weight, int | float):
        return
    if "synapse_type" in mapping.options:
        return  # it may transmit a small share of the weight
    driven = [ids for ids in _chosen(mapping, network) if ids.size]
    for label, population in network.populations.items():
        first = network.offsets[label]
        if any(((ids >= first) & (ids < first + population.size)).any() for ids in driven):
            yield "" if population.is_source else judge(abs(weight), population)


def _chosen(
    mapping: MapSpikeSource | MapSpikeSink, network: Network
) -> Iterator[np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Yield the neurons of each device of a mapping; unbindable mappings are reported elsewhere."""
    try:
        selected = select(mapping.selector, BrainRoot(network))
    except (NrpError, ValueError, TypeError):
        return
    yield from (one.ids for one in ([selected] if isinstance(selected, Selection) else selected))


def _at(mapping: ParameterMapping, code: Code, message: str) -> Finding:
    place = mapping.place
    return Finding(code, message, Level.WARNING, Path(place.path), place.line)
