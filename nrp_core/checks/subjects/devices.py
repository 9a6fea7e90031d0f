"""Devices with values in another unit, and populations that cannot fire."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Final

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices.sinks import SinkPort, StateRecorderPort
from nrp_core.checks.examined import (
    ExaminedExperiment,
    ExaminedFunction,
    checks_function,
    checks_functions,
)
from nrp_core.checks.network_units import DELAY, TIME, Range, outside, too_strong
from nrp_core.checks.synaptic_effects import too_weak
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import Adapter
from nrp_core.dsl.selection import Selection
from nrp_core.findings import Code, Finding
from nrp_core.network.data import Network, Population

CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
"""Settings of sources that are in nA."""
_HEAVIEST: Final = 100.0
"""The largest weight, uS or nA: a hundred times the leak of the largest neurons."""
_CURRENT: Final = Range(1e-6, 50.0, "nA", "A", "pA")  # a thousandth of a pA moves no cell
_RANGES: Final = {
    **dict.fromkeys(CURRENTS, _CURRENT),
    **dict.fromkeys(("delay", "dt"), DELAY._replace(high=inf)),
}
"""Of the settings of devices; those of time constants are that of cells."""


@checks_functions
def check_populations(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report populations without any input that makes them fire, if a function or others use their spikes."""
    experiment, network = examined.experiment, examined.network
    # functions of the platform change cells by the brain's variables, and interventions drive them
    changes = experiment.compatibility or experiment.brain.interventions
    if network is None or changes or not examined.function_topics.is_complete:
        return
    for label, why in examined.summary.unreached.items():
        devices = [one for one in examined.devices if has_cells(network, label, one.neurons)]
        sinks = [one for one in devices if isinstance(one, SinkPort)]
        reads_spikes = not all(isinstance(one, StateRecorderPort) for one in sinks)
        leads_on = bool(examined.devices) and any(pre == label for pre, _ in examined.summary.joined)
        if len(sinks) == len(devices) and (reads_spikes or leads_on):
            then = "a function reads its spikes" if reads_spikes else "its synapses transmit none"
            message = f"no cell of the population '{label}' can fire, and {then}: {why}"
            yield examined.warning(Code.NRP377, message, "brain", "model")


def has_cells(network: Network, label: str, neurons: IntArray) -> bool:
    """Return whether cells of a population are among some neurons."""
    first = network.offsets[label]
    return bool(((neurons >= first) & (neurons < first + network.populations[label].size)).any())


@checks_function
def check_devices(function: ExaminedFunction) -> Iterator[Finding]:
    """Report devices with a repeated neuron, and weights, currents and times in a wrong unit."""
    for name, mapping in function.function.mappings.items():
        if isinstance(mapping, MapSpikeSource | MapSpikeSink):
            for code, message in _wrong_device(name, mapping, function.adapters.get(name)):
                yield function.finding(code, message, parameter=name)


def _wrong_device(
    name: str, mapping: MapSpikeSource | MapSpikeSink, adapter: Adapter | None
) -> Iterator[tuple[Code, str]]:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    selections = [one.selection for one in devices if isinstance(one, Device) and one.selection.size]
    most = max((int(np.unique(one.ids, return_counts=True)[1].max()) for one in selections), default=0)
    if most > 1:
        verb = "drives" if mapping.drives else "reads"
        yield Code.NRP211, f"'{name}' {verb} the same neuron {most} times: {mapping.selector!r}"
    weight = mapping.options.get("weight")
    # a law of synapses may transmit a small share of the weight
    if mapping.drives and isinstance(weight, int | float) and "synapse_type" not in mapping.options:
        yield from _wrong_weight(name, abs(weight), _driven(selections))
    for setting, value in mapping.options.items():
        plausible = TIME._replace(high=inf) if setting.startswith("tau_") else _RANGES.get(setting)
        if isinstance(value, int | float) and plausible is not None:
            found = outside(f"{setting} of '{name}'", np.array([value], float), plausible)
            yield from ((Code.NRP297, message) for message in found)


def _driven(selections: list[Selection]) -> list[Population]:
    """Return the populations with cells that are selected."""
    found: dict[str, Population] = {}
    for ids, network in ((one.ids, one.network) for one in selections if one.network is not None):
        found |= {name: one for name, one in network.populations.items() if has_cells(network, name, ids)}
    return list(found.values())


def _wrong_weight(name: str, weight: float, driven: list[Population]) -> Iterator[tuple[Code, str]]:
    """Yield that a weight is implausibly large for some cells, or takes no cells to their threshold."""
    cells = [one for one in driven if not one.is_source]
    strong, weak = ([judge(weight, one) for one in cells] for judge in (too_strong, too_weak))
    if any(strong):
        yield Code.NRP297, f"weight of '{name}' is {next(filter(None, strong))}"
    elif weight > _HEAVIEST:
        yield Code.NRP297, f"weight of '{name}' is {weight:g} uS or nA; is it meant in nS or pA?"
    elif weak and all(weak) and len(cells) == len(driven):
        yield Code.NRP377, f"weight of '{name}' is {weak[0]}"
