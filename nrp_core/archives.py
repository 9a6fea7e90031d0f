"""Safe unpacking of ZIP archives from untrusted sources."""

from __future__ import annotations

import hashlib
import shutil
import stat
import zipfile
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath

from nrp_core._support.cache import cached_folder
from nrp_core.errors import ExperimentError

MAX_FILES = 20_000
MAX_BYTES = 1_000_000_000
"""Limit of the unpacked size of all files of an archive together."""
MAX_RATIO = 200
"""Limit of the ratio of unpacked to packed size, of a file and of all; meshes and images stay below 20."""
_SMALL = 10_000_000  # bytes; less is harmless at any compression ratio


def unpack(archive: Path, kind: type[ExperimentError] = ExperimentError) -> Path:
    """Return the folder of an archive's files; it is unpacked once for each content.

    Raises:
        ExperimentError: of the given kind: the file is not a ZIP archive or is damaged, one of its files
            would be written outside of the folder, or the unpacked size exceeds the limits.
    """
    try:
        digest = hashlib.blake2b(archive.read_bytes(), digest_size=12).hexdigest()
        return cached_folder("unpacked", f"{archive.stem}-{digest}", partial(_unpack, archive, kind))
    except (zipfile.BadZipFile, NotImplementedError, EOFError) as error:
        raise kind(f"this is not a ZIP archive that can be read: {error}", path=archive) from None
    except OSError as error:
        raise kind(f"cannot be read: {error.strerror or error}", path=archive) from None


def _unpack(archive: Path, kind: type[ExperimentError], folder: Path) -> None:
    with zipfile.ZipFile(archive) as packed:
        files = [entry for entry in packed.infolist() if not entry.is_dir()]
        problem = _problem(files)
        if problem:
            raise kind(f"the archive is refused: {problem}", path=archive)
        for entry in files:
            target = folder.joinpath(*PurePosixPath(entry.filename).parts)
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                with packed.open(entry) as source, target.open("xb") as sink:
                    shutil.copyfileobj(source, sink)
            except (FileExistsError, NotADirectoryError):
                message = f"the archive is refused: it has two things named '{entry.filename}'"
                raise kind(message, path=archive) from None
            except RuntimeError:  # zipfile's error for a file that needs a password
                raise kind(f"the file '{entry.filename}' in it is encrypted", path=archive) from None


def _problem(files: list[zipfile.ZipInfo]) -> str:
    """Return the fault of an archive; zipfile never unpacks more of a file than its listing states."""
    if len(files) > MAX_FILES:
        return f"it holds {len(files)} files; {MAX_FILES} are enough for any model"
    large = sum(entry.file_size for entry in files)
    if large > MAX_BYTES:
        return f"it unpacks to {large / 1e6:.0f} MB; {MAX_BYTES / 1e6:.0f} MB is the limit"
    for entry in files:
        if _leaves(entry.filename):
            return f"its file '{entry.filename}' would be written outside of its folder"
        if stat.S_ISLNK(entry.external_attr >> 16):
            return f"'{entry.filename}' is a symbolic link, which may lead anywhere"
        if entry.file_size > max(_SMALL, MAX_RATIO * entry.compress_size):
            return f"its file '{entry.filename}' unpacks to {entry.file_size / 1e6:.0f} MB of nearly nothing"
    if large > max(_SMALL, MAX_RATIO * sum(entry.compress_size for entry in files)):
        return f"it unpacks to {large / 1e6:.0f} MB of nearly nothing"
    return ""


def _leaves(name: str) -> bool:
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    return (
        ".." in (*posix.parts, *windows.parts) or posix.is_absolute() or bool(windows.drive or windows.root)
    )
