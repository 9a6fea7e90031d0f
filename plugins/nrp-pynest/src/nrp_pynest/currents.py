"""Generators of currents as current sources of a brain, or as currents of a network."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import TypeAlias

import numpy as np

from nrp_core.brain import ACSource, DCSource, InjectedCurrent, IntArray, NoisyCurrentSource
from nrp_core.errors import NetworkError
from nrp_pynest.models import FOREVER_MS
from nrp_pynest.network import Conversion, Link

Current: TypeAlias = ACSource | DCSource | NoisyCurrentSource


def injected(made: Conversion) -> Iterator[InjectedCurrent]:
    """Yield the currents of a network whose experiment runs it.

    Raises:
        NetworkError: a current varies without end.
    """
    nodes = {
        link.source.first + place: link for link in made.current_links for place in set(link.pre.tolist())
    }
    for node, link in nodes.items():
        for spec, cells, _ in driven(made, node):
            if not isinstance(spec, DCSource):
                raise NetworkError(
                    f"nest: '{link.source.model}' cannot be in the brain of an experiment, where a transfer "
                    "function gives such a current; valid: dc_generator, step_current_generator"
                )
            amplitude = float(np.asarray(spec.amplitude))
            times, values = ([spec.start], [amplitude]) if spec.stop == inf else (
                [spec.start, spec.stop], [amplitude, 0.0]
            )  # fmt: skip
            yield InjectedCurrent(cells, np.array(times), np.array(values))


def driven(made: Conversion, node: int, since_ms: float = 0.0) -> Iterator[tuple[Current, IntArray, float]]:
    """Yield the currents that a generator sends, each with its cells (global ids) and delay, ms.

    A current begins a step of NEST after its settings at the earliest, and arrives after the delay of its
    synapse.

    Args:
        made: the network.
        node: the generator.
        since_ms: when it was given its settings.
    """
    step_ms = made.network.timestep_ms or 0.1
    for link in made.current_links:
        chosen = np.flatnonzero(link.pre + link.source.first == node)
        kinds = {(float(link.values["weight"][k]), float(link.values["delay"][k])) for k in chosen}
        for weight, delay_ms in sorted(kinds):
            alike = (link.values["weight"] == weight) & (link.values["delay"] == delay_ms)
            same = chosen[alike[chosen]]
            cells = np.array([made.ids[link.target.first + int(link.post[k])] for k in same])
            for spec in _specs(link, node - link.source.first, weight * 1e-3, delay_ms, step_ms, since_ms):
                yield spec, cells, delay_ms


def _specs(
    link: Link, place: int, scale: float, delay_ms: float, step_ms: float, since_ms: float
) -> Iterator[Current]:
    group = link.source
    own = {
        name: group.values[name][place] if name in group.values else value
        for name, value in group.defaults.items()
    }
    shift_ms = float(own["origin"]) + delay_ms
    start = max(float(own["start"]) + float(own["origin"]), since_ms + step_ms) + delay_ms
    stop = inf if own["stop"] >= FOREVER_MS else float(own["stop"]) + shift_ms
    if "amplitude_times" in own:
        times = np.append(np.asarray(own["amplitude_times"], float) + delay_ms, inf)
        for first, last, amplitude in zip(
            times, times[1:], np.atleast_1d(own["amplitude_values"]), strict=False
        ):
            if max(first, start) < min(last, stop):
                yield DCSource(max(first, start), min(last, stop), amplitude * scale)
    elif "std" in own:
        yield NoisyCurrentSource(start, stop, float(own["dt"]), own["mean"] * scale, own["std"] * abs(scale))
    elif "frequency" in own:
        # NEST counts the phase from the origin and takes the value at the start of a step, a port from the
        # start of the current and at the middle of a step
        turned = own["phase"] + 360.0 * own["frequency"] * 1e-3 * (start - shift_ms - step_ms / 2)
        yield ACSource(
            start, stop, step_ms, own["amplitude"] * scale, own["offset"] * scale, own["frequency"], turned
        )
    else:
        yield DCSource(start, stop, own["amplitude"] * scale)
