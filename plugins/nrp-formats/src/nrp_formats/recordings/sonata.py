"""A recording in SONATA (Dai et al. 2020, PLoS Comput Biol 16:e1007696; developer guide, version 0.1)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.clock import seconds
from nrp_core.recording import Numbers, Recording, Role, Series, groups_of
from nrp_core.utilities import new_file

_MAGIC, _VERSION = 0x0A7A, (0, 1)
_SORTING = h5py.enum_dtype({"none": 0, "by_id": 1, "by_time": 2}, basetype="u1")
_BY_TIME = 2
DEVICES = "devices"
"""Name of the population of devices in the report."""


def write_sonata(recording: Recording, folder: Path) -> list[Path]:
    """Write spikes, node sets and the report of devices, if any; return the files."""
    numbers = Numbers.of(recording)
    folder.mkdir()
    files = [
        _write_spikes(numbers, folder / "spikes.h5"),
        _write_node_sets(numbers, folder / "node_sets.json"),
    ]
    devices = numbers.with_role(Role.SINK)
    if devices:
        files.append(_write_report(numbers, devices, folder / "devices.h5"))
    return files


def _write_spikes(numbers: Numbers, path: Path) -> Path:
    with new_file(path) as file:
        _mark(file)
        for label, (ids, times_ms) in numbers.spikes.items():
            group = file.create_group(f"spikes/{label}")
            group.attrs.create("sorting", _BY_TIME, dtype=_SORTING)
            order = np.lexsort((ids, times_ms))
            group["timestamps"] = times_ms[order]
            group["timestamps"].attrs["units"] = "ms"
            group["node_ids"] = ids[order].astype(np.uint64)
    return path


def _write_node_sets(numbers: Numbers, path: Path) -> Path:
    """Write the named groups; a group that spans populations has a part in each."""
    sets: dict[str, Any] = {label: {"population": label} for label in numbers.spikes}
    for name, parts in groups_of(numbers.run).items():
        own = {
            (name if len(parts) == 1 else f"{name}.{label}"): {"population": label, "node_id": ids}
            for label, ids in parts.items()
        }
        sets |= {key: value for key, value in own.items() if key not in sets}
        if len(parts) > 1 and name not in sets:
            sets[name] = list(own)
    path.write_text(json.dumps(sets, indent=2) + "\n")
    return path


def _write_report(numbers: Numbers, devices: list[Series], path: Path) -> Path:
    """Write the values of devices at every step: a report with a node for each."""
    step_ms = seconds(int(dict(numbers.run.get("settings") or {}).get("timestep") or 20_000_000)) * 1e3
    count = round(numbers.end_s * 1e3 / step_ms) + 1
    times_ms: FloatArray = np.arange(count, dtype=float) * step_ms
    with new_file(path) as file:
        _mark(file)
        group = file.create_group(f"report/{DEVICES}")
        values = np.column_stack([_values_at(series, times_ms) for series in devices])
        group["data"] = values.astype(np.float32)
        group["data"].attrs["units"] = devices[0].unit
        mapping = group.create_group("mapping")
        nodes = len(devices)
        mapping["node_ids"] = np.arange(nodes, dtype=np.uint64)
        mapping["node_ids"].attrs.create("sorted", 1, dtype=np.uint8)
        mapping["index_pointers"] = np.arange(nodes + 1, dtype=np.uint64)
        mapping["element_ids"] = np.zeros(nodes, np.uint32)
        mapping["element_pos"] = np.zeros(nodes, np.float32)
        mapping["time"] = np.array([0.0, count * step_ms, step_ms])
        mapping["time"].attrs["units"] = "ms"
        mapping["names"] = [series.about.get("device", series.name) for series in devices]
    return path


def _values_at(series: Series, times_ms: FloatArray) -> FloatArray:
    """Return the values at some times from the recorded changes."""
    at = np.searchsorted(series.times_s * 1e3, times_ms + 1e-6, side="right") - 1
    return np.where(at >= 0, series.values[np.maximum(at, 0), 0], np.nan)


def _mark(file: Any) -> None:
    file.attrs.create("magic", _MAGIC, dtype=np.uint32)
    file.attrs.create("version", _VERSION, dtype=np.uint32)
