"""Tables in CSV, Feather and Parquet, read some rows at a time: their ids of cells and signs of synapses."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError

_LARGEST = 2**63 - 1


def ids_of(path: Path, column: str, values: Any) -> tuple[IntArray, dict[int, str]]:
    """Return a column of ids, shape ``(n,)``, and the names of the cells by id if it has names.

    Raises:
        NetworkError: a value is missing, or neither a whole number (a float has lost digits of a long id)
            nor a name.
    """
    import pyarrow.types as kinds

    if kinds.is_dictionary(values.type):
        values = values.dictionary_decode()
    is_text = kinds.is_string(values.type) or kinds.is_large_string(values.type)
    if not (is_text or kinds.is_integer(values.type)):
        raise NetworkError(
            f"the column '{column}' holds {values.type} values; ids are whole numbers, since a float loses "
            "their last digits, or names",
            path=path,
        )
    if values.null_count:
        raise NetworkError(f"the column '{column}' lacks {values.null_count} ids", path=path)
    if not is_text:
        written = values.to_numpy(zero_copy_only=False)
        if written.dtype.kind == "u" and written.size and written.max() > _LARGEST:
            raise NetworkError(
                f"the column '{column}' holds the id {written.max()}; ids go up to 2^63 - 1", path=path
            )
        numbers: IntArray = written.astype(np.int64)
        if numbers.size and numbers.min() < 0:
            count = int((numbers < 0).sum())
            raise NetworkError(
                f"the column '{column}' holds {numbers.min()} for {count} ids, which stands for no neuron: "
                "leave these rows out",
                path=path,
            )
        return numbers, {}
    names = [str(text).strip() for text in values.to_pylist()]
    if "" in names:
        raise NetworkError(f"the column '{column}' lacks {names.count('')} names", path=path)
    known = {name: _number(name) for name in dict.fromkeys(names)}
    return np.array([known[name] for name in names], np.int64), {
        number: name for name, number in known.items()
    }


def _number(name: str) -> int:
    """Return the same number for a name in all tables; equal ones are as improbable as in 63 random bits."""
    return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "big") >> 1


EXCITATORY: Final = frozenset(
    {
        "ach",
        "acetylcholine",
        "da",
        "dopamine",
        "ser",
        "serotonin",
        "oct",
        "octopamine",
        "histamine",
        "tyramine",
    }
)
INHIBITORY: Final = frozenset({"gaba", "glut", "glutamate"})


def sign_of(transmitter: str | None) -> int:
    """Return 1 or -1, or 0 for an unknown transmitter."""
    name = (transmitter or "").strip().lower()
    return 1 if name in EXCITATORY else -1 if name in INHIBITORY else 0


INSTALL: Final = "pip install 'nrp-formats[connectome]'"
SUFFIXES: Final = (".csv", ".feather", ".parquet")
_BLOCK: Final = 1 << 22
"""Bytes of a CSV file, of which some forty parts are read ahead, and bytes hashed, at a time."""

Columns = Mapping[str, Any]
"""Arrow arrays by the name of their column."""


def column_names(path: Path) -> list[str]:
    """Return the names of the columns of a table.

    Raises:
        NetworkError: the file is missing or damaged, or of another kind; or pyarrow is not installed.
    """
    with _opened(path) as (kind, source):
        return list(source.schema_arrow.names if kind == "parquet" else source.schema.names)


def read_rows(path: Path, names: Sequence[str]) -> Iterator[Columns]:
    """Yield these columns of a table, some rows at a time.

    Raises:
        NetworkError: as for :func:`column_names`; or a column is repeated, or a value does not fit it.
    """
    known = column_names(path)
    for name in names:
        if known.count(name) > 1:
            raise NetworkError(f"the column '{name}' is there twice", path=path)
    with _opened(path, names) as (kind, source):
        if kind == "parquet":
            parts = source.iter_batches(columns=list(names))
        elif kind == "feather":
            parts = (source.get_batch(k) for k in range(source.num_record_batches))
        else:
            parts = source
        for part in parts:
            yield {name: part.column(name) for name in names}


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    state = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            state.update(block)
    return state.hexdigest()


def chosen_column(path: Path, wanted: str, candidates: Sequence[str], names: Sequence[str]) -> str:
    """Return the first of some columns that a table has.

    Raises:
        NetworkError: the table has none of them.
    """
    found = next((name for name in candidates if name in names), None)
    if found is None:
        raise NetworkError(
            f"there is no column for {wanted}: {', '.join(filter(None, candidates))}; the table has the "
            f"columns {', '.join(names)}",
            path=path,
        )
    return found


def _delimiter(path: Path) -> str:
    """Return the separator of columns in the first line of a CSV file: a comma if it has one."""
    with path.open("rb") as file:
        head = file.readline(_BLOCK).decode("utf-8", "replace")
    return next((one for one in ",\t;|" if one in head), ",")


@contextmanager
def _opened(path: Path, names: Sequence[str] = ()) -> Iterator[tuple[str, Any]]:
    """Open a table, to read only some columns if it has names."""
    try:
        import pyarrow as pa
        from pyarrow import csv, ipc, parquet
    except ImportError as error:
        raise NetworkError(f"connectomes need pyarrow ({error}); try: {INSTALL}", path=path) from error
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise NetworkError(f"is not a table; it must end in {', '.join(SUFFIXES)}", path=path)
    try:
        if suffix == ".parquet":
            with parquet.ParquetFile(path) as file:
                yield "parquet", file
        elif suffix == ".feather":
            with pa.OSFile(str(path)) as source:
                schema = ipc.open_file(source).schema
                options = ipc.IpcReadOptions(included_fields=[schema.get_field_index(name) for name in names])
                yield "feather", ipc.open_file(source, options=options)
        else:
            with csv.open_csv(
                path,
                csv.ReadOptions(block_size=_BLOCK),
                csv.ParseOptions(delimiter=_delimiter(path)),
                csv.ConvertOptions(include_columns=names),
            ) as rows:
                yield "csv", rows
    except FileNotFoundError:
        raise NetworkError("there is no such file", path=path) from None
    except (pa.ArrowException, OSError) as error:
        raise NetworkError(f"the table cannot be read: {error}", path=path) from error
