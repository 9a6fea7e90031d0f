"""Ids of cells: whole numbers, or names, which become numbers."""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path
from typing import Any

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
