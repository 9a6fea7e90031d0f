"""The gallery: installed experiments, and experiments, recordings and sweeps of a folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from nrp_lab.sweep.table import ABOUT, read_about

from nrp_cockpit.start.pictures import picture_key
from nrp_core.errors import NrpError
from nrp_core.experiment import experiments_in, load_experiment, shipped
from nrp_core.recording import RUN_NAME, Recording

MOST: Final = 300
"""Maximum number of entries of each kind from a folder."""
_DEPTH: Final = 4
"""Number of levels of folders that are searched."""

Seen = tuple[str, tuple[str, ...], str]
"""The description of an entry, the names of its backends, and the key of its picture."""


@dataclass(frozen=True, slots=True)
class Entry:
    """Something that can be opened.

    Args:
        kind: ``experiment``, ``recording`` or ``sweep``.
        name: as a user would write it in the command.
        installed: whether it is installed; otherwise it is in the folder.
        text: a description.
        engines: the names of its backends.
        error: the reason why it cannot be read; empty if it can.
        picture: the key of its picture, equal for entries that look the same; empty: it has none.
    """

    kind: str
    name: str
    installed: bool = False
    text: str = ""
    engines: tuple[str, ...] = ()
    error: str = ""
    picture: str = ""


def gallery(folder: Path) -> list[Entry]:
    """Return the entries that can be opened.

    Args:
        folder: the folder that is searched, with those below it.
    """
    results = sorted(_results(folder, _DEPTH), key=lambda path: path.stat().st_mtime_ns, reverse=True)
    inside = [path for path in experiments_in(folder) if not any(one in path.parents for one in results)]
    return [
        *(_entry("experiment", name, _of_experiment, name, installed=True) for name in shipped()),
        *(_entry("experiment", _name(path, folder), _of_experiment, path) for path in inside[:MOST]),
        *(_entry(kind, _name(path, folder), look, path)
          for kind, mark, look in (("recording", RUN_NAME, _of_recording), ("sweep", ABOUT, _of_sweep))
          for path in [one for one in results if (one / mark).is_file()][:MOST]),
    ]  # fmt: skip


def _results(folder: Path, depth: int) -> Iterator[Path]:
    """Yield the recordings and the sweeps in a folder, without those inside another one."""
    try:
        with os.scandir(folder) as found:
            inner = [one.path for one in found if one.name[:1] != "." and one.is_dir(follow_symlinks=False)]
    except OSError:  # it cannot be read
        return
    for path in map(Path, inner):
        if (path / RUN_NAME).is_file() or (path / ABOUT).is_file():
            yield path
        elif depth > 1:
            yield from _results(path, depth - 1)


def _name(path: Path, folder: Path) -> str:
    """Return a path that is never the name of an installed experiment, such as ``./husky.yaml``."""
    return f".{os.sep}{path.relative_to(folder)}"


def _entry(
    kind: str,
    name: str,
    look: Callable[[Any], Seen],
    at: str | Path,
    *,
    installed: bool = False,
) -> Entry:
    """Return an entry with its details or its error, so that a broken one does not hide the others."""
    try:
        text, engines, picture = look(at)
    except NrpError as error:
        return Entry(kind, name, installed, error=str(error))
    return Entry(kind, name, installed, text, engines, picture=picture)


def _of_experiment(at: str | Path) -> Seen:
    experiment = load_experiment(at)
    engines = experiment.brain.backend, experiment.world.backend
    return experiment.description, engines, picture_key(experiment)


def _of_recording(folder: Path) -> Seen:
    run = Recording(folder).run
    begun = str(run.get("recorded") or "")[:16].replace("T", " ")  # ISO 8601, to the minute
    words = (str(run.get("experiment") or ""), begun, str(run.get("state") or ""))
    return (
        ", ".join(filter(None, words)),
        tuple(run[side]["backend"] for side in ("brain", "world") if side in run),
        "",
    )


def _of_sweep(folder: Path) -> Seen:
    about = read_about(folder)
    return f"{about['identity'].get('experiment', '')}, {about.get('runs', 0)} runs", (), ""
