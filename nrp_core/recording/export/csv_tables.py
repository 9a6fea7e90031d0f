"""A recording as tables: a row for each spike and each message; headers have units, ``linear.x [m/s]``."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.recording.export.numbers import Numbers, file_name
from nrp_core.recording.reading.recording import Recording


def write_csv(recording: Recording, folder: Path) -> list[Path]:
    """Write the tables into a new folder and return them."""
    numbers = Numbers.of(recording)
    folder.mkdir()
    rows = [
        (time_ms, label, neuron)
        for label, (ids, times_ms) in numbers.spikes.items()
        for time_ms, neuron in zip(times_ms.tolist(), ids.tolist(), strict=True)
    ]
    spikes = _write(folder / "spikes.csv", ("time_ms", "population", "neuron"), sorted(rows))
    files = [spikes]
    for name, series in numbers.series.items():
        table = np.column_stack([series.times_s, series.values]).tolist()
        headers = [_with_unit(column, series.unit_of(column)) for column in series.columns]
        files.append(_write(folder / f"{file_name(name)}.csv", ("time_s", *headers), table))
    return files


def _with_unit(column: str, unit: str) -> str:
    return f"{column} [{unit}]" if unit else column


def _write(path: Path, headers: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(headers)
        writer.writerows(rows)
    return path
