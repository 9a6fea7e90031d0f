"""The folder of a sweep as the page shows it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from nrp_lab.sweep.record import JOURNALS, read_records
from nrp_lab.sweep.report import remarks, report_data
from nrp_lab.sweep.table import ABOUT, CSV, Row, SweepTable, read_about, read_table, short_key

from nrp_core.errors import ExperimentError, did_you_mean

MOST_GROUPS, MOST_RUNS = 400, 200
"""The largest numbers of combinations and of runs in one message."""
KINDS = {"curve": 1, "heat": 2, "parallel": 1}
"""The figures, with the settings that must vary for each."""
_SEED = "seed"
"""The setting that runs of equal other settings differ in."""
_LAST = ("trajectory_digest", "wall_time_s", "attempts")
"""Columns of the table that the page leaves out."""
_CHOICES: dict[str, Callable[[Row], bool]] = {
    "all": lambda _: True,
    "passed": lambda row: row["passed"] is True,
    "not passed": lambda row: row["passed"] is False,
    "failed": lambda row: row["error"] is not None,
}


class Sheet:
    """A sweep in its folder, which may grow meanwhile.

    Args:
        folder: its folder.

    Raises:
        ExperimentError: the folder does not contain a sweep.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._seen: object = None
        self._about: dict[str, Any] = {}
        self._table: SweepTable | None = None
        self._ended = self._failed = 0
        self.update()

    def update(self) -> bool:
        """Read the files again if they have changed; return whether they have."""
        files = [self.folder / ABOUT, self.folder / CSV, *sorted(self.folder.glob(JOURNALS))]
        seen = [(file.name, file.stat().st_mtime_ns, file.stat().st_size) for file in files if file.is_file()]
        if seen == self._seen:
            return False
        self._about = read_about(self.folder)
        self._table = read_table(self.folder) if (self.folder / CSV).is_file() else None
        records = read_records(self.folder).values()
        self._ended = max(len(records), len(self._rows))
        self._failed = sum(record.failed for record in records)
        self._seen = seen
        return True

    @property
    def _rows(self) -> tuple[Row, ...]:
        return self._table.rows if self._table else ()

    def data(self) -> dict[str, Any]:
        """Return all but the single runs. The table exists when the command has ended, at least once."""
        about, table = self._about, self._table
        total = max(int(about["runs"]), len(self._rows))
        keys = tuple(about["keys"])
        found = {
            "name": about["identity"]["experiment"],
            "folder": str(self.folder),
            "design": about["design"],
            "runs": total,
            "ended": min(self._ended, total),
            "failed": self._failed,
            "passed": sum(row["passed"] is True for row in self._rows),
            "not_passed": sum(row["passed"] is False for row in self._rows),
            "in_table": len(self._rows),
            "keys": [{"key": key, "short": short_key(key, keys)} for key in keys],
            "kinds": [kind for kind, least in KINDS.items() if len(keys) >= least],
            "measures": [], "groups": [], "more_groups": 0, "remarks": [],
        }  # fmt: skip
        if table is not None:
            summary = report_data(table, self.folder, None)
            groups = summary["groups"]
            found |= {
                "measures": list(table.measures),
                "groups": groups[:MOST_GROUPS],
                "more_groups": max(0, len(groups) - MOST_GROUPS),
                "remarks": remarks(table),
            }
        return found

    def runs(
        self, first: int = 0, sort: str = "run", *, descending: bool = False, choice: str = "all"
    ) -> dict[str, Any]:
        """Return some rows of the table.

        Args:
            first: the number of rows to skip.
            sort: the column to sort by; runs without a value come last.
            descending: whether the largest comes first.
            choice: ``all``, ``passed``, ``not passed`` or ``failed`` (ended by an error).

        Raises:
            ExperimentError: the column or choice is unknown.
        """
        if choice not in _CHOICES:
            raise ExperimentError(f"there is no choice '{choice}'{did_you_mean(choice, _CHOICES)}")
        rows = [row for row in self._rows if _CHOICES[choice](row)]
        columns = self._columns()
        if sort not in columns:
            raise ExperimentError(f"there is no column '{sort}'{did_you_mean(sort, columns)}")
        shown = _sorted(rows, sort, descending)[max(first, 0) :][:MOST_RUNS]
        return {
            "columns": columns,
            "total": len(rows),
            "rows": [
                {"cells": [row[name] for name in columns], "command": self._command(row)} for row in shown
            ],
        }

    def figure(self, measure: str | None = None, kind: str | None = None) -> dict[str, Any]:
        """Return a figure as SVG.

        Args:
            measure: the measure to show; by default the first.
            kind: ``curve``, ``heat`` or ``parallel``; by default chosen by the varied settings.

        Raises:
            ExperimentError: the table has no values to draw.
        """
        if self._table is None:
            raise ExperimentError("no run has ended yet", path=self.folder)
        from nrp_lab.sweep.figures import draw

        with TemporaryDirectory() as folder:
            path = Path(folder) / "figure.svg"
            draw(self._table, path, measure, kind)
            return {"svg": path.read_text("utf-8")}

    def _columns(self) -> list[str]:
        """Return the columns in which any run has a value."""
        valued = {name for row in self._rows for name, value in row.items() if value is not None}
        names = [name for name in self._rows[0] if name in valued] if self._rows else []
        return [name for name in names if name not in _LAST] or ["run"]

    def _command(self, row: Row) -> list[str] | None:
        """Return the words of the command that opens a run; None if its folder names no experiment."""
        if "source" not in self._about:
            return None
        identity = self._about["identity"]
        varied = {key: row[key] for key in identity["vary"] if row.get(key) is not None}
        settings = [*identity["settings"].values(), *(f"{key}={_written(varied[key])}" for key in varied)]
        if _SEED not in varied and row.get(_SEED) is not None:
            settings.append(f"{_SEED}={row[_SEED]}")
        return ["nrp", "cockpit", self._about["source"], *(word for one in settings for word in ("-s", one))]


def _sorted(rows: Sequence[Row], column: str, descending: bool) -> list[Row]:
    """Return rows by a column: numbers before texts, and those without a value last."""
    valued = [row for row in rows if row[column] is not None]
    valued.sort(key=lambda row: _rank(row[column]), reverse=descending)
    return valued + [row for row in rows if row[column] is None]


def _rank(value: Any) -> tuple[bool, float, str]:
    is_text = isinstance(value, str)
    return is_text, 0.0 if is_text else float(value), str(value)


def _written(value: Any) -> str:
    """Return a cell in the form of ``-s key=``; a cell of several numbers was a list."""
    parts = str(value).split()
    if len(parts) > 1 and all(_is_number(part) for part in parts):
        return f"[{', '.join(parts)}]"
    return str(value)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
