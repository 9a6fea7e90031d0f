"""Settings of devices that are valid, but that no neuron or run can make use of: most are in a wrong unit."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, Final

from nrp_core.checks.checks.sources import CURRENTS
from nrp_core.checks.events import Read, Write
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.clock import milliseconds, seconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.devices.kinds import fixed_frequency
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.tf_lib.vision import RedShares
from nrp_core.experiment.making.doubtful_mappings import too_strong_source
from nrp_core.findings import Code, Finding, Level

_HEAVIEST: Final = 100.0
"""The largest weight, uS or nA: a hundred times the leak of the largest neurons."""
_STRONGEST_NA: Final = 50.0
_SHORTEST_MS: Final = 0.05
_SHORTEST_DELAY_MS: Final = 0.01
"""As for the cells and synapses of a brain script."""
_REMEMBERED: Final = 100.0
"""Time constants after which a spike is forgotten beyond doubt."""
_EXPECTED: Final = 1.0
"""Mean number of spikes below which most runs have none."""


@checks_function(Code.NRP297, Code.NRP248)
def settings_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for weights, time constants and delays of devices in a wrong unit."""
    end_ms = milliseconds(function.experiment.duration)
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
            elif setting == "delay" and value >= end_ms:
                message = f"'{name}' delivers no spike before {value:g} ms, and the run ends at {end_ms:g} ms"
                yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


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
    return _strong(size) if setting in CURRENTS else ""


def _forgetful(setting: str, tau_ms: float, step_ms: float) -> str:
    """Return that a rate is forgotten between two steps, which read it; empty if it is not."""
    if setting != "tau_fall" or tau_ms * _REMEMBERED >= step_ms:
        return ""
    return f"ms: a rate that is read every {step_ms:g} ms has forgotten nearly all of its spikes"


def _strong(size: float) -> str:
    return "nA; is it meant in pA?" if size > _STRONGEST_NA else ""


@checks_function(Code.NRP297)
def currents_are_plausible(function: CheckedFunction) -> Iterator[Finding]:
    """Look for currents that a body sets in a wrong unit."""
    for event in function.events:
        match event:
            case Write(node, Known(Device() | DeviceGroup()), name, True, Known(int() | float() as value)):
                message = _strong(abs(value)) if name in CURRENTS else ""
                if message:
                    message = f"'{name}' is {value:g} {message}"
                    yield function.declared.finding(Code.NRP297, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def rates_make_spikes(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sources whose only rate is too low for a spike in the run."""
    end_s = seconds(function.experiment.duration)
    rates = [one for one in function.events if isinstance(one, Write) and one.exists and one.name == "rate"]
    for event in rates:
        match event:
            case Write(node, Known(Device() as source), value=Known(int() | float() as rate)):
                mapping = function.function.mappings.get(source.parameter)
                if (
                    not isinstance(mapping, MapSpikeSource)
                    or sum(source is one for one in _owners(rates)) > 1
                ):
                    continue
                trains = 1 if mapping.kind is fixed_frequency else source.selection.size
                if 0 < rate * trains * end_s < _EXPECTED:
                    message = (
                        f"a rate of {rate:g} Hz makes hardly one spike in a run of {end_s:g} s; "
                        "is it meant in kHz?"
                    )
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def rates_are_more_than_shares(function: CheckedFunction) -> Iterator[Finding]:
    """Look for rates that are a share of an image, which is at most 1 Hz."""
    shares = {
        id(event.node) for event in function.events
        if isinstance(event, Read) and event.owner == Instance(RedShares)
    }  # fmt: skip
    rates = {id(one.node) for one in function.events if isinstance(one, Write) and one.name == "rate"}
    for node in function.declared.own:
        match node:
            case ast.Assign([target], ast.Attribute() as share) if (
                id(share) in shares and id(target) in rates
            ):
                message = (
                    f"'{ast.unparse(share)}' is a share from 0 to 1, so the rate is at most 1 Hz; "
                    "is it meant in kHz?"
                )
                yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


def _owners(events: list[Write]) -> list[Any]:
    return [one.owner.value for one in events if isinstance(one.owner, Known)]


@checks_function(Code.NRP248)
def spikes_are_injected_in_time(function: CheckedFunction) -> Iterator[Finding]:
    """Look for single spikes after the end of the run."""
    end_ms = milliseconds(function.experiment.duration)
    for node in function.declared.own:
        if not isinstance(node, ast.Call) or getattr(node.func, "attr", "") != "inject_spikes":
            continue
        given = [*node.args[1:2], *(one.value for one in node.keywords if one.arg == "times_ms")]
        latest = max((time for one in given for time in _numbers(one)), default=0.0)
        if latest >= end_ms:
            message = f"a spike at {latest:g} ms is not sent: the run ends at {end_ms:g} ms"
            yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


def _numbers(node: ast.expr) -> list[float]:
    try:
        value: Any = ast.literal_eval(node)
    except ValueError:
        return []
    values = value if isinstance(value, list | tuple) else [value]
    return [one for one in values if isinstance(one, int | float)]


@checks_function(Code.NRP352)
def parameters_are_declared_at_the_top(function: CheckedFunction) -> Iterator[Finding]:
    """Look for ``nrp.parameter`` in a body, where an experiment cannot set it."""
    for node in function.declared.own:
        match node:
            case ast.Call(ast.Attribute(ast.Name("nrp"), "parameter")):
                message = "a parameter is declared at the top of its file; here no experiment can set it"
                yield function.declared.finding(Code.NRP352, node, message, Level.WARNING)
