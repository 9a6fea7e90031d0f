"""A run beside the records of an older one: CSV files of the same names, column by column."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import ExperimentError, did_you_mean

SHARE = 0.05
"""The default tolerance of a column: this share of the range of its old values."""
_TIME = re.compile(r"(^|[^a-z])(t|time)([^a-z]|$)", re.IGNORECASE)
"""The header of a column of times."""
_ROWS = "rows"


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """A column of a file in both runs, at the times of the old one that both cover.

    Args:
        name: the file and the header, ``eye.csv/angle``; ``eye.csv/rows``: the number of rows so far.
        times: the times, in the unit of the file; numbers of rows in a file without times.
        one, old: its values.
        tolerance: the largest difference that is allowed.
    """

    name: str
    times: FloatArray
    one: FloatArray
    old: FloatArray
    tolerance: float

    @property
    def _apart(self) -> FloatArray:
        return np.asarray(np.abs(self.one - self.old))

    @property
    def largest(self) -> float:
        """The largest difference."""
        return float(self._apart.max())

    @property
    def at(self) -> float:
        """The time of the largest difference."""
        return float(self.times[self._apart.argmax()])

    @property
    def rms(self) -> float:
        """Root of the mean square of the difference."""
        return float(np.sqrt(np.mean(self._apart**2)))

    @property
    def agrees(self) -> bool:
        """Whether all differences are allowed."""
        return self.largest <= self.tolerance


@dataclass(frozen=True)
class RecordsDiff:
    """The comparison of a run with old records.

    Args:
        one, old: the folders or files.
        signals: the columns that both have.
        missing: sentences about what cannot be compared.
    """

    one: Path
    old: Path
    signals: Sequence[Signal]
    missing: Sequence[str] = ()

    @classmethod
    def of(cls, one: Path, old: Path, tolerances: Mapping[str, float]) -> RecordsDiff:
        """Compare all files of old records.

        Args:
            one: the recording of a run, or the folder or file of its CSV recorders.
            old: the folder or file of the old records.
            tolerances: the allowed differences, by file or by file and header, ``eye.csv/angle``.

        Raises:
            ExperimentError: a file cannot be read, the two have no file in common, or a tolerance belongs to
                no column.
        """
        ours, theirs = _files(one), _files(old)
        if one.is_file() and old.is_file():
            ours = {old.name: one}
        common = [name for name in theirs if name in ours]
        if not common:
            known = ", ".join(ours) or "no CSV file"
            raise ExperimentError(f"no file is in both: the run has {known}, not {', '.join(theirs)}")
        signals = [each for name in common for each in _signals(name, ours[name], theirs[name], tolerances)]
        names = {*common, *(each.name for each in signals)}
        for name in tolerances:
            if name not in names:
                raise ExperimentError(f"no column '{name}' was compared{did_you_mean(name, names)}")
        missing = [f"the run has no file '{name}'" for name in theirs if name not in ours]
        missing += [
            f"'{name}' has no numbers in common"
            for name in common
            if not any(each.name.startswith(f"{name}/") for each in signals)
        ]
        return cls(one, old, signals, missing)

    @property
    def agrees(self) -> bool:
        """Whether all that was recorded is there and within its tolerance."""
        return not self.missing and all(each.agrees for each in self.signals)


def is_records(path: Path) -> bool:
    """Return whether a path is a CSV file, or a folder of them without a recording."""
    if path.is_file():
        return path.suffix.lower() == ".csv"
    return not (path / "run.json").exists() and any(path.glob("*.csv"))


def tolerances_of(texts: Iterable[str]) -> dict[str, float]:
    """Read ``FILE=VALUE`` and ``FILE/HEADER=VALUE``.

    Raises:
        ValueError: one is written differently.
    """
    found: dict[str, float] = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = -1.0
        if not name or not found[name] >= 0:
            raise ValueError(f"a margin of old records is FILE=NUMBER or FILE/HEADER=NUMBER, not '{text}'")
    return found


def _files(path: Path) -> dict[str, Path]:
    """Return the CSV files at a path by their names."""
    if path.is_file():
        return {path.name: path}
    if not path.is_dir():
        raise ExperimentError("the records do not exist", path=path)
    return {file.name: file for file in sorted(path.rglob("*.csv"))}


def _signals(name: str, ours: Path, theirs: Path, tolerances: Mapping[str, float]) -> Iterator[Signal]:
    one, old = _table(ours), _table(theirs)
    key = next((header for header in old if header in one and _TIME.search(header)), None)
    own, then = (_times(table, key) for table in (one, old))
    if not len(own) or not len(then):
        return
    shared = then[(then >= own.min()) & (then <= own.max())]
    ascends = all(len(np.unique(times)) == len(times) for times in (own, then))
    pairs = _columns(one, old, key, own, then, shared) if ascends else _counts(own, then)
    for header, times, a, b in pairs:
        both = np.isfinite(a) & np.isfinite(b)
        if both.any():
            signal = f"{name}/{header}"
            span = float(np.ptp(b[both]))
            allowed = tolerances.get(signal, tolerances.get(name, SHARE * span))
            yield Signal(signal, times[both], a[both], b[both], allowed)


_Pairs = Iterator[tuple[str, FloatArray, FloatArray, FloatArray]]


def _columns(
    one: Mapping[str, FloatArray], old: Mapping[str, FloatArray], key: str | None, own: FloatArray,
    then: FloatArray, shared: FloatArray,
) -> _Pairs:  # fmt: skip
    """Yield the values of all columns at the shared times, of the run at its nearest time."""
    at, there = np.argsort(own), np.searchsorted(np.sort(own), shared)
    before, after = (at[np.clip(there + i, 0, len(own) - 1)] for i in (-1, 0))
    nearest = np.where(np.abs(own[before] - shared) < np.abs(own[after] - shared), before, after)
    then_at = np.isin(then, shared)
    for header, values in old.items():
        if header != key and header in one:
            yield header, shared, one[header][nearest], values[then_at]


def _counts(own: FloatArray, then: FloatArray) -> _Pairs:
    """Yield the number of rows up to each old time: several rows of one time are events."""
    times = np.unique(then)
    mine, theirs = (np.searchsorted(np.sort(each), times, "right").astype(float) for each in (own, then))
    yield _ROWS, times, mine, theirs


def _times(table: Mapping[str, FloatArray], key: str | None) -> FloatArray:
    """Return the times of a table; without any, the numbers of its rows."""
    if key is not None:
        times = table[key]
        return times[np.isfinite(times)]
    return np.arange(max(map(len, table.values()), default=0), dtype=float)


def _table(path: Path) -> dict[str, FloatArray]:
    """Return the columns of a file as numbers; what is none is NaN."""
    try:
        headers, *rows = list(csv.reader(path.read_text("utf-8").splitlines())) or [[]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ExperimentError(f"this is no CSV file that can be read: {error}", path=path) from None
    columns = {
        header.strip(): np.array([_number(row[i]) if i < len(row) else np.nan for row in rows])
        for i, header in enumerate(headers)
    }
    return {header: values for header, values in columns.items() if np.isfinite(values).any()}


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan
