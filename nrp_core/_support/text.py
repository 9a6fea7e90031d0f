"""Text: where bytes are not in its encoding, and lists in sentences."""

from __future__ import annotations

import io
import tokenize
from collections.abc import Sequence
from dataclasses import dataclass


def join_with_limit(words: Sequence[str], most: int, between: str = ", ") -> str:
    """Return the first words of a list, and the number of further ones; empty for an empty list."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return between.join(words[:most]) + more


@dataclass(frozen=True, slots=True)
class Misfit:
    """A byte that does not belong to the encoding of its file.

    Args:
        message: the byte, the encoding and the remedy.
        line: of the byte, from 1.
        column: of the byte, from 1.
    """

    message: str
    line: int
    column: int


def misfit(data: bytes, error: UnicodeDecodeError) -> Misfit:
    """Return where and why all bytes of a file could not be decoded."""
    before, byte = data[: error.start], data[error.start]
    encoding = "UTF-8" if error.encoding == "utf-8" else error.encoding
    message = (
        f"not {encoding}: the byte 0x{byte:02x}, '{bytes([byte]).decode('latin-1')}' in Latin-1; "
        "save the file as UTF-8"
    )
    return Misfit(message, before.count(b"\n") + 1, error.start - before.rfind(b"\n"))


def decoded_python(data: bytes) -> str | Misfit:
    """Return the text of a Python file, in UTF-8 or the encoding that it declares (PEP 263)."""
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(data).readline)
        return io.StringIO(data.decode(encoding), newline=None).read()
    except UnicodeDecodeError as error:
        return misfit(data, error)
    except SyntaxError as error:  # an unknown encoding, or a wrong byte in the first two lines
        try:
            data.decode()
        except UnicodeDecodeError as wrong:
            return misfit(data, wrong)
        return Misfit(f"{error.msg}; declare one that Python knows, or none for UTF-8", 1, 1)
