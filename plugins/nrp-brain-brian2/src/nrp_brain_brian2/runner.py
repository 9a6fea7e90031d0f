"""``python -m nrp_core.pynn --as brian2 SCRIPT`` runs the network of a script of Brian2 in a brain backend.

Monitors of Brian2 receive the backend's recordings, so that the script draws its own figures.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import nrp_core.pynn
import numpy as np
from nrp_core.brain import (
    Brain,
    FloatArray,
    IntArray,
    Network,
    SpikeRecorder,
    SpikeRecorderPort,
    StateRecorder,
    StateRecorderPort,
)
from nrp_core.brain.backends import brains
from nrp_core.clock import nanoseconds
from nrp_core.errors import CapabilityError
from nrp_core.pynn.runners import run_as_main

from nrp_brain_brian2.dialect import Dialect


def run_script(
    path: Path, backend: str | None = None, options: Mapping[str, str] | None = None
) -> ModuleType:
    """Run a script as the main program, and return its module.

    Args:
        path: the script.
        backend: the brain backend in which its network runs, by default ``event``.
        options: options of the backend; ``resolution`` is the step of the script.

    Raises:
        NrpError: the script does something unsupported; with file and line.
        Exception: whatever else the script raises.
    """
    name = backend or "event"
    brains().provider(name)
    runs = _Runs(name, options or {})
    pynn = nrp_core.pynn.new_simulator()
    try:
        return run_as_main(path, pynn, Dialect(pynn, runs.run))
    finally:
        runs.close()


@dataclass(frozen=True, eq=False)
class _Recording:
    """What a monitor of Brian2 records: states by the names of its variables, or spikes.

    Args:
        monitor: the monitor.
        spikes: the recorder of spikes, if the monitor records them.
        states: the recorders of states.
        order: the neurons in the order of the monitor.
    """

    monitor: Any
    order: IntArray
    spikes: SpikeRecorderPort | None = None
    states: Mapping[str, StateRecorderPort] | None = None


class _Runs:
    """The runs of a script's networks in a backend.

    Args:
        backend: its name.
        options: its options, as text.
    """

    def __init__(self, backend: str, options: Mapping[str, str]) -> None:
        self._backend, self._options = backend, options
        self._brain: Brain | None = None
        self._groups: set[str] = set()
        self._after: Network | None = None
        self._recordings: list[_Recording] = []

    def close(self) -> None:
        """Release the brain."""
        if self._brain is not None:
            self._brain.close()
        self._brain = None

    def run(self, end: Any, duration_s: float) -> None:
        """Run a network of Brian2 for a time, and fill its monitors."""
        from nrp_brain_brian2.neutral import network_of
        from nrp_brain_brian2.script import built_of

        built = built_of(end)
        network = network_of(built)
        assert network.timestep_ms is not None
        names = {group.name for group in built.groups.values()}
        if self._brain is None or not names & self._groups:
            self.close()
            self._open(network)
        else:
            self._change(network)
        assert self._brain is not None
        self._groups = names
        known = [one.monitor for one in self._recordings]
        monitors = [one for one in built.network.objects if _is_monitor(one) and one not in known]
        self._recordings += [self._recorded(built, network, one) for one in monitors]
        step_ns = int(nanoseconds(network.timestep_ms))
        self._brain.run_until(self._brain.now_ns + round(duration_s * 1e9 / step_ns) * step_ns)
        for one in self._recordings:
            _fill(one, self._brain.now_ns, network.timestep_ms)
        self._set_states(built)
        self._after = network_of(built)

    def _open(self, network: Network) -> None:
        backend = brains().load(self._backend)
        own = (
            {"resolution": f"{network.timestep_ms!r} ms"}
            if "resolution" in backend.options.model_fields
            else {}
        )
        options = backend.options.model_validate({**own, **self._options})
        self._brain, self._recordings = backend.open(network, seed=0, options=options), []
        for warning in self._brain.warnings:
            print(f"note: {self._backend}: {warning.text}", file=sys.stderr)

    def _change(self, network: Network) -> None:
        """Apply the changes of parameters that the script made since the last run.

        Raises:
            CapabilityError: it changed something else.
        """
        assert self._after is not None
        assert self._brain is not None
        before = self._after
        if network.populations.keys() != before.populations.keys():
            raise CapabilityError("Brian2: groups are added between two runs of a network")
        for label, new in network.populations.items():
            old = before.populations[label]
            if new.equations != old.equations or not _same(new.initial_values, old.initial_values):
                raise CapabilityError(f"Brian2: the state or equations of '{label}' change between two runs")
            trains = zip(new.spike_times_ms, old.spike_times_ms, strict=True)
            if not all(np.array_equal(a, b) for a, b in trains):
                raise CapabilityError(f"Brian2: the spike times of '{label}' change between two runs")
            changed = {
                name: values
                for name, values in new.parameters.items()
                if not np.array_equal(values, old.parameters[name])
            }
            if changed:
                self._brain.set_parameters(network.ids_of(label), changed)
        _require_same_synapses(network, before)
        for new_one, old_one in zip(network.projections, before.projections, strict=True):
            if not np.array_equal(new_one.weight, old_one.weight):
                self._brain.set_weights(old_one.label, new_one.weight)

    def _recorded(self, built: Any, network: Network, monitor: Any) -> _Recording:
        """Start the recorders of a monitor."""
        from nrp_brain_brian2.neutral import global_ids

        assert self._brain is not None
        ids = global_ids(built, monitor.source)
        if hasattr(monitor, "record_variables") and not hasattr(monitor, "event"):
            order = ids[np.asarray(monitor.record)]
            step_ms = 1e3 * float(monitor.clock.dt)
            ports = {}
            for variable in monitor.record_variables:
                name = f"{monitor.name}/{variable}"
                port = self._brain.add_sink(StateRecorder(variable, dt=step_ms), np.unique(order), name=name)
                assert isinstance(port, StateRecorderPort)
                ports[variable] = port
            return _Recording(monitor, order, states=ports)
        port = self._brain.add_sink(SpikeRecorder(), ids, name=monitor.name)
        assert isinstance(port, SpikeRecorderPort)
        return _Recording(monitor, ids, spikes=port)

    def _set_states(self, built: Any) -> None:
        """Copy the states of the cells to Brian2's groups."""
        from nrp_brain_brian2.neutral import global_ids, unit_of

        assert self._brain is not None
        for label, group in built.groups.items():
            population = self._brain.network.populations[label]
            ids = global_ids(built, group)
            for name in population.initial_values:
                variable = group.variables.get(name)
                if variable is not None and variable.is_boolean is False and not variable.scalar:
                    values = self._brain.read_state(name, ids) * unit_of(variable.dim)[1]
                    variable.get_value()[:] = values


def _is_monitor(one: Any) -> bool:
    return hasattr(one, "source") and any(hasattr(one, name) for name in ("record_variables", "smooth_rate"))


def _require_same_synapses(network: Network, before: Network) -> None:
    """Refuse synapses that are added, or whose cells or delays change."""
    if [one.label for one in network.projections] != [one.label for one in before.projections]:
        raise CapabilityError("Brian2: synapses are added between two runs of a network")
    for new, old in zip(network.projections, before.projections, strict=True):
        for what, name in (("cells", "pre_index"), ("cells", "post_index"), ("delays", "delay_ms")):
            if not np.array_equal(getattr(new, name), getattr(old, name)):
                raise CapabilityError(f"Brian2: the {what} of '{old.label}' change between two runs")


def _same(a: Mapping[str, FloatArray], b: Mapping[str, FloatArray]) -> bool:
    return all(np.array_equal(a[name], b[name]) for name in a)


def _fill(one: _Recording, now_ns: int, step_ms: float) -> None:
    """Copy the recordings to a monitor."""
    variables = one.monitor.variables
    if one.states is not None:
        for name, port in one.states.items():
            from nrp_brain_brian2.neutral import unit_of

            times_ms, values = port.samples()
            before = nanoseconds(times_ms) < now_ns
            columns = np.searchsorted(port.neurons, one.order)
            scale = unit_of(variables[name].dim)[1]
            _resize(one.monitor, int(before.sum()))
            variables[name].set_value(values[before][:, columns] * scale)
            variables["t"].set_value(times_ms[before] / 1e3)
        return
    assert one.spikes is not None
    spikes = one.spikes.spikes()
    times_s = (spikes.times_ms - step_ms) / 1e3
    counts = np.bincount(spikes.neurons - one.order[0], minlength=len(one.order))
    if "rate" in variables:
        n = round(now_ns / 1e6 / step_ms)
        steps = np.bincount(np.round(times_s * 1e3 / step_ms).astype(int), minlength=n)
        _resize(one.monitor, n)
        variables["rate"].set_value(steps / (len(one.order) * step_ms * 1e-3))
        variables["t"].set_value(np.arange(n) * step_ms * 1e-3)
        return
    if extra := [name for name in one.monitor.record_variables if name not in ("i", "t")]:
        raise CapabilityError(f"Brian2: '{one.monitor.name}' records {extra} at spikes")
    _resize(one.monitor, len(times_s))
    variables["i"].set_value(spikes.neurons - one.order[0])
    variables["t"].set_value(times_s)
    variables["count"].set_value(counts)


def _resize(monitor: Any, n: int) -> None:
    monitor.resize(n)
    monitor.variables["N"].set_value(n)
