"""Output of the commands: JSON or text on standard output, errors and all else on standard error."""

from __future__ import annotations

import json
import os
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

import typer

from nrp_core.errors import BackendError, CapabilityError, ExperimentError, NrpError, SimulationError

NO, USAGE, INVALID, NO_BACKEND, INTERRUPTED = 1, 2, 3, 4, 130
"""Exit codes; see :mod:`nrp_core.cli`."""

_document_stream: TextIO | None = None
_DIRECTIONS = "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
"""Characters that change the order in which others are shown."""
_CONTROL = re.compile(rf"[\x00-\x08\x0b-\x1f\x7f-\x9f{_DIRECTIONS}]")
_STYLE_OR_CONTROL = re.compile(rf"(\x1b\[[0-9;]*m)|{_CONTROL.pattern}")


def visible(text: str) -> str:
    """Return a text with its control characters escaped, except line ends and tabs."""
    return _CONTROL.sub(lambda found: _escape(found[0]), text)


def _escape(character: str) -> str:
    return f"\\x{ord(character):02x}" if ord(character) < 0x100 else f"\\u{ord(character):04x}"


class PlainStream:
    """A stream that writes no control characters but line ends, tabs and those of colours.

    Text of others can therefore not control a terminal.

    Args:
        stream: the stream to which it writes.
    """

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, and return its length."""
        self.stream.write(_STYLE_OR_CONTROL.sub(lambda found: found[1] or _escape(found[0]), text))
        return len(text)

    def writelines(self, texts: Iterable[str]) -> None:
        """Write texts."""
        for text in texts:
            self.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def plain_streams() -> Iterator[None]:
    """Write all output of this block, by whichever module, through plain streams."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast("TextIO", PlainStream(stream)) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def reserve_stdout() -> None:
    """Reserve standard output for :func:`document`.

    From here on all other output, including that of engines in C, is written to standard error.
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
    text = json.dumps(to_jsonable(data), indent=2, allow_nan=False, ensure_ascii=False)
    stream.write(_CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text) + "\n")
    stream.flush()


def size_text(n_bytes: int) -> str:
    """Return the size of files in kB or MB."""
    return f"{n_bytes / 1e6:.1f} MB" if n_bytes >= 1e6 else f"{n_bytes / 1e3:.1f} kB"


def exit_code(error: BaseException) -> int:
    """Return the exit code of an error that ended a command."""
    if isinstance(error, BackendError):
        return NO_BACKEND
    return INVALID if isinstance(error, (ExperimentError, CapabilityError)) else NO


def report(error: Exception, *, as_json: bool, debug: bool = False) -> int:
    """Write an error as text, or as ``{"error": {...}}``; return the exit code."""
    if debug:
        traceback.print_exception(error)
    if as_json:
        document({"error": as_data(error)})
    else:
        for line in lines(error):
            complain(line)
        for finding in getattr(error, "findings", ()):
            if finding.level == "warning":
                warn(str(finding))
    return exit_code(error)


def report_usage(error: Any, *, as_json: bool) -> int:
    """Report a wrong use of a command and show its usage."""
    if as_json:
        document({"error": {"kind": "UsageError", "message": error.format_message()}})
    else:
        error.show()
    return USAGE


def report_interrupt(*, as_json: bool) -> int:
    """Report that Ctrl-C ended a command before it had any result."""
    if as_json:
        document({"error": {"kind": "Interrupted", "message": "interrupted"}})
    else:
        complain("interrupted")
    return INTERRUPTED


def lines(error: Exception) -> Iterator[str]:
    """Yield the message of an error, or one line for each of its findings that is an error."""
    findings = getattr(error, "findings", ())
    if findings:
        yield from (str(finding) for finding in findings if finding.level == "error")
    elif isinstance(error, OSError) and not isinstance(error, NrpError) and error.filename is not None:
        yield f"{error.filename}: {error.strerror}"
    elif isinstance(error, (NrpError, OSError)):
        yield str(error)
    elif isinstance(error, MemoryError) or str(error) == "can't start new thread":
        cause = str(error) or "out of memory"
        yield f"{cause}: this machine or its limits (`ulimit -a`) have too little for the command"
    else:
        yield (
            f"{type(error).__name__}: {error}; this is a bug in the program: "
            "set NRP_DEBUG=1 to see the traceback, and please report it"
        )


def as_data(error: Exception) -> dict[str, Any]:
    """Return an error as a dictionary."""
    data: dict[str, Any] = {"kind": type(error).__name__, "message": getattr(error, "message", str(error))}
    if isinstance(error, ExperimentError):
        data |= {"path": error.path, "line": error.line, "column": error.column}
        data["findings"] = [finding.to_dict() for finding in getattr(error, "findings", ())]
    if isinstance(error, SimulationError):
        data["t_ns"] = error.t_ns
    return data


def complain(message: str, *, label: str = "error", color: str = "red") -> None:
    """Write a labelled line to standard error."""
    typer.secho(f"{label}: ", fg=color, bold=True, err=True, nl=False)
    typer.echo(visible(message), err=True)


def warn(message: str) -> None:
    """Write a warning to standard error."""
    complain(message, label="warning", color="yellow")
