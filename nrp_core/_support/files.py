"""Failures of the disk as errors."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from nrp_core.errors import ExperimentError


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Run a block that writes a file or a folder.

    Raises:
        ExperimentError: the disk refused a write; the message names the path and the reason.
    """
    try:
        yield
    except OSError as error:
        raise ExperimentError(f"cannot be written: {_reason(error)}", path=path) from error


def _reason(error: OSError) -> str:
    """Return the system's message for the number of an error; HDF5 buries it in a paragraph of text."""
    return str(error) if error.errno is None else os.strerror(error.errno)
