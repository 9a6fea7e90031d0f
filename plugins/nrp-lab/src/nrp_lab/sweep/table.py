"""The folder of a sweep, the table of its runs, and its summary over seeds."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.utilities import replace_file, require_extra, writing
from nrp_lab.comparison.grid import ORIGINAL
from nrp_lab.comparison.metric import METRICS
from nrp_lab.sweep.model import SEED, Value
from nrp_lab.sweep.plan import Plan, PlannedRun
from nrp_lab.sweep.record import Record

if TYPE_CHECKING:
    import pandas as pd

ABOUT = "sweep.json"
RECORDINGS = "recordings"
_WORDS = {
    "experiment": "experiment",
    "settings": "settings",
    "vary": "keys that vary",
    "measure": "metrics",
    "until_ns": "end time",
    "stop_when_failed": "criteria that stop a run",
    "search": "settings of the search",
}


def claim(folder: Path, plan: Plan) -> None:
    """Make the folder of a sweep, or reuse the existing one.

    Values and designs may differ, so that a sweep can be extended.

    Raises:
        ExperimentError: it contains other files, another sweep or another search, or cannot be written.
    """
    path = folder / ABOUT
    if path.is_file():
        _require_same(read_about(folder)["identity"], plan, folder)
    elif folder.is_dir() and any(folder.iterdir()):
        raise ExperimentError("the folder contains other files; choose another (--out)", path=folder)
    else:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
    about = {
        "identity": plan.identity,
        "keys": plan.sweep.sampled,
        "design": str(plan.sweep.design),
        "runs": len(plan),
        "source": plan.experiment,
    }
    replace_file(path, json.dumps(about, indent=1) + "\n")


def read_about(folder: Path) -> dict[str, Any]:
    """Return the description in a folder.

    Raises:
        ExperimentError: the folder does not contain a sweep.
    """
    path = folder / ABOUT
    try:
        found = json.loads(path.read_text("utf-8"))
        assert isinstance(found["identity"], dict)
    except (OSError, ValueError, KeyError, TypeError, AssertionError) as error:
        raise ExperimentError(f"the folder does not contain a sweep ({ABOUT})", path=folder) from error
    return found  # type: ignore[no-any-return]


def _require_same(there: dict[str, Any], plan: Plan, folder: Path) -> None:
    here = json.loads(json.dumps(plan.identity))
    other = [words for key, words in _WORDS.items() if there.get(key) != here[key]]
    if other:
        kind = "search" if there.get("search") else "sweep"
        raise ExperimentError(
            f"the folder contains another {kind}, with different {', '.join(other)}; choose another (--out)",
            path=folder,
        )


CSV, PARQUET, UNITS = "results.csv", "results.parquet", "units.csv"
CONTROLS = "brain.controls"
"""The setting, and column, of the controls of the wiring."""
VARYING = ("wall_time_s", "elapsed_s", "attempts")
"""Columns that differ between executions of a sweep."""

Row = dict[str, Any]


def rows_of(runs: Iterable[PlannedRun], records: Mapping[str, Record]) -> list[Row]:
    """Return the rows of the finished runs in the order of the plan; all have the same columns."""
    done = [(run, records[run.task.id]) for run in runs if run.task.id in records]
    measured, drawn = (
        list(dict.fromkeys(name for _, record in done for name in getattr(record, kind)))
        for kind in ("measured", "drawn")
    )
    return [_row(run, record, measured, drawn) for run, record in done]


def _row(run: PlannedRun, record: Record, measured: Sequence[str], drawn: Sequence[str]) -> Row:
    varied = {key: _cell(key, value) for key, value in run.values.items()}
    own = {SEED: record.seed, "brain.backend": record.brain, "world.backend": record.world}
    return {
        "run": run.task.index,
        **varied,
        **{key: value for key, value in own.items() if key not in varied},
        **{name: record.drawn.get(name) for name in drawn},
        "state": record.state,
        "complete": record.complete,
        "passed": record.passed,
        "problems": " ".join(record.problems),
        **{name: record.measured.get(name) for name in measured},
        "sim_time_s": record.sim_time_s,
        "trajectory_digest": record.trajectory_digest,
        "error": record.error,
        **{name: getattr(record, name) for name in VARYING},
    }


def _cell(key: str, value: Value) -> Value:
    """Return a value as a cell: a list is one cell, and a string loses its folder."""
    if isinstance(value, list):
        items = (_item(one) for one in value)
        return " ".join(items) if value else ORIGINAL if key == CONTROLS else "none"
    return str(value) if isinstance(value, str) else value


def _item(value: object) -> str:
    """Return an item of a list, a mapping in its written form."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {_item(one)}" for key, one in value.items())
    return str(value)


def write_rows(path: Path, rows: Sequence[Row]) -> Path:
    """Write rows with the same columns as CSV, completely or not at all, and return the file.

    Raises:
        ExperimentError: it cannot be written.
    """
    with writing(path):
        draft = path.with_suffix(".draft")
        with draft.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]) if rows else ["run"], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        draft.replace(path)
    return path


def unit_of(measure: str) -> str:
    """Return the unit of a measure's metric; empty for a count or a ratio."""
    metric = measure.partition(".")[0]
    return METRICS.load(metric).unit if metric in METRICS.names() else ""


def units_of(records: Iterable[Record]) -> dict[str, str]:
    """Return the units of the measured columns that have one."""
    found: dict[str, str] = {}
    for record in records:
        for name in record.measured:
            if unit := record.units.get(name) or unit_of(name):
                found[name] = unit
    return found


def write_tables(folder: Path, rows: Sequence[Row], units: Mapping[str, str]) -> list[Path]:
    """Write the rows and units as CSV, and with pandas and PyArrow the rows as Parquet; return the files.

    Raises:
        ExperimentError: a file cannot be written.
    """
    lines = [{"column": name, "unit": unit} for name, unit in units.items()]
    written = [write_rows(folder / CSV, rows)]
    if units:
        written.append(write_rows(folder / UNITS, lines))
    if rows and find_spec("pandas") and find_spec("pyarrow"):
        written.append(folder / PARQUET)
        with writing(written[-1]):
            data_frame(_columns_of_one_type(rows), units).to_parquet(written[-1], index=False)
    return written


def _columns_of_one_type(rows: Sequence[Row]) -> list[Row]:
    """Return rows for a format whose columns have one type: a column with a text has only texts."""
    with_texts = {name for row in rows for name, value in row.items() if isinstance(value, str)}
    return [
        {
            name: str(value) if name in with_texts and value is not None else value
            for name, value in row.items()
        }
        for row in rows
    ]


def data_frame(rows: Sequence[Row], units: Mapping[str, str] | None = None) -> pd.DataFrame:
    """Return rows as a table of pandas, with units in ``attrs["units"]``: those given, or of the metrics.

    Raises:
        BackendLoadError: pandas is not installed.
    """
    require_extra("pandas", "nrp-lab[sweep]", "a table of a sweep in Python")
    import pandas as pd

    frame = pd.DataFrame(list(rows))
    if rows:
        for name in ("passed", "complete"):
            frame[name] = frame[name].astype("boolean")
    of_metrics = {name: unit for name in frame if (unit := unit_of(str(name)))}
    frame.attrs["units"] = dict(of_metrics if units is None else units)
    return frame


@dataclass(frozen=True, slots=True)
class Group:
    """The runs of one combination.

    Args:
        values: the values, without the seed and the settings drawn with it.
        rows: its runs.
    """

    values: Mapping[str, Any]
    rows: tuple[Row, ...]

    def numbers(self, name: str) -> list[float]:
        """Return the values of a measure in the runs that have it."""
        return [float(row[name]) for row in self.rows if row.get(name) is not None]

    def mean(self, name: str) -> float:
        """Return the mean of a measure; NaN if no run has it."""
        found = self.numbers(name)
        return float(np.mean(found)) if found else float("nan")

    def spread(self, name: str) -> float:
        """Return the standard deviation of a measure between seeds; 0 for one run."""
        found = self.numbers(name)
        return float(np.std(found, ddof=1)) if len(found) > 1 else 0.0

    def error(self, name: str) -> float:
        """Return the standard error of the mean."""
        return self.spread(name) / sqrt(max(len(self.numbers(name)), 1))


@dataclass(frozen=True, slots=True)
class SweepTable:
    """The finished runs of a sweep.

    Args:
        name: name of the experiment.
        keys: the varying settings that the design combines.
        measures: names of the measured numbers.
        rows: the runs.
        source: the experiment, by which it can be read again.
        settings: the overrides of every run.
    """

    name: str
    keys: tuple[str, ...]
    measures: tuple[str, ...]
    rows: tuple[Row, ...]
    source: str = ""
    settings: tuple[str, ...] = ()

    @classmethod
    def of(cls, plan: Plan, rows: Sequence[Row]) -> SweepTable:
        """Return the table of a plan."""
        settings = tuple(plan.identity["settings"].values())
        measures = _measures(rows, plan.sweep.measure)
        return cls(plan.name, tuple(plan.sweep.sampled), measures, tuple(rows), plan.experiment, settings)

    @property
    def groups(self) -> list[Group]:
        """The runs by their combination, in the order of the table."""
        found: dict[tuple[str, ...], list[Row]] = {}
        for row in self.rows:
            found.setdefault(tuple(str(row[key]) for key in self.keys), []).append(row)
        return [Group({key: rows[0][key] for key in self.keys}, tuple(rows)) for rows in found.values()]

    def measure(self, name: str | None) -> str:
        """Return the full name of a measure, by default the first.

        Raises:
            ExperimentError: it was not measured, or no run was.
        """
        if name is None and self.measures:
            return self.measures[0]
        if name not in self.measures:
            wanted = name or "a measure"
            raise ExperimentError(f"'{wanted}' was not measured{did_you_mean(wanted, self.measures)}")
        return name


def short_key(key: str, keys: Sequence[str]) -> str:
    """Return the shortest end of a dotted key that distinguishes it from the others."""
    parts = key.split(".")
    names = (".".join(parts[-length:]) for length in range(1, len(parts)))
    others = [other for other in keys if other != key]
    return next((name for name in names if not any(one.endswith(f".{name}") for one in others)), key)


def _measures(rows: Sequence[Row], metrics: Sequence[str]) -> tuple[str, ...]:
    columns = list(rows[0]) if rows else []
    return tuple(name for name in columns if name.partition(".")[0] in metrics and "." in name)


def read_table(folder: Path) -> SweepTable:
    """Return the table of a folder, from its journals.

    Raises:
        ExperimentError: the folder does not contain a sweep, or no run has ended.
    """
    about = read_about(folder)
    path = folder / CSV
    if not path.is_file():
        raise ExperimentError("no run has ended yet", path=folder)
    with path.open(encoding="utf-8", newline="") as file:
        rows = [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]
    identity = about["identity"]
    return SweepTable(
        identity["experiment"], tuple(about["keys"]), _measures(rows, identity["measure"]), tuple(rows),
        about["source"], tuple(identity["settings"].values()),
    )  # fmt: skip


def _value(text: str) -> Any:
    """Return a cell as a number, a Boolean or a string; None if it is empty."""
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    try:
        return float(text) if not text.lstrip("-").isdecimal() else int(text)
    except ValueError:
        return text
