"""Spikes of virtual nodes, from files of a simulation's inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.brain.files.hdf5 import attribute, column, group, groups, reading
from nrp_core.errors import NetworkError

Trains = Mapping[int, FloatArray]
"""Spike times, ms, by node id."""

_MILLISECONDS: Final = ("ms", "milliseconds", "millisecond")


def read_spikes(paths: Iterable[Path]) -> dict[str, Trains]:
    """Return the spikes of virtual nodes by the name of their population.

    Raises:
        NetworkError: a file cannot be read, or its times are not in ms.
    """
    found: dict[str, dict[int, FloatArray]] = {}
    for path in paths:
        with reading(path) as file:
            for name, part in groups(group(file, "spikes")):
                _require_ms(part, name)
                times, ids = column(part, "timestamps", float), column(part, "node_ids", np.int64)
                if len(times) != len(ids):
                    raise NetworkError(f"spikes of '{name}': {len(times)} timestamps, {len(ids)} node_ids")
                order = np.lexsort((times, ids))
                numbers, starts = np.unique(ids[order], return_index=True)
                trains = np.split(times[order], starts[1:])
                found.setdefault(name, {}).update(zip(numbers.tolist(), trains, strict=True))
    return dict(found)


def _require_ms(part: Any, name: str) -> None:
    times = part.get("timestamps")
    if times is None or "units" not in times.attrs:
        return
    unit = attribute(times, "units", str)
    if unit not in _MILLISECONDS:
        raise NetworkError(f"the timestamps of '{name}' are in '{unit}'; only 'ms' is read")
