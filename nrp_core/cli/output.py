"""Output of the commands: JSON or text on standard output, everything else on standard error."""

from __future__ import annotations

import json
import os
import sys
from typing import Any, TextIO

_document_stream: TextIO | None = None


def reserve_stdout() -> None:
    """Reserve standard output for :func:`document`.

    All other output, also of engines written in C, goes to standard error from here on.
    """
    global _document_stream
    sys.stdout.flush()
    _document_stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr


def document(data: Any) -> None:
    """Write the JSON document of a command."""
    from nrp_core._support.json_values import to_jsonable

    stream = _document_stream or sys.stdout
    json.dump(to_jsonable(data), stream, indent=2, allow_nan=False, ensure_ascii=False)
    stream.write("\n")
    stream.flush()


def size_text(n_bytes: int) -> str:
    """Return the size of files in kB or MB."""
    return f"{n_bytes / 1e6:.1f} MB" if n_bytes >= 1e6 else f"{n_bytes / 1e3:.1f} kB"
