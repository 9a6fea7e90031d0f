"""The table of a sweep, one row per run, derived from its records."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nrp_core._support.extras import require_extra
from nrp_core._support.writing import writing
from nrp_lab.comparison.grid import ORIGINAL
from nrp_lab.sweep.axes import Value
from nrp_lab.sweep.model import SEED
from nrp_lab.sweep.plan import PlannedRun
from nrp_lab.sweep.record import Record

if TYPE_CHECKING:
    import pandas as pd

CSV, PARQUET = "results.csv", "results.parquet"
CONTROLS = "brain.controls"
"""The setting, and column, of the controls of the wiring."""
VARYING = ("wall_time_s", "elapsed_s", "attempts")
"""Columns that differ between executions of a sweep."""

Row = dict[str, Any]


def rows_of(runs: Iterable[PlannedRun], records: Mapping[str, Record]) -> list[Row]:
    """Return the rows of the finished runs in the order of the plan; all have the same columns."""
    done = [(run, records[run.task.id]) for run in runs if run.task.id in records]
    measured = list(dict.fromkeys(name for _, record in done for name in record.measured))
    return [_row(run, record, measured) for run, record in done]


def _row(run: PlannedRun, record: Record, measured: Sequence[str]) -> Row:
    varied = {key: _cell(key, value) for key, value in run.values.items()}
    own = {SEED: record.seed, "brain.backend": record.brain, "world.backend": record.world}
    return {
        "run": run.task.index,
        **varied,
        **{key: value for key, value in own.items() if key not in varied},
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
    """Return an item of a list, a mapping as it is written."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {_item(one)}" for key, one in value.items())
    return str(value)


def write_tables(folder: Path, rows: Sequence[Row]) -> list[Path]:
    """Write ``results.csv``, and with pandas and PyArrow ``results.parquet``; return the files.

    Raises:
        ExperimentError: a file cannot be written.
    """
    written = [folder / CSV]
    with writing(written[0]):
        draft = written[0].with_suffix(".draft")
        with draft.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]) if rows else ["run"], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        draft.replace(written[0])
    if rows and find_spec("pandas") and find_spec("pyarrow"):
        written.append(folder / PARQUET)
        with writing(written[1]):
            data_frame(_columns_of_one_type(rows)).to_parquet(written[1], index=False)
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


def data_frame(rows: Sequence[Row]) -> pd.DataFrame:
    """Return rows as a table of pandas.

    Raises:
        BackendLoadError: pandas is not installed.
    """
    require_extra("pandas", "nrp-lab[sweep]", "a table of a sweep in Python")
    import pandas as pd

    frame = pd.DataFrame(list(rows))
    if rows:
        for name in ("passed", "complete"):
            frame[name] = frame[name].astype("boolean")
    return frame
