"""SONATA's inputs of the type ``current_clamp`` as currents of a network.

The keys ``amp``, ``delay`` and ``duration`` are those of BMTK: numbers, or lists of them for several pulses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray, InjectedCurrent, IntArray, Network
from nrp_core.brain.network.nest_models import NestParameter
from nrp_core.errors import NetworkError, did_you_mean
from nrp_formats.sonata.node_sets import nodes_matching
from nrp_formats.sonata.nodes import Nodes

ALL: Final = "all"
"""The node set of all nodes, which no file defines."""
_OFFSET: Final = NestParameter("i_offset", 1.0, 0.0)


def read_clamps(
    path: Path, clamps: Mapping[str, Mapping[str, Any]], nodes: Mapping[str, Nodes], network: Network
) -> Iterator[InjectedCurrent]:
    """Yield the currents of clamps.

    Args:
        path: the configuration.
        clamps: its inputs of this type, by name.
        nodes: all populations of nodes.
        network: the network, with their node sets as views.

    Raises:
        NetworkError: a key is missing or wrong, or the nodes do not exist.
    """
    for name, entry in clamps.items():
        try:
            chosen = _targets(name, entry, nodes, network)
            times_ms, amplitudes = _course(entry)
            for scale, cells in _by_unit(chosen, nodes, network):
                yield InjectedCurrent(cells, times_ms, scale * amplitudes)
        except NetworkError as error:
            raise NetworkError(f"the input '{name}': {error.args[0]}", path=path) from None


def _targets(name: str, entry: Mapping[str, Any], nodes: Mapping[str, Nodes], network: Network) -> IntArray:
    """Return the global ids of the clamped nodes."""
    wanted = entry.get("node_set")
    if wanted == ALL:
        return np.arange(network.size)
    if isinstance(wanted, Mapping):
        return nodes_matching(name, wanted, nodes, {label: network.neurons(label) for label in nodes})
    if not isinstance(wanted, str):
        raise NetworkError(f"'node_set' is {wanted!r:.60}; it must be a name or attributes of nodes")
    known = [*network.views, *network.populations]
    if wanted not in known:
        raise NetworkError(f"there is no node set '{wanted}'{did_you_mean(wanted, known)}")
    return network.neurons(wanted)


def _course(entry: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Return the times at which the current changes, ms, and the currents from then on."""
    amplitudes, durations_ms = _numbers(entry, "amp"), _numbers(entry, "duration")
    delays_ms = _numbers(entry, "delay") if "delay" in entry else np.zeros(1)
    if not len(amplitudes) == len(durations_ms) == len(delays_ms):
        raise NetworkError("'amp', 'delay' and 'duration' must have the same number of values")
    if (delays_ms < 0.0).any() or (durations_ms < 0.0).any() or (np.diff(delays_ms) <= 0.0).any():
        raise NetworkError("'delay' must ascend from 0 ms, and no 'duration' be negative")
    course: dict[float, float] = {}
    following = np.append(delays_ms[1:], np.inf)
    for amplitude, start, duration, end in zip(amplitudes, delays_ms, durations_ms, following, strict=True):
        course[start] = amplitude
        if start + duration < end:  # the next pulse replaces this one
            course[start + duration] = 0.0
    return np.array([*course]), np.array([*course.values()])


def _numbers(entry: Mapping[str, Any], key: str) -> FloatArray:
    given = entry.get(key)
    values = given if isinstance(given, list) else [given]
    if not all(isinstance(one, int | float) and not isinstance(one, bool) for one in values):
        raise NetworkError(f"'{key}' is {given!r:.60}; it must be a number or a list of numbers")
    return np.array(values, float)


def _by_unit(
    chosen: IntArray, nodes: Mapping[str, Nodes], network: Network
) -> Iterator[tuple[float, IntArray]]:
    """Yield the factor from the unit of a model's currents to nA, and the cells; sources are left out."""
    found: dict[float, list[IntArray]] = {}
    for part in nodes.values():
        for (model, _), population in zip(part.models, part.populations, strict=True):
            mine = np.intersect1d(chosen, network.ids_of(population.label))
            if len(mine) and not population.is_source:
                found.setdefault(model.parameters.get("i_offset", _OFFSET).scale, []).append(mine)
    if not found:
        raise NetworkError("its node set contains no cell that a current can drive")
    for scale, parts in found.items():
        yield scale, np.concatenate(parts)
