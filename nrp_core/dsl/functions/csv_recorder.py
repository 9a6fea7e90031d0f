"""Rows that transfer functions record, and the CSV files made of them."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path, PurePosixPath
from typing import Any

from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.parameters.adapter import Adapter

RESET = "RESET"
RESET_HEADER = "Simulation_reset"


class CSVRecorder(Adapter):
    """The rows of one parameter.

    Args:
        filename: name of the file.
        headers: headers of its columns.
        erase_on_reset: whether a reset erases the rows; otherwise the next row is marked ``RESET``.

    Attributes:
        rows: the cells of each row, as text.
    """

    __slots__ = ("_erase_on_reset", "_is_first_after_reset", "filename", "headers", "rows")

    def __init__(self, filename: str, headers: Sequence[str], *, erase_on_reset: bool = False) -> None:
        self.filename, self.headers = filename, tuple(headers)
        self.rows: list[list[str]] = []
        self._erase_on_reset = erase_on_reset
        self._is_first_after_reset = False

    def record_entry(self, *values: object) -> None:
        """Add a row; its cells are the values as ``str`` shows them."""
        mark = [RESET] if self._is_first_after_reset else []
        self.rows.append([*map(str, values), *mark])
        self._is_first_after_reset = False

    def reset(self) -> None:
        if self._erase_on_reset:
            self.rows.clear()
        else:
            self._is_first_after_reset = bool(self.rows)

    def save(self) -> Any:
        return list(self.rows), self._is_first_after_reset

    def restore(self, saved: Any) -> None:
        rows, self._is_first_after_reset = saved
        self.rows[:] = rows

    def shown(self) -> str:
        return f"{len(self.rows)} rows"


def write_csv(functions: Iterable[TransferFunction], folder: Path) -> list[Path]:
    """Write the rows of all recorders of transfer functions into a folder; return its files.

    Raises:
        OSError: a file cannot be written.
    """
    found = [
        one for function in functions for one in function.adapters.values() if isinstance(one, CSVRecorder)
    ]
    texts: dict[str, str] = {}
    for recorder in found:
        name = inside(recorder.filename)
        texts[name] = texts.get(name, "") + _text(recorder, with_headers=name not in texts)
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8", newline="")
    return [folder / name for name in texts]


def _text(recorder: CSVRecorder, *, with_headers: bool) -> str:
    marked = any(row[-1:] == [RESET] for row in recorder.rows)
    headers = [*recorder.headers, RESET_HEADER] if marked else recorder.headers
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(
        [headers, *recorder.rows] if with_headers else recorder.rows
    )
    return text.getvalue()


def inside(filename: str) -> str:
    """Return the name of a recorder's file below the folder of the run, which it never leaves."""
    parts = [part for part in PurePosixPath(filename.replace("\\", "/")).parts if part not in ("/", "..")]
    return "/".join(parts) or "records.csv"
