"""Files named in an experiment file; a relative path starts at the folder of the file that names it.

The annotated type is for pydantic models; third parties use it for their own options.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema

from nrp_core.errors import ExperimentError, did_you_mean


class MissingFileError(ValueError):
    """A file does not exist."""


class TextFrom(str):
    """A text that carries the folder of the file it was written in."""

    __slots__ = ("folder",)
    folder: Path

    @classmethod
    def of(cls, text: str, folder: Path) -> TextFrom:
        """Return ``text`` with a folder."""
        located = cls(text)
        located.folder = folder
        return located


def path_of(value: object, error: type[ExperimentError] = ExperimentError) -> Path:
    """Return a path that was given in Python.

    Raises:
        ExperimentError: it is none; of the class ``error``.
    """
    if not isinstance(value, (str, PathLike)):
        raise error(f"a path is a text or a pathlib.Path, not {value!r:.60}")
    return Path(value)


def check_free(path: Path, *, overwrite: bool, error: type[ExperimentError] = ExperimentError) -> None:
    """Refuse an output file or folder that exists already, unless it is to be replaced.

    An empty folder is free.

    Raises:
        ExperimentError: it exists; of the class ``error``.
    """
    if not overwrite and path.exists() and not (path.is_dir() and not any(path.iterdir())):
        raise error(
            "it exists already; name another one, or replace it with --overwrite (in Python, overwrite=True)",
            path=path,
        )


def require_target(path: Path) -> None:
    """Refuse a symbolic link that leads nowhere, or in a circle.

    Raises:
        MissingFileError: the path is such a link, or a folder above is.
    """
    link = next((part for part in (path, *path.parents) if part.is_symlink()), None)
    if link is not None and not link.exists():
        raise MissingFileError(f"the symbolic link {link} -> {link.readlink()} leads nowhere")


def existing_file(value: object) -> Path:
    """Return the absolute path of a file.

    Raises:
        MissingFileError: the file does not exist; the message names a similar one in its folder.
        ValueError: the text is not the name of a file.
    """
    if not isinstance(value, (str, Path)):
        raise ValueError(f"the name of a file is a text, not {value!r}")
    path = (value.folder if isinstance(value, TextFrom) else Path.cwd()) / Path(value).expanduser()
    if path.is_file():
        return path.resolve()
    require_target(path)
    if path.is_dir():
        raise MissingFileError(f"'{value}' is a folder, not a file")
    folder = path.parent
    if not folder.is_dir():
        raise MissingFileError(f"no file '{value}': there is no folder {folder}")
    files = (entry.name for entry in folder.iterdir() if entry.is_file())
    beside = [name for name in files if path.name.startswith(".") or not name.startswith(".")]
    alike = [name for name in beside if name.endswith(path.suffix)]
    raise MissingFileError(f"no file '{value}' in {folder}{did_you_mean(path.name, alike or beside)}")


def existing_folder(value: object) -> Path:
    """Return the absolute path of a folder.

    Raises:
        MissingFileError: the folder does not exist.
        ValueError: the text is not the name of a folder.
    """
    if not isinstance(value, (str, Path)):
        raise ValueError(f"the name of a folder is a text, not {value!r}")
    path = (value.folder if isinstance(value, TextFrom) else Path.cwd()) / Path(value).expanduser()
    if not path.is_dir():
        raise MissingFileError(f"there is no folder {path}")
    return path.resolve()


ExistingFile = Annotated[
    Path,
    BeforeValidator(existing_file),
    WithJsonSchema({"type": "string", "description": "a file, relative to the file that names it"}),
]
"""A file that exists, kept as an absolute path."""

ExistingFolder = Annotated[
    Path,
    BeforeValidator(existing_folder),
    WithJsonSchema({"type": "string", "description": "a folder, relative to the file that names it"}),
]
"""A folder that exists, kept as an absolute path."""
