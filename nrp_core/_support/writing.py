"""Write files and report a disk that refuses them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from nrp_core.errors import ExperimentError


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Let a block write a file or a folder.

    Raises:
        ExperimentError: the disk does not take it; it names the path and why.
    """
    try:
        yield
    except OSError as error:
        raise ExperimentError(f"cannot be written: {_reason(error)}", path=path) from error


def _reason(error: OSError) -> str:
    """Return why, in the words of the system; HDF5 has its number in the middle of a paragraph."""
    number = re.search(r"\berrno = (\d+)", str(error))
    return os.strerror(int(number[1])) if number else error.strerror or str(error)
