"""SONATA's inputs of currents as currents of a network.

The keys ``amp``, ``delay`` and ``duration`` of a ``current_clamp`` are those of BMTK: numbers, or lists of
them for several pulses. Its module ``IClamp`` also takes currents from a table (``csv`` or ``file``) and from
a sweep in a file of the Allen Cell Types Database (``nwb`` or ``allen``).
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray, InjectedCurrent, IntArray, Network
from nrp_core.clock import nanoseconds
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.nest_models import NestParameter
from nrp_formats.sonata.node_sets import nodes_matching
from nrp_formats.sonata.nodes import Nodes

ALL: Final = "all"
"""The node set of all nodes, which no file defines."""
NA_PER_A: Final = 1e9
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
            times_ms, amplitudes, unit = _course(entry)
            for scale, cells in _by_unit(chosen, nodes, network):
                yield InjectedCurrent(cells, times_ms, (unit or scale) * amplitudes)
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


def _course(entry: Mapping[str, Any]) -> tuple[FloatArray, FloatArray, float]:
    """Return the times at which the current changes, ms, the currents from then on, and their unit in nA.

    The unit is 0 for that of the models.
    """
    kind = entry.get("input_type")
    if kind == "current_clamp":
        return *_pulses(entry), 0.0
    if not isinstance(file := entry.get("file"), str):
        raise NetworkError(f"'file' is {file!r:.60}; it must be a path")
    read, unit = (_table, 0.0) if kind in ("csv", "file") else (_sweep, NA_PER_A)
    times_ms, amplitudes = read(entry, Path(file))
    if not len(times_ms) or times_ms[0] < 0.0 or not (np.diff(times_ms) > 0.0).all():
        raise NetworkError(f"the currents in {file} must be at times that ascend from 0 ms")
    changes = np.append(True, np.diff(amplitudes) != 0.0)
    return times_ms[changes], amplitudes[changes], unit


def _table(entry: Mapping[str, Any], file: Path) -> tuple[FloatArray, FloatArray]:
    """Return times, ms, and currents in a table, whose columns are separated by a space by default."""
    names = entry.get("timestamps_column", "timestamps"), entry.get("amplitudes_column", "amps")
    try:
        with file.open(encoding="utf-8", newline="") as lines:
            rows = [*csv.DictReader(lines, delimiter=entry.get("separator", " "), skipinitialspace=True)]
    except (OSError, TypeError, UnicodeDecodeError, csv.Error) as error:
        raise NetworkError(f"{file} cannot be read as a table: {error}") from None
    for name in names:
        if not rows or name not in rows[0]:
            known = [*rows[0]] if rows else []
            raise NetworkError(
                f"{file} has no column '{name}'{did_you_mean(str(name), known)}; 'separator', "
                "'timestamps_column' and 'amplitudes_column' say how the table is written"
            )
    try:
        times_ms, amplitudes = (np.array([float(row[name]) for row in rows]) for name in names)
    except (TypeError, ValueError) as error:
        raise NetworkError(f"{file} has a value that is not a number: {error}") from None
    return times_ms, amplitudes


def _sweep(entry: Mapping[str, Any], file: Path) -> tuple[FloatArray, FloatArray]:
    """Return times, ms, and currents, A, of the stimulus of a sweep; its settings are those of BMTK.

    ``downsample`` is an interval, s; ``sweep_window`` the first and the last time, ms, to which ``delay``
    is added.
    """
    import h5py  # which takes long

    settings = {"downsample": 0.0, "sweep_window": [0.0, np.inf], "delay": 0.0, **entry}
    interval_s, delay_ms = (_numbers(settings, key)[0] for key in ("downsample", "delay"))
    window_ms = _numbers(settings, "sweep_window")
    if len(window_ms) != 2:
        raise NetworkError(f"'sweep_window' is {entry['sweep_window']!r:.60}; it must be two times in ms")
    wanted = str(entry.get("sweep_id"))
    name = f"Sweep_{int(float(wanted))}" if wanted.replace(".", "", 1).isdigit() else wanted
    try:
        with h5py.File(file, "r") as opened:
            series = opened[f"epochs/{name}/stimulus/timeseries"]
            rate_hz = float(series["starting_time"].attrs["rate"])
            amplitudes = np.array(series["data"], float)
    except (OSError, KeyError, ValueError) as error:
        raise NetworkError(f"{file} has no stimulus of the sweep {wanted!r}: {error}") from None
    stride = max(1, round(interval_s * rate_hz))
    times_ms, amplitudes = np.arange(len(amplitudes))[::stride] * (1e3 / rate_hz), amplitudes[::stride]
    begin_ns, end_ns = nanoseconds(window_ms)
    inside = (nanoseconds(times_ms) >= begin_ns) & (nanoseconds(times_ms) <= end_ns)
    return times_ms[inside] + delay_ms, amplitudes[inside]


def _pulses(entry: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
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
    """Yield the factor from the unit of a model's currents to nA, and the cells, without sources."""
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
