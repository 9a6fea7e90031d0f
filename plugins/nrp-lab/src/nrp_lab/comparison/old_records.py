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
_MOST_TEXTS = 50
"""A column with more different texts does not have categories, but for example dates."""


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """A column of a file in both runs, at the times of the old one that both cover.

    A file with several rows of one time has events: at all times of both, ``eye.csv/rows`` is the number of
    rows so far, and a column its sum so far.

    Args:
        name: the file and the header, ``eye.csv/angle``.
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
        missing: sentences about old records that were not compared.
        beyond: sentences about parts of the run without old records.
    """

    one: Path
    old: Path
    signals: Sequence[Signal]
    missing: Sequence[str] = ()
    beyond: Sequence[str] = ()

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
            known = ", ".join(ours) or "none"
            raise ExperimentError(
                f"no CSV file is in both: the run has {known}, the old records {', '.join(theirs)}"
            )
        files = [_File.of(name, ours[name], theirs[name], tolerances) for name in common]
        signals = [signal for file in files for signal in file.signals]
        names = {*common, *(each.name for each in signals)}
        for name in tolerances:
            if name not in names:
                raise ExperimentError(f"no column '{name}' was compared{did_you_mean(name, names)}")
        missing = [f"the run has no file '{name}'" for name in theirs if name not in ours]
        beyond = [f"the old records have no file '{name}'" for name in ours if name not in theirs]
        missing += [reason for file in files for reason in file.missing]
        beyond += [reason for file in files for reason in file.beyond]
        return cls(one, old, signals, missing, beyond)

    @property
    def agrees(self) -> bool:
        """Whether all old records were compared and are within their tolerances."""
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


_Table = Mapping[str, FloatArray]


@dataclass(frozen=True)
class _File:
    """The comparison of one file; the fields are those of :class:`RecordsDiff`."""

    signals: Sequence[Signal]
    missing: Sequence[str]
    beyond: Sequence[str]

    @classmethod
    def of(cls, name: str, ours: Path, theirs: Path, tolerances: Mapping[str, float]) -> _File:
        one, old = _table(ours), _table(theirs)
        key = next((header for header in old if header in one and _TIME.search(header)), None)
        (own, one), (then, old) = (_timed(table, key) for table in (one, old))
        if not len(own) or not len(then):
            return cls((), [f"'{name}' has no rows in the run or the old records"], ())
        missing = [f"the run has no column '{name}/{each}'" for each in old if each not in one]
        beyond = [f"the old records have no column '{name}/{each}'" for each in one if each not in old]
        one, old = ({header: table[header] for header in old if header in one} for table in (one, old))
        beyond += _outside(name, "old records", own, then)
        if all(len(np.unique(times)) == len(times) for times in (own, then)):
            missing += _outside(name, "run", then, own)
            pairs = _columns(one, old, key, own, then)
        else:
            beyond += _outside(name, "run", then, own)  # the last event need not be the end of the run
            pairs = _sums(one, old, key, own, then)
        signals = []
        for header, times, a, b in pairs:
            signal, both = f"{name}/{header}", np.isfinite(a) & np.isfinite(b)
            if lost := int((~both & (np.isfinite(a) | np.isfinite(b))).sum()):
                missing.append(f"'{signal}' is a number in only one of the two at {lost} of {len(b)} times")
            if both.any():
                allowed = tolerances.get(signal, tolerances.get(name, SHARE * float(np.ptp(b[both]))))
                signals.append(Signal(signal, times[both], a[both], b[both], allowed))
            elif not lost:
                missing.append(f"'{signal}' has no numbers")
        return cls(signals, missing, beyond)


def _margin(times: FloatArray) -> float:
    """Return the usual interval of times: before their start and after their end, a value holds for it."""
    return float(np.median(np.diff(np.sort(times)))) if len(times) > 1 else 0.0


def _outside(name: str, which: str, times: FloatArray, covered: FloatArray) -> Iterator[str]:
    """Yield sentences about times before the start and after the end of records."""
    first, last, margin = covered.min(), covered.max(), _margin(covered)
    if times.min() < first - margin:
        yield f"the {which} started at {first:g} in '{name}', after {times.min():g}"
    if times.max() > last + margin:
        yield f"the {which} ended at {last:g} in '{name}', before {times.max():g}"


_Pairs = Iterator[tuple[str, FloatArray, FloatArray, FloatArray]]


def _columns(one: _Table, old: _Table, key: str | None, own: FloatArray, then: FloatArray) -> _Pairs:
    """Yield the values of all columns at the shared times, of the run at its nearest time."""
    margin = _margin(own)
    then_at = (then >= own.min() - margin) & (then <= own.max() + margin)
    shared = then[then_at]
    at, there = np.argsort(own), np.searchsorted(np.sort(own), shared)
    before, after = (at[np.clip(there + i, 0, len(own) - 1)] for i in (-1, 0))
    nearest = np.where(np.abs(own[before] - shared) < np.abs(own[after] - shared), before, after)
    for header, values in old.items():
        if header != key:
            yield header, shared, one[header][nearest], values[then_at]


def _sums(one: _Table, old: _Table, key: str | None, own: FloatArray, then: FloatArray) -> _Pairs:
    """Yield the number of rows, and the sum of each column, up to each time.

    A sum is NaN for a column of text, and while it lacks more numbers than the other.
    """
    times = np.union1d(own, then)

    def so_far(at: FloatArray, values: FloatArray) -> FloatArray:
        order = np.argsort(at)
        sums = np.concatenate([[0.0], np.cumsum(np.nan_to_num(values[order]))])
        return np.asarray(sums[np.searchsorted(at[order], times, "right")])

    yield _ROWS, times, so_far(own, np.ones(len(own))), so_far(then, np.ones(len(then)))
    for header, values in old.items():
        if header != key:
            mine, theirs = (so_far(at, ~np.isfinite(x)) for at, x in ((own, one[header]), (then, values)))
            a, b = (
                so_far(at, x) if np.isfinite(x).any() else np.full(len(times), np.nan)
                for at, x in ((own, one[header]), (then, values))
            )
            yield header, times, np.where(mine > theirs, np.nan, a), np.where(theirs > mine, np.nan, b)


def _timed(table: _Table, key: str | None) -> tuple[FloatArray, _Table]:
    """Return the times of a table, or else the numbers of its rows, and the columns where it has a time."""
    if key is None:
        return np.arange(max(map(len, table.values()), default=0), dtype=float), table
    timed = np.isfinite(table[key])
    return table[key][timed], {header: values[timed] for header, values in table.items()}


def _table(path: Path) -> _Table:
    """Return the columns of a file as numbers, without empty columns.

    A column of text, such as ``population``, becomes one for each of its texts, ``population=circuit``, with
    1 where it has this text; text in any other column is NaN.
    """
    try:
        headers, *rows = list(csv.reader(path.read_text("utf-8").splitlines())) or [[]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ExperimentError(f"the CSV file cannot be read: {error}", path=path) from None
    found: dict[str, FloatArray] = {}
    for i, header in enumerate(map(str.strip, headers)):
        texts = [row[i] if i < len(row) else "" for row in rows]
        kinds = {text for text in texts if text}
        if len(kinds) <= _MOST_TEXTS and not any(_number(kind) is not None for kind in kinds):
            found |= {
                f"{header}={kind}": np.array([text == kind for text in texts], float)
                for kind in sorted(kinds)
            }
        else:
            found[header] = np.array([*map(_number, texts)], float)
    return found


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
