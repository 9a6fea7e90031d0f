"""All numbers of a recording as arrays, topic by topic."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.recording.export import Exporter
from nrp_core.recording.layout import Role, device_group
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.reading.reader import RecordingReader
from nrp_core.recording.reading.tables import Value, number_values

_MODEL_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz")
_MODEL_UNITS = ("m", "m", "m", "", "", "", "", *3 * ("m/s",), *3 * ("rad/s",))


@dataclass
class Series:
    """A time series of several numbers.

    Args:
        name: the topic; for the poses of models, a name for each model.
        role: the role of the topic.
        columns: names of the numbers.
        about: the metadata of the topic.
        units: the unit of each column as far as its type gives one.
    """

    name: str
    role: str
    columns: tuple[str, ...]
    about: dict[str, str]
    units: dict[str, str] = field(default_factory=dict)
    _times_s: list[float] = field(default_factory=list)
    _values: list[Any] = field(default_factory=list)
    _arrays: tuple[FloatArray, FloatArray] | None = None

    def add(self, t_s: float, values: Any) -> None:
        """Add the numbers of one message."""
        self._times_s.append(t_s)
        self._values.append(values)
        self._arrays = None

    def add_named(self, t_s: float, values: Mapping[str, Value]) -> None:
        """Add the numbers of one message by their paths; new ones become further columns."""
        new = [path for path in values if path not in self.units]
        self.columns += tuple(new)
        self.units |= {path: values[path].unit or self.unit for path in new}
        self.add(t_s, [values[path].value if path in values else np.nan for path in self.columns])

    @property
    def times_s(self) -> FloatArray:
        """Times, s, shape ``(n,)``; read-only."""
        return self._read()[0]

    @property
    def values(self) -> FloatArray:
        """Values, shape ``(n, columns)``, read-only; NaN where a message does not have the number."""
        return self._read()[1]

    def _read(self) -> tuple[FloatArray, FloatArray]:
        if self._arrays is None:
            n, width = len(self._values), len(self.columns)
            if all(len(one) == width for one in self._values):
                table = np.array(self._values, float).reshape(n, width)
            else:
                table = np.full((n, width), np.nan)
                for row, one in zip(table, self._values, strict=True):
                    # one value can apply to all neurons
                    row[: None if self.role == Role.SOURCE else len(one)] = one
            self._arrays = np.array(self._times_s), table
            for array in self._arrays:
                array.flags.writeable = False
        return self._arrays

    @property
    def unit(self) -> str:
        """The unit of all columns, or the empty string if they have several or it is unknown."""
        return self.about.get("unit", "")

    def unit_of(self, column: str) -> str:
        """Return the unit of a column, or the empty string if it has none or it is unknown."""
        return self.units.get(column, self.unit)


@dataclass
class Numbers:
    """The contents of a recording except images.

    Args:
        run: the contents of ``run.json``.
        begin_s, end_s: simulated times of the first and the last message, s.
        spikes: ids within the population and times in ms, by population.
        series: all other time series, by name.
    """

    run: dict[str, Any]
    begin_s: float = 0.0
    end_s: float = 0.0
    spikes: dict[str, tuple[IntArray, FloatArray]] = field(default_factory=dict)
    series: dict[str, Series] = field(default_factory=dict)

    @classmethod
    def of(cls, recording: RecordingReader) -> Numbers:
        """Read a recording."""
        numbers, topics = cls(recording.run, begin_s=inf), recording.topics
        roles = (Role.MODELS, Role.SENSOR, Role.PUBLISHED, Role.SPIKES, Role.VOLTAGE, Role.SINK, Role.SOURCE)
        spikes: dict[str, list[Any]] = {label: [] for label in _populations(recording.run)}
        for one in recording.messages({topic.name for topic in recording.with_role(*roles)}):
            topic, t_s = topics[one.topic], seconds(one.t_ns)
            numbers.begin_s, numbers.end_s = min(numbers.begin_s, t_s), max(numbers.end_s, t_s)
            if topic.role == Role.SPIKES:
                spikes.setdefault(one.message.population, []).append(one.message)
            else:
                numbers._take(topic, t_s, one.message)
        numbers.begin_s = min(numbers.begin_s, numbers.end_s)
        for label, messages in spikes.items():
            ids = np.concatenate([np.empty(0, np.int64), *(m.ids.astype(np.int64) for m in messages)])
            times_ms = np.concatenate([np.empty(0), *(m.times_ms for m in messages)])
            numbers.spikes[label] = ids, times_ms
        return numbers

    def size_of(self, population: str) -> int:
        """Return the number of neurons of a population, as far as it is known."""
        ids, _ = self.spikes[population]
        return max(int(_populations(self.run).get(population, 0)), int(ids.max(initial=-1)) + 1)

    def with_role(self, *roles: Role) -> list[Series]:
        """Return the series of these roles."""
        return [series for series in self.series.values() if series.role in roles]

    def _take(self, topic: RecordedTopic, t_s: float, message: Any) -> None:
        if topic.role == Role.MODELS:
            for name, pose, twist in zip(message.name, message.pose, message.twist, strict=True):
                p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
                motion = (p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z)
                series = self._series(f"{topic.name}/{name}", topic, _MODEL_COLUMNS)
                series.units = dict(zip(_MODEL_COLUMNS, _MODEL_UNITS, strict=True))
                series.add(t_s, motion)
            return
        values = getattr(message, "data", None)
        if isinstance(values, np.ndarray) and topic.role == Role.SOURCE:
            series = self._series(topic.name, topic, ())
            if len(values) > len(series.columns):
                series.columns = tuple(map(str, range(len(values)))) if len(values) > 1 else ("value",)
            series.add(t_s, values)
            return
        found = {one.path: one for one in number_values(message, topic.elements)}
        if found:
            self._series(topic.name, topic, ()).add_named(t_s, found)

    def _series(self, name: str, topic: RecordedTopic, columns: tuple[str, ...]) -> Series:
        if name not in self.series:
            self.series[name] = Series(name, topic.role, columns, dict(topic.about))
        return self.series[name]


def _populations(run: dict[str, Any]) -> dict[str, int]:
    populations = dict((run.get("brain") or {}).get("populations") or {})
    return {label: int(one["size"]) for label, one in populations.items()}


def groups_of(run: dict[str, Any]) -> dict[str, dict[str, list[int]]]:
    """Return the named groups of neurons: the ids by population."""
    views = dict((run.get("brain") or {}).get("views") or {})
    return {
        name: {
            label: [i for first, last in ranges for i in range(first, last)] for label, ranges in ids.items()
        }
        for name, ids in views.items()
    }


def write_csv(recording: RecordingReader, folder: Path) -> list[Path]:
    """Write the tables into a new folder and return them; a table is named after its topic."""
    numbers = Numbers.of(recording)
    folder.mkdir()
    rows = [
        (time_ms, label, neuron)
        for label, (ids, times_ms) in numbers.spikes.items()
        for time_ms, neuron in zip(times_ms.tolist(), ids.tolist(), strict=True)
    ]
    spikes = _write(folder / "spikes.csv", ("time_ms", "population", "neuron"), sorted(rows))
    files = [spikes]
    for name, members in _with_groups(numbers.series).items():
        if len(members) == 1:
            (series,) = members.values()
            table = np.column_stack([series.times_s, series.values])
            headers = [_with_unit(column, series.unit_of(column)) for column in series.columns]
        else:
            headers, table = _joined(members)
        files.append(
            _write(folder / f"{name.strip('/').replace('/', '.')}.csv", ("time_s", *headers), table.tolist())
        )
    return files


def _with_groups(all_series: Mapping[str, Series]) -> dict[str, dict[str, Series]]:
    """Return the series by the names of tables: those of a group of devices share one, by their numbers."""
    found: dict[str, dict[str, Series]] = {}
    for name, series in all_series.items():
        pattern, number = device_group(name) or (name, "")
        found.setdefault(pattern.replace("/*/", "/"), {})[number] = series
    return found


def _joined(members: Mapping[str, Series]) -> tuple[list[str], FloatArray]:
    """Return headers and rows of a group of devices, in which each value holds until the next one."""
    times_s = np.unique(np.concatenate([series.times_s for series in members.values()]))
    headers, columns = [], [times_s]
    for number in sorted(members, key=int):
        series = members[number]
        latest = np.searchsorted(series.times_s, times_s, side="right") - 1
        rows = np.where(latest[:, None] >= 0, series.values[latest], np.nan)
        for place, column in enumerate(series.columns):
            name = number if len(series.columns) == 1 else f"{number}.{column}"
            headers.append(_with_unit(name, series.unit_of(column)))
            columns.append(rows[:, place])
    return headers, np.column_stack(columns)


def _with_unit(column: str, unit: str) -> str:
    return f"{column} [{unit}]" if unit else column


def _write(path: Path, headers: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(headers)
        writer.writerows(rows)
    return path


CSV: Final = Exporter(write_csv)
"""A folder with a table of the spikes and one for each topic that carries numbers."""
