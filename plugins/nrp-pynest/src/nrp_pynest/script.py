"""``python -m nrp_core.pynn --as nest SCRIPT`` runs the network of a script of PyNEST in a brain backend."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

import nrp_core.pynn
from nrp_core.brain import IntArray, SourcePort
from nrp_core.brain.backends import brains
from nrp_core.clock import from_milliseconds, milliseconds, nanoseconds
from nrp_core.errors import NetworkError
from nrp_core.pynn.runners import run_as_main
from nrp_pynest.api import nest_module
from nrp_pynest.built import BuiltBrain
from nrp_pynest.currents import Current, driven
from nrp_pynest.dialect import Dialect
from nrp_pynest.kernel import random_of
from nrp_pynest.models import CELLS, CURRENTS, PRECISE, RECORDERS, SPIKE_RECORDERS, STATES
from nrp_pynest.running import RunningKernel

DEFAULT_BACKEND = "event"


def run_script(
    path: Path, backend: str | None = None, options: Mapping[str, str] | None = None
) -> ModuleType:
    """Run a script as the main program, and return its module.

    Args:
        path: the script.
        backend: the brain backend in which its network runs, by default ``event``.
        options: options of the backend; one that is called ``resolution`` is by default NEST's.

    Raises:
        NrpError: the script does something impossible; with file and line.
        Exception: whatever else the script raises.
    """
    name = backend or DEFAULT_BACKEND
    brains().provider(name)
    kernel = ScriptKernel(name, options or {})
    nest = nest_module(kernel)
    pynn = nrp_core.pynn.new_simulator()
    try:
        return run_as_main(path, pynn, Dialect(pynn, nest), refusing=nest)
    finally:
        kernel.close()


_SentCurrent: TypeAlias = tuple[SourcePort, Current, float]
"""A current that drives cells, and the delay after which it does, ms."""


class ScriptKernel(RunningKernel):
    """The nodes and synapses of a script, and the brain that the first ``Simulate`` opens.

    Args:
        backend: the name of the brain backend.
        options: its options, as text.
    """

    def __init__(self, backend: str, options: Mapping[str, str]) -> None:
        self._backend, self._options = backend, options
        self._ports: dict[int, list[_SentCurrent]] = {}
        self._ran_ns = 0
        super().__init__(random_of(0), BuiltBrain())

    def clear(self) -> None:
        self.close()
        super().clear()

    def close(self) -> None:
        """Release the brain."""
        if self._built.is_running:
            self._built.brain.close()
        self._built = BuiltBrain()
        self._ran_ns = 0
        self._ports.clear()
        self._since_ms: dict[int, float] = {}
        self.forget()

    def now(self) -> dict[str, float]:
        now_ms = milliseconds(self._ran_ns)
        return {"time": now_ms, "biological_time": now_ms}

    def set_status(self, values: Mapping[str, Any]) -> None:
        if "resolution" in values and self.groups:
            raise NetworkError("nest: the resolution is set before nodes are created")
        super().set_status(values)

    # -- what may be created while the network runs

    def before_nodes(self, base: str) -> None:
        if self._ran_ns and base not in RECORDERS:
            raise NetworkError(
                f"nest.Create: a '{base}' is created at {milliseconds(self._ran_ns):g} ms, while the network "
                "runs; create it before the first Simulate, or call ResetKernel"
            )

    def before_synapses(self, pre: IntArray, post: IntArray) -> None:
        ends = [self.group_of(int(nodes[0])).base for nodes in (pre, post) if len(nodes)]
        if self._ran_ns and not any(base in RECORDERS for base in ends):
            raise NetworkError(
                f"nest.Connect: synapses are created at {milliseconds(self._ran_ns):g} ms, while the network "
                "runs; create them before the first Simulate, or call ResetKernel"
            )
        if self._built.is_running:
            self.forget()

    # -- running

    def simulate(self, t_ms: float) -> None:
        step_ns = from_milliseconds(float(self.status["resolution"]))
        lasts_ns = round(from_milliseconds(t_ms) / step_ns) * step_ns
        if not self._built.is_running:
            self._open()
        self._record()
        self._ran_ns += lasts_ns
        self._built.brain.run_until(self._ran_ns)
        for group in (one for one in self.groups if one.base in RECORDERS):
            for node in range(group.first, group.first + group.size):
                values = super().node_values(node)
                if values["record_to"] == "ascii":
                    write_events(self._file_of(node, values), values["events"])

    def _open(self) -> None:
        made = self._converted()
        backend = brains().load(self._backend)
        own: dict[str, str] = {}
        if self._is_precise():
            pass
        elif "resolution" in backend.options.model_fields:
            own["resolution"] = f"{float(self.status['resolution'])!r} ms"
        elif "timestep" in backend.options.model_fields:
            own["timestep"] = f"{float(self.status['resolution'])!r} ms"
        options = backend.options.model_validate({**own, **self._options})
        brain = backend.open(made.network, seed=int(self.status["rng_seed"]) % 2**31, options=options)
        for warning in brain.warnings:
            print(f"note: {self._backend}: {warning.text}", file=sys.stderr)
        self._built.open(brain, lambda: self._ran_ns)
        for group in self.groups:
            if group.base in CURRENTS:
                self._drive(range(group.first, group.first + group.size))

    def _is_precise(self) -> bool:
        """Return whether the cells spike between grid points.

        Raises:
            NetworkError: only some do.
        """
        kinds = {group.base in PRECISE: group.model for group in self.groups if group.base in CELLS}
        if len(kinds) > 1:
            raise NetworkError(
                f"nest: '{kinds[True]}' spikes between grid points and '{kinds[False]}' at them; here all "
                "cells of a network do one or the other"
            )
        return True in kinds

    def _record(self) -> None:
        """Let recorders record what they are connected to."""
        made = self._converted()
        known = self._built.brain.capabilities.state_variables
        for variable, ids, interval_ms in self.measured(made):
            if variable not in known:
                name = next((name for name, (own, _) in STATES.items() if own == variable), variable)
                raise NetworkError(f"nest: the brain backend '{self._backend}' cannot record '{name}'")
            self._built.record_state(variable, ids, interval_ms)
        for group in self.groups:
            for node in range(group.first, group.first + group.size) if group.base in SPIKE_RECORDERS else ():
                if len(ids := self.recorded_ids(made, node)):
                    self._built.record(ids)

    def _file_of(self, node: int, values: Mapping[str, Any]) -> Path:
        """Return the file of a recorder that records to one."""
        stem = f"{self.status['data_prefix']}{values['label'] or values['model']}-{node}-0.dat"
        return Path(self.status["data_path"]) / stem

    def node_values(self, node: int) -> dict[str, Any]:
        values = super().node_values(node)
        if values.get("record_to") == "ascii":
            values |= {"filenames": (str(self._file_of(node, values)),), "events": {}}
        return values

    # -- currents

    def set_nodes(self, nodes: Sequence[int], values: Any) -> None:
        super().set_nodes(nodes, values)
        if self._built.is_running:
            self._drive([node for node in nodes if self.group_of(node).base in CURRENTS])

    def _drive(self, generators: Iterable[int]) -> None:
        """Let generators of currents drive their cells with their present settings.

        What they sent before arrives until a step and the delay of each synapse have passed.
        """
        now_ms, step_ns = milliseconds(self._ran_ns), from_milliseconds(self.status["resolution"])
        for node in map(int, generators):
            before = self._ports.pop(node, [])
            found = self._ports[node] = []
            for port, spec, delay_ms in before:
                self._built.brain.remove(port)
                until_ns = self._ran_ns + step_ns + from_milliseconds(delay_ms)
                start_ns, stop_ns = nanoseconds([spec.start, spec.stop]).tolist()
                if self._ran_ns < stop_ns and start_ns < until_ns:
                    shorter = replace(spec, stop=milliseconds(min(stop_ns, until_ns)))
                    found.append(self._source(shorter, port.neurons, delay_ms, port.name))
            for k, (spec, cells, delay_ms) in enumerate(driven(self._converted(), node, now_ms)):
                found.append(self._source(spec, cells, delay_ms, f"nest/current/{node}/{k}"))

    def _source(self, spec: Current, cells: IntArray, delay_ms: float, name: str) -> _SentCurrent:
        return self._built.brain.add_source(spec, cells, name=name), spec, delay_ms


def write_events(path: Path, events: Mapping[str, Any]) -> None:
    """Write what a recorder recorded to a file, in the format of NEST's recording backend ``ascii``."""
    others = [name for name in events if name not in ("senders", "times")]
    names = "\t".join(["sender", "time_ms", *others])
    header = f"# NEST version: nrp-core\n# RecordingBackendASCII version: 2\n{names}"
    columns = [events.get(name, ()) for name in ("senders", "times", *others)]
    np.savetxt(
        path,
        np.column_stack(columns),
        ["%d", *["%.6f"] * (1 + len(others))],
        "\t",
        header=header,
        comments="",
    )
