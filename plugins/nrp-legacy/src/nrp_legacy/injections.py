"""Time-dependent currents that brain files inject into cells; a run adds them to the network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices.sources import ACSource, DCSource, NoisyCurrentSource, SourceSpec
from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError

_FOREVER_MS = 1e12


@dataclass(frozen=True)
class Injection:
    """A current into cells (global ids)."""

    spec: SourceSpec
    cells: IntArray


def kept_injections(sim: ModuleType) -> list[Injection]:
    """Add time-dependent currents to a simulator; return the list that collects them."""
    kept: list[Injection] = []
    sources: list[Any] = []
    state, constant, injected = sim.state, sim.state.inject, sim.state.injected

    def inject(source: Any, cells: IntArray) -> None:
        try:
            constant(source, cells)
        except CapabilityError:
            sources.append(source)
            kept.extend(Injection(spec, cells) for spec in _specs(source))

    state.inject, state.injected = inject, lambda: [*injected(), *sources]
    return kept


def let_flow(injections: tuple[Injection, ...], brain: Brain) -> None:
    """Add currents to a brain."""
    for i, injection in enumerate(injections):
        brain.add_source(injection.spec, injection.cells, name=f"brain/current/{i}")


def _specs(source: Any) -> Iterator[SourceSpec]:
    kind = type(source).__name__
    if kind == "StepCurrentSource":
        ends = np.append(source.times[1:], inf)
        for start, stop, amplitude in zip(source.times, ends, source.amplitudes, strict=True):
            yield DCSource(start=float(start), stop=float(stop), amplitude=float(amplitude))
        return
    start, stop = float(source.start), inf if source.stop >= _FOREVER_MS else float(source.stop)
    if kind == "DCSource":
        yield DCSource(start=start, stop=stop, amplitude=source.amplitude)
    elif kind == "ACSource":
        wave = {name: getattr(source, name) for name in ("amplitude", "offset", "frequency", "phase")}
        yield ACSource(start=start, stop=stop, **wave)
    elif kind == "NoisyCurrentSource":
        yield NoisyCurrentSource(start=start, stop=stop, mean=source.mean, stdev=source.stdev)
