"""Export of recordings to other formats.

Distributions add formats in the entry-point group ``nrp_core.exporters``; the name of the entry point is that
of the format. Ours, CSV, is :data:`nrp_core.recording.export.numbers.CSV`.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from nrp_core._support.files import writing
from nrp_core.errors import BackendLoadError, ExperimentError
from nrp_core.paths import check_free
from nrp_core.recording.recording import Recording
from nrp_core.registry import Registry


@dataclass(frozen=True, slots=True)
class Exporter:
    """A format in which recordings can be written.

    Args:
        write: writes a recording to a path that does not exist, and returns the files that it wrote; of a
            damaged recording, the intact part.
        suffix: the suffix of its file, such as ``.nwb``; empty for a format that is a folder of files.
    """

    write: Callable[[Recording, Path], Sequence[Path]]
    suffix: str = ""


_DRAFT = ".draft-"
EXPORTERS: Final[Registry[Exporter]] = Registry("nrp_core.exporters", "export format")
"""The formats by name."""


def find_exporter(name: str) -> Exporter:
    """Return the exporter of a format.

    Raises:
        BackendError: no distribution provides it, two do, or it cannot be used.
    """
    exporter = EXPORTERS.load(name)
    if not isinstance(exporter, Exporter):
        provider = EXPORTERS.provider(name)
        raise BackendLoadError(
            f"the {EXPORTERS.kind} '{name}' of {provider} is a {type(exporter).__name__}, not an Exporter"
        )
    return exporter


def export(recording: Recording, name: str, target: Path, *, overwrite: bool = False) -> list[Path]:
    """Write a recording in another format.

    Args:
        recording: the recording; of a damaged one, the intact part is written.
        name: the name of the format.
        target: a new file, or a new folder for the formats that take several files.
        overwrite: whether to replace an existing file, or files in an existing folder.

    Returns:
        the files.

    Raises:
        ExperimentError: no part of the recording is intact, the target exists, its folder is missing, or it
            cannot be written; then it is removed.
        BackendError: the format, or a package that it needs, is not installed.
    """
    exporter = find_exporter(name)
    if exporter.suffix and target.suffix != exporter.suffix:
        raise ExperimentError(f"the name of a file in {name} ends in {exporter.suffix}: '{target.name}'")
    if not recording.topics and not recording.run:
        raise ExperimentError("not a recording, or no part of it is intact", path=recording.file)
    check_free(target, overwrite=overwrite)
    if not target.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=target.absolute().parent)
    draft = target.with_name(f"{_DRAFT}{target.name}") if target.exists() else target
    with writing(target), _nothing_left(draft):
        files = list(exporter.write(recording, draft))
        return files if draft is target else [_replace(file, draft, target) for file in files]


def _replace(file: Path, draft: Path, target: Path) -> Path:
    """Move a written file to its place; other files of an existing folder stay."""
    place = target / file.relative_to(draft)
    place.parent.mkdir(parents=True, exist_ok=True)
    return file.replace(place)


@contextmanager
def _nothing_left(target: Path) -> Iterator[None]:
    """Run a block that writes a file or folder; remove it if the disk fails or it is a draft."""
    try:
        yield
    except OSError:
        _remove(target)
        raise
    if target.name.startswith(_DRAFT):
        _remove(target)


def _remove(target: Path) -> None:
    if target.is_dir():
        shutil.rmtree(target, ignore_errors=True)
    else:
        target.unlink(missing_ok=True)
