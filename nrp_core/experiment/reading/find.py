"""Find an experiment by name or path, and read it in any supported format.

A distribution ships an experiment as a package whose folder holds ``experiment.yaml``, named by an entry
point; other files in the folder are its variants: ``braitenberg_husky`` and ``braitenberg_husky/no_red``.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from os import PathLike
from pathlib import Path
from types import ModuleType

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.collector import CollectorPaused
from nrp_core.archives import unpack
from nrp_core.errors import BackendError, ExperimentError, did_you_mean
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.paths import MissingFileError, require_target
from nrp_core.registry import Registry

Reader = Callable[[Path, Sequence[str]], Experiment]
"""Reads a file with overrides. If other files have its suffix, too, it has an attribute ``recognizes``, a
function that returns whether a file is an experiment."""

SHIPPED: Registry[ModuleType] = Registry("nrp_core.experiments", "experiment")
READERS: Registry[Reader] = Registry("nrp_core.experiment_readers", "experiment reader")
_logger = logging.getLogger(__name__)
STEM = "experiment"
ARCHIVE = ".zip"
_YAML = (".yaml", ".yml")
_KEYS = re.compile(rb"^(extends|brain|world|transfer_functions)\s*:", re.MULTILINE)
_MAX_DEPTH, _MOST_LISTED = 4, 12


@checks_arguments("text", "overrides")
def load_experiment(text: str | Path, overrides: Iterable[str] = ()) -> Experiment:
    """Find and read an experiment.

    Args:
        text: a shipped experiment (``name`` or ``name/variant``), a file, or a folder or ZIP archive with
            one.
        overrides: ``dotted.key=value``; if two set one key, the later one is used.

    Raises:
        ExperimentError: none was found, or it is invalid.
    """
    given = _as_tuple(overrides)
    if not isinstance(text, str | PathLike):
        raise ExperimentError(
            f"an experiment is a name or a file, not of type {type(text).__name__}; Run takes one that is "
            "loaded"
        )
    with CollectorPaused():
        path = find_file(str(text))
        experiment = READERS.load(path.suffix)(path, given)
    if Path(text).suffix.lower() != ARCHIVE:
        return experiment
    # unpacked files are in a hidden folder
    return experiment.with_csv_folder(Path.cwd() / Path(text).expanduser().with_suffix("") / "csv")


def _as_tuple(overrides: Iterable[str]) -> tuple[str, ...]:
    if isinstance(overrides, str | Mapping) or not isinstance(overrides, Iterable):
        raise ExperimentError(f"overrides are a list such as ['seed=3', 'pace=max'], not {overrides!r:.60}")
    return tuple(overrides)


def once_each(overrides: Iterable[str]) -> tuple[str, ...]:
    """Return overrides that are given together, in order.

    Raises:
        ExperimentError: they are not several, or two set one key.
    """
    first: dict[str, str] = {}
    given = _as_tuple(overrides)
    for one in given:
        key = str(one).partition("=")[0].strip()
        if key in first:
            raise ExperimentError(f"the overrides set '{key}' twice: '{first[key]}' and '{one}'; give one")
        first[key] = str(one)
    return given


def shipped() -> list[str]:
    """Return the names of all experiments that installed distributions ship, variants included."""
    names: list[str] = []
    for package in SHIPPED.names():
        with suppress(BackendError):  # a broken one is reported when it is loaded
            names += _variants(package)
    return names


@cache
def _note_other_folder(name: str, installed: Path, folder: Path) -> None:
    """Say once that something else in a folder has the name of an installed experiment."""
    here = (folder / name).resolve()
    is_experiment = any(here.glob(f"{STEM}.*")) or any(here.glob("*.exc"))
    is_recording = (here / "run.json").exists()
    if is_experiment and not is_recording and not installed.resolve().is_relative_to(here):
        _logger.warning("'%s' is the installed experiment; the one in this folder is './%s'", name, name)


def find_file(text: str, folder: Path | None = None) -> Path:
    """Return the file of an experiment.

    Args:
        text: a shipped experiment, a file, or a folder or ZIP archive with one; ``./name`` is never a
            shipped one.
        folder: where relative paths start; by default the current one.

    Raises:
        ExperimentError: it does not exist, a folder has several, the file's suffix is unknown, or a name
            is not UTF-8.
    """
    package = text if text in SHIPPED.names() else text.partition("/")[0]
    if package in SHIPPED.names():
        stem = STEM if text == package else text.removeprefix(f"{package}/")
        # readers of other formats, which may import much, are not asked about other files of the package
        named = [path for path in _files(package) if path.stem == stem and _is_experiment(path)]
        if named:
            _note_other_folder(text, named[-1], folder or Path.cwd())
            return named[-1]
    path = (folder or Path.cwd()) / Path(text).expanduser()
    try:
        require_target(path)
        str(path.resolve()).encode()
    except UnicodeEncodeError:  # it could be opened, but not printed or recorded
        raise ExperimentError("the name of the file or of a folder above is not UTF-8", path=path) from None
    except MissingFileError as error:
        raise ExperimentError(str(error)) from None
    if path.is_dir():
        return _in_folder(path)
    if not path.is_file():
        hint = did_you_mean(text, [*shipped(), *_beside(path, text)])
        raise ExperimentError(f"there is no experiment or file '{text}'{hint}")
    if path.suffix.lower() == ARCHIVE:
        return _in_archive(path.resolve())
    if path.suffix not in READERS.names():
        _require_readers([path])
        raise ExperimentError(f"not an experiment: files end in {', '.join(READERS.names())}", path=path)
    return path.resolve()


def _beside(path: Path, text: str) -> Iterator[str]:
    """Yield the files of experiments in the folder of a file that does not exist, as paths like its own."""
    with suppress(OSError):  # the folder does not exist either, or cannot be read
        for file in path.parent.iterdir():
            if file.suffix in (*READERS.names(), ARCHIVE):
                yield str(Path(text).with_name(file.name))


def experiments_in(folder: Path) -> list[Path]:
    """Return the experiments in a folder; of those below it that are in YAML, only ``experiment.yaml``."""
    here = [path for path in folder.iterdir() if _is_experiment(path) and not _is_other_yaml(path)]
    return sorted(here) + sorted(_below(folder))


def _in_archive(archive: Path) -> Path:
    top = unpack(archive)
    found = [path for path in top.rglob("*") if path.name[:1] != "." and _is_experiment(path)]
    if not found:
        _require_readers(top.rglob("*"))
        raise ExperimentError(f"the archive {_contains_none()}", path=archive)
    return _in_folder(
        min((path.parent for path in found), key=lambda folder: (len(folder.parts), str(folder)))
    )


def _contains_none() -> str:
    return f"does not contain an experiment: files end in {', '.join(READERS.names())}"


def _in_folder(folder: Path) -> Path:
    """Return the experiment of a folder, else the only one below it, as in a repository."""
    found = sorted(path for path in folder.iterdir() if _is_experiment(path))
    likely = [path for path in found if not _is_other_yaml(path)]
    named = [path for path in found if path.stem == STEM] or likely or sorted(_below(folder)) or found
    if len(named) == 1:
        try:
            require_target(named[0])
        except MissingFileError as error:
            raise ExperimentError(str(error)) from None
        return named[0].resolve()
    if not named:
        _require_readers(folder.iterdir())
        raise ExperimentError(f"the folder {_contains_none()}", path=folder)
    several = ", ".join(str(path.relative_to(folder)) for path in named[:_MOST_LISTED])
    more = f" and {len(named) - _MOST_LISTED} more" if len(named) > _MOST_LISTED else ""
    raise ExperimentError(f"the folder holds several experiments; name one: {several}{more}", path=folder)


def _below(folder: Path, depth: int = 1) -> Iterator[Path]:
    """Yield the experiments in the folders of a folder; of those in YAML only ``experiment.yaml``."""
    for inner in folder.iterdir():
        if inner.name[:1] == "." or inner.is_symlink() or not inner.is_dir():
            continue
        with suppress(PermissionError):
            for path in inner.iterdir():
                if _is_experiment(path) and (path.suffix not in _YAML or path.stem == STEM):
                    yield path
            if depth < _MAX_DEPTH:
                yield from _below(inner, depth + 1)


def _is_other_yaml(path: Path) -> bool:
    """Return whether a YAML file lacks all keys of an experiment, such as the settings of other programs."""
    return path.suffix in _YAML and path.is_file() and not _KEYS.search(path.read_bytes())


def _is_experiment(path: Path) -> bool:
    """Return whether a file is one that an installed reader reads."""
    if path.suffix not in READERS.names() or (path.exists() and not path.is_file()):
        return False
    recognizes = getattr(READERS.load(path.suffix), "recognizes", None)
    return recognizes is None or recognizes(path)


def _require_readers(paths: Iterable[Path]) -> None:
    """Check that none of these files needs a distribution of this project that is not installed.

    Raises:
        ExperimentError: one does; the message names the distribution.
    """
    for path in paths:
        if READERS.distribution_with(path.suffix):
            try:
                READERS.provider(path.suffix)
            except BackendError as error:
                raise ExperimentError(str(error), path=path) from None


def _files(package: str) -> list[Path]:
    """Return the files of a shipped package, by name."""
    return sorted(Path(str(SHIPPED.load(package).__file__)).parent.iterdir())


def _variants(package: str) -> dict[str, Path]:
    """Return the experiments in a shipped package by the names that users give them."""
    ordered = sorted(filter(_is_experiment, _files(package)), key=lambda path: path.stem != STEM)
    return {package if path.stem == STEM else f"{package}/{path.stem}": path for path in ordered}
