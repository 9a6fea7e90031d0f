"""Settings of devices that are valid, but that no neuron or run can make use of: most are in a wrong unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from nrp_core.checks.events import Write
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.clock import milliseconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.experiment.making.doubtful_mappings import too_strong_source
from nrp_core.findings import Code, Finding, Level

CURRENTS: Final = ("amplitude", "offset", "mean", "stdev")
"""Settings of sources that are in nA."""
_WEAKEST_NA: Final = 1e-6
"""A thousandth of a pA, which moves no cell."""
_HEAVIEST: Final = 100.0
"""The largest weight, uS or nA: a hundred times the leak of the largest neurons."""
_STRONGEST_NA: Final = 50.0
_SHORTEST_MS: Final = 0.05
_SHORTEST_DELAY_MS: Final = 0.01
"""As for the cells and synapses of a brain script."""
_REMEMBERED: Final = 100.0
"""Time constants after which a spike is forgotten beyond doubt."""


@checks_function(Code.NRP297)
def settings_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for weights, time constants and delays of devices in a wrong unit."""
    step_ms = milliseconds(function.experiment.timestep)
    for name, mapping in function.function.mappings.items():
        if not isinstance(mapping, MapSpikeSource | MapSpikeSink):
            continue
        node = function.declared.nodes.get(name)
        for setting, value in mapping.options.items():
            if not isinstance(value, int | float):
                continue
            if setting == "weight" and _is_beyond_leak(mapping, function.adapters.get(name)):
                continue  # reported with its effect on the cells
            message = _implausible(setting, abs(value)) or _forgetful(setting, value, step_ms)
            if message:
                message = f"{setting} of '{name}' is {value:g} {message}"
                yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)


def _is_beyond_leak(mapping: MapSpikeSource | MapSpikeSink, adapter: object) -> bool:
    devices = list(adapter) if isinstance(adapter, DeviceGroup) else [adapter]
    networks = [one.selection.network for one in devices if isinstance(one, Device)]
    return any(network is not None and too_strong_source(mapping, network) != "" for network in networks[:1])


def _implausible(setting: str, size: float) -> str:
    """Return the unit of a setting and the one that is probably meant; empty for a plausible value."""
    if setting == "weight" and size > _HEAVIEST:
        return "uS or nA; is it meant in nS or pA?"
    shortest_ms = _SHORTEST_DELAY_MS if setting in ("delay", "dt") else _SHORTEST_MS
    if (setting.startswith("tau_") or setting in ("delay", "dt")) and 0 < size < shortest_ms:
        return "ms; is it meant in s?"
    return _implausible_current(size) if setting in CURRENTS else ""


def _forgetful(setting: str, tau_ms: float, step_ms: float) -> str:
    """Return that a rate is forgotten between two steps, which read it; empty if it is not."""
    if setting != "tau_fall" or tau_ms * _REMEMBERED >= step_ms:
        return ""
    return f"ms: a rate that is read every {step_ms:g} ms has forgotten nearly all of its spikes"


def _implausible_current(size: float) -> str:
    if size > _STRONGEST_NA:
        return "nA; is it meant in pA?"
    return "nA; is it meant in A?" if 0.0 < size < _WEAKEST_NA else ""


@checks_function(Code.NRP297)
def currents_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that a body sets in a wrong unit."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, Known(int() | float() as value)):
                message = _implausible_current(abs(value)) if name in CURRENTS else ""
                if message:
                    message = f"'{name}' is {value:g} {message}"
                    yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)
