"""Connectomes as matrices: a table of names by names, and the files in which cect keeps its data sets."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_formats.connectome.tables import name_id, opened_text

JUNCTIONS: Final = "Generic_GJ"
"""cect's name of the layer of gap junctions."""
_WITHOUT_SYNAPSES: Final = ("Contact", "Functional", "Peptidergic")
"""Layers of cect that are not synapses."""


@dataclass(frozen=True)
class Matrix:
    """The entries of a matrix that are not 0.

    Args:
        pre, post: ids of both cells, shape ``(n,)``.
        count: the entries, shape ``(n,)``.
        names: the names of all cells by id.
    """

    pre: IntArray
    post: IntArray
    count: FloatArray
    names: Mapping[int, str]

    @classmethod
    def of(cls, sources: Sequence[str], targets: Sequence[str], entries: FloatArray) -> Matrix:
        """Return the matrix whose rows and columns have these names."""
        names = {name_id(name): name for name in (*sources, *targets)}
        rows, columns = np.nonzero(entries)
        pre, post = (np.array([name_id(name) for name in ends], np.int64) for ends in (sources, targets))
        return cls(pre[rows], post[columns], entries[rows, columns], names)


def read_matrix(path: Path) -> Matrix | None:
    """Read a matrix in text, a row for each source; None if the table is not a matrix.

    The names of targets stand above the numbers, those of sources left of them; other rows and columns, such
    as the categories in the tables of Cook et al. (2019), are not used.

    Raises:
        NetworkError: a cell is neither empty nor a number.
    """
    with opened_text(path) as rows:
        table = [[cell.strip() for cell in row] for row in rows]
    found = _corner(table)
    if found is None:
        return None
    header, left = found
    columns = [k for k, name in enumerate(table[header]) if k > left and name]
    lines = [k for k in range(header + 1, len(table)) if len(table[k]) > left and table[k][left]]
    entries = np.zeros((len(lines), len(columns)))
    for row, line in enumerate(lines):
        for column, place in enumerate(columns):
            cell = table[line][place] if place < len(table[line]) else ""
            if cell:
                entries[row, column] = _entry(path, line, place, cell)
    return Matrix.of([table[k][left] for k in lines], [table[header][k] for k in columns], entries)


def _corner(table: Sequence[Sequence[str]]) -> tuple[int, int] | None:
    """Return the row with the names of targets and the column with the names of sources."""
    for first, row in enumerate(table):
        place = next((k for k, cell in enumerate(row) if _is_number(cell)), 0)
        left = next((k for k in range(place - 1, -1, -1) if row[k]), None)
        if left is not None:
            above = (k for k in range(first - 1, -1, -1) if any(table[k][left + 1 :]))
            header = next(above, None)
            sources = {cells[left] for cells in table[first:] if len(cells) > left}
            if header is not None and sources & set(table[header][left + 1 :]) - {""}:
                return header, left
            return None
    return None


def _is_number(cell: str) -> bool:
    try:
        return bool(cell) and bool(np.isfinite(float(cell)))
    except ValueError:
        return False


def _entry(path: Path, line: int, place: int, cell: str) -> float:
    if not _is_number(cell):
        raise NetworkError(
            f"row {line + 1}, column {place + 1} of the matrix holds '{cell}', not a number", path=path
        )
    return float(cell)


def read_cect(path: Path) -> Iterator[tuple[str, Matrix]]:
    """Yield the layers of a file of cect (``cect/cache/Cook2019HermReader.json``) with their names.

    Raises:
        NetworkError: the file is not one, or a layer is not of synapses.
    """
    try:
        data = json.loads(path.read_text("utf-8"))
        cells = [str(cell) for cell in data["nodes"]]
        layers = {str(name): np.array(rows, float) for name, rows in data["connections"].items()}
    except FileNotFoundError:
        raise NetworkError("there is no such file", path=path) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise NetworkError(
            f"is not a connectome of cect, which has 'nodes' and 'connections' ({error})", path=path
        ) from error
    for name, entries in layers.items():
        if entries.shape != (len(cells), len(cells)) or not np.isfinite(entries).all():
            raise NetworkError(
                f"the layer '{name}' is not a matrix of numbers for {len(cells)} cells", path=path
            )
        if name in _WITHOUT_SYNAPSES:
            raise NetworkError(f"the layer '{name}' does not have synapses", path=path)
        yield name, Matrix.of(cells, cells, entries)
