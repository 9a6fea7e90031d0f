"""Tables in CSV, Feather and Parquet, read some rows at a time: columns of numbers and of texts."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_core.utilities import join_with_limit

INSTALL: Final = "pip install 'nrp-formats[connectome]'"
TEXT_SUFFIXES: Final = (".csv", ".tsv", ".txt")
SUFFIXES: Final = (*TEXT_SUFFIXES, ".feather", ".parquet")
_MAX_NAMED: Final = 30
_LARGEST: Final = 2**63 - 1
_NO_NUMBERS: Final = frozenset({"", "NA", "N/A", "NULL", "null", "None"})
_BLOCK: Final = 1 << 22
"""Bytes that are hashed, or read from a text file by pyarrow, at a time."""
_ROWS: Final = 1 << 17
"""Rows of a text file at a time."""


@dataclass(frozen=True)
class TextColumn:
    """Some rows of a column of texts.

    Args:
        texts: the different texts, without blanks around them; an empty text stands for an empty cell.
        codes: the number of the text of each row, shape ``(n,)``.
    """

    texts: Sequence[str]
    codes: IntArray

    @classmethod
    def of(cls, values: Sequence[str]) -> TextColumn:
        """Return the column with the text of each row."""
        known: dict[str, int] = {}
        codes = np.fromiter((known.setdefault(one, len(known)) for one in values), np.int64, len(values))
        return cls([text.strip() for text in known], codes)


Column = TextColumn | np.ma.MaskedArray
"""Some rows of a column: texts, or numbers of which empty cells are masked."""
Columns = Mapping[str, Column]


def column_texts(column: Column) -> list[str]:
    """Return the text of each row of a column."""
    if isinstance(column, TextColumn):
        return [column.texts[code] for code in column.codes.tolist()]
    return ["" if value is None else str(value) for value in column.tolist()]


def column_numbers(path: Path, name: str, column: Column) -> FloatArray:
    """Return the number of each row of a column, NaN for an empty cell.

    Raises:
        NetworkError: a text is not a finite number.
    """
    if not isinstance(column, TextColumn):
        numbers: FloatArray = np.ma.filled(column.astype(float), np.nan)
        return numbers
    found = [_float_of(text) for text in column.texts]
    if None in found:
        wrong = column.texts[found.index(None)]
        raise NetworkError(f"the column '{name}' holds '{wrong}', not a number", path=path)
    return np.array(found, float)[column.codes]


def _float_of(text: str) -> float | None:
    try:
        return np.nan if text in _NO_NUMBERS else float(text)
    except ValueError:
        return None


def column_ids(path: Path, name: str, column: Column) -> tuple[IntArray, BoolArray, dict[int, str]]:
    """Return the id of each row, shape ``(n,)``, whether its cell is filled, and the names by id.

    A whole number is its own id; any other text is a name.

    Raises:
        NetworkError: a value is a fraction (a float has lost digits of a long id) or negative.
    """
    if not isinstance(column, TextColumn):
        return _number_ids(path, name, column)
    known = {text: _id_of(path, name, text) for text in column.texts}
    numbers = np.array([known[text] for text in column.texts], np.int64)
    filled = np.array([bool(text) for text in column.texts], bool)
    named = {number: text for text, number in known.items() if text and not text.isdecimal()}
    return numbers[column.codes], filled[column.codes], named


def _number_ids(
    path: Path, name: str, column: np.ma.MaskedArray
) -> tuple[IntArray, BoolArray, dict[int, str]]:
    if column.dtype.kind not in "iu":
        raise NetworkError(
            f"the column '{name}' holds {column.dtype} values; ids are whole numbers, since a float loses "
            "their last digits, or names",
            path=path,
        )
    filled: BoolArray = ~np.ma.getmaskarray(column)
    values = np.asarray(column.filled(0))
    if column.dtype.kind == "u" and values.size and values.max() > _LARGEST:
        raise NetworkError(
            f"the column '{name}' holds the id {values.max()}; ids go up to 2^63 - 1", path=path
        )
    numbers: IntArray = values.astype(np.int64)
    if (numbers < 0).any():
        raise _negative(path, name, int(numbers.min()))
    return numbers, filled, {}


def _negative(path: Path, name: str, number: int) -> NetworkError:
    return NetworkError(
        f"the column '{name}' holds {number}, which stands for no neuron: leave these rows out", path=path
    )


def _id_of(path: Path, column: str, text: str) -> int:
    """Return a whole number as it is, and the same 63 bits for a name in all tables."""
    if text.isdecimal() and text.isascii():
        if int(text) > _LARGEST:
            raise NetworkError(f"the column '{column}' holds the id {text}; ids go up to 2^63 - 1", path=path)
        return int(text)
    number = _float_of(text)
    if number is not None and np.isfinite(number):
        if number < 0:
            raise _negative(path, column, int(number))
        raise NetworkError(
            f"the column '{column}' holds '{text}'; ids are whole numbers, since a float loses their last "
            "digits, or names",
            path=path,
        )
    return name_id(text)


def name_id(name: str) -> int:
    """Return the id of a cell with a name; collisions are as rare as among random numbers of 63 bits."""
    return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "big") >> 1


def column_names(path: Path) -> list[str]:
    """Return the names of the columns of a table.

    Raises:
        NetworkError: the file is missing or damaged, or of another kind; or pyarrow is needed and missing.
    """
    with _opened(path) as (names, _):
        return names


def read_rows(path: Path, names: Sequence[str]) -> Iterator[Columns]:
    """Yield these columns of a table, some rows at a time.

    Raises:
        NetworkError: as for :func:`column_names`; or a column is repeated, or a row has too few cells.
    """
    with _opened(path, names) as (known, parts):
        for name in names:
            if known.count(name) > 1:
                raise NetworkError(f"the column '{name}' is there twice", path=path)
        yield from parts


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
            f"columns {join_with_limit([name for name in names if name], _MAX_NAMED)}",
            path=path,
        )
    return found


@contextmanager
def _opened(path: Path, names: Sequence[str] = ()) -> Iterator[tuple[list[str], Iterator[Columns]]]:
    """Open a table: the names of its columns, and parts of the chosen ones."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise NetworkError(f"is not a table; it must end in {', '.join(SUFFIXES)}", path=path)
    try:
        if suffix in TEXT_SUFFIXES:
            with opened_text(path) as rows:
                header = next(rows, [])
                yield header, _fast_parts(path, names) or _text_parts(path, rows, header, names)
        else:
            with _opened_arrow(path, suffix, names) as found:
                yield found
    except FileNotFoundError:
        raise NetworkError("there is no such file", path=path) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise NetworkError(f"the table cannot be read: {error}", path=path) from error


@contextmanager
def opened_text(path: Path) -> Iterator[Iterator[list[str]]]:
    """Open a text file as rows of cells, separated by the first of comma, tab, semicolon and bar it has."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        yield csv.reader(file, delimiter=_delimiter(path))


def _delimiter(path: Path) -> str:
    with path.open(encoding="utf-8-sig") as file:
        head = file.readline(_BLOCK)
    return next((one for one in ",\t;|" if one in head), ",")


def _fast_parts(path: Path, names: Sequence[str]) -> Iterator[Columns] | None:
    """Return the parts of a text file as pyarrow reads them, ten times as fast; None if it is missing."""
    try:
        import pyarrow as pa
        from pyarrow import csv as arrow
    except ImportError:
        return None
    if not names:
        return None

    def parts() -> Iterator[Columns]:
        parsed, chosen = (
            arrow.ParseOptions(delimiter=_delimiter(path)),
            arrow.ConvertOptions(include_columns=names),
        )
        try:
            with arrow.open_csv(path, arrow.ReadOptions(block_size=_BLOCK), parsed, chosen) as reader:
                for part in reader:
                    yield {name: _from_arrow(part.column(name)) for name in names}
        except pa.ArrowException as error:
            raise NetworkError(f"the table cannot be read: {error}", path=path) from error

    return parts()


def _text_parts(
    path: Path, rows: Iterator[list[str]], header: list[str], names: Sequence[str]
) -> Iterator[Columns]:
    places = [header.index(name) for name in names]
    line = 1
    while block := [row for row in islice(rows, _ROWS) if row]:
        try:
            columns = [[row[place] for row in block] for place in places]
        except IndexError:
            short = next(k for k, row in enumerate(block) if len(row) <= max(places))
            raise NetworkError(
                f"row {line + short + 1} has {len(block[short])} cells, and the header {len(header)}",
                path=path,
            ) from None
        yield {name: TextColumn.of(values) for name, values in zip(names, columns, strict=True)}
        line += len(block)


@contextmanager
def _opened_arrow(
    path: Path, suffix: str, names: Sequence[str]
) -> Iterator[tuple[list[str], Iterator[Columns]]]:
    try:
        import pyarrow as pa
        from pyarrow import ipc, parquet
    except ImportError as error:
        raise NetworkError(f"{suffix} files need pyarrow ({error}); try: {INSTALL}", path=path) from error
    try:
        if suffix == ".parquet":
            with parquet.ParquetFile(path) as file:
                known = list(file.schema_arrow.names)
                once = [name for name in names if known.count(name) == 1]
                parts = file.iter_batches(columns=once) if once else iter(())
                yield known, ({name: _from_arrow(part.column(name)) for name in names} for part in parts)
        else:
            with pa.OSFile(str(path)) as source:
                schema = ipc.open_file(source).schema
                fields = [schema.get_field_index(name) for name in names]
                options = ipc.IpcReadOptions(included_fields=[one for one in fields if one >= 0])
                reader = ipc.open_file(source, options=options)
                parts = (reader.get_batch(k) for k in range(reader.num_record_batches if names else 0))
                yield (
                    list(schema.names),
                    ({name: _from_arrow(part.column(name)) for name in names} for part in parts),
                )
    except pa.ArrowException as error:
        raise NetworkError(f"the table cannot be read: {error}", path=path) from error


def _from_arrow(values: Any) -> Column:
    import pyarrow.types as kinds

    if kinds.is_integer(values.type) or kinds.is_floating(values.type):
        missing = values.is_null(nan_is_null=True).to_numpy(zero_copy_only=False)
        return np.ma.MaskedArray(values.fill_null(0).to_numpy(zero_copy_only=False), missing)
    coded = values if kinds.is_dictionary(values.type) else values.dictionary_encode()
    texts = ["" if text is None else str(text).strip() for text in coded.dictionary.to_pylist()]
    codes = coded.indices.fill_null(len(texts)).to_numpy(zero_copy_only=False)
    return TextColumn([*texts, ""], codes.astype(np.int64))
