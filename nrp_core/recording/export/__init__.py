"""Export of recordings to other formats: NWB, SONATA and CSV.

To add one, write its module and name it in :class:`Format`, in ``_write`` below, and in the command,
``nrp_core/cli/commands/recordings.py``.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path

from nrp_core._support.files import writing
from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.recording.reading.recording import RecordingReader


class Format(StrEnum):
    """The formats of an export."""

    NWB = "nwb"
    """Neurodata Without Borders, one file: spikes, devices, poses, commands and images."""
    SONATA = "sonata"
    """A folder with the spikes, the devices as a report, and the named groups of neurons."""
    CSV = "csv"
    """A folder with a table of the spikes and one for each topic that carries numbers."""


def export(recording: RecordingReader, kind: Format, target: Path) -> list[Path]:
    """Write a recording in another format.

    Args:
        recording: the recording; of a damaged one, the intact part is written.
        kind: the format.
        target: a new file, or a new folder for the formats that take several files.

    Returns:
        the files.

    Raises:
        ExperimentError: no part of the recording is intact, the target exists, its folder is missing, or it
            cannot be written; then it is removed.
        CapabilityError: the packages that the format needs are not installed.
    """
    if kind is Format.NWB and target.suffix != ".nwb":
        raise ExperimentError(f"an NWB file is called .nwb, not '{target.name}'")
    if not recording.topics and not recording.run:
        raise ExperimentError("not a recording, or no part of it is intact", path=recording.file)
    if target.exists():
        raise ExperimentError("it exists already", path=target)
    if not target.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=target.absolute().parent)
    try:
        with writing(target), _nothing_left(target):
            return _write(recording, kind, target)
    except ModuleNotFoundError as error:
        raise CapabilityError(
            f"{kind} needs the package {error.name}: pip install 'nrp-core[export]'"
        ) from error


@contextmanager
def _nothing_left(target: Path) -> Iterator[None]:
    """Run a block that writes a new file or folder; if the disk fails, remove it."""
    try:
        yield
    except OSError:
        if target.is_dir():
            shutil.rmtree(target, ignore_errors=True)
        target.unlink(missing_ok=True)
        raise


def _write(recording: RecordingReader, kind: Format, target: Path) -> list[Path]:
    if kind is Format.CSV:
        from nrp_core.recording.export.numbers import write_csv

        return write_csv(recording, target)
    if kind is Format.NWB:
        os.environ.setdefault(
            "PYNWB_NO_CACHE_DIR", "1"
        )  # a cache cut short by a full disk breaks later imports
        from nrp_core.recording.export.nwb import write_nwb

        return write_nwb(recording, target)
    from nrp_core.recording.export.sonata import write_sonata

    return write_sonata(recording, target)
