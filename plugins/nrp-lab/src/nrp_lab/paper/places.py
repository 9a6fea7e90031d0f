"""Neutral names for folders in a recording, so that an archive does not reveal its author."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from nrp_core.recording import RUN_NAME, file_digest, seal

EXPERIMENT, SOFTWARE, HOME = "paper", "software", "user"
_FILES, _SETTINGS = "experiment", "experiment.yaml"
"""The copies of files in a recording, and its settings as an experiment."""


def neutral_places(experiment: str) -> dict[str, str]:
    """Return the neutral name of each folder: of the experiment, of Python's packages, and of this user.

    Args:
        experiment: the file of the experiment.
    """
    places = {Path(experiment).parent.as_posix(): EXPERIMENT, Path.home().as_posix(): HOME}
    for number, path in enumerate(path for path in sys.path if Path(path).is_absolute()):
        places.setdefault(Path(path).as_posix(), f"{SOFTWARE}/{number}")
    # a folder of one part, such as /root, does not identify anyone, and its name has other meanings
    return {path[1:]: name for path, name in places.items() if path.count("/") > 1}


def in_neutral_places(text: str, places: Mapping[str, str]) -> str:
    """Return a text with its paths replaced."""
    for path in sorted(places, key=len, reverse=True):
        pattern = rf"(^|[\"'\s(\[`]/?|{_FILES}/){re.escape(path)}(?=[/\"'\s)\]`]|$)"
        text = re.sub(pattern, rf"\g<1>{places[path]}", text, flags=re.MULTILINE)
    return text


def make_anonymous(recording: Path) -> None:
    """Move files of a recording to neutral places; rewrite the files that name them, with new digests."""
    file = recording / RUN_NAME
    experiment = json.loads(file.read_text("utf-8"))["file"].removeprefix(_FILES)
    places = neutral_places(experiment)
    settings = recording / _SETTINGS
    settings.write_text(in_neutral_places(settings.read_text("utf-8"), places), "utf-8")
    for old, new in list(_moves(recording, places)):
        new.parent.mkdir(parents=True, exist_ok=True)
        old.rename(new)
    _remove_empty(recording / _FILES)
    run = json.loads(in_neutral_places(file.read_text("utf-8"), places))
    run["files"][_SETTINGS] = file_digest(settings)
    file.write_bytes(seal(run))


def _moves(recording: Path, places: Mapping[str, str]) -> Iterator[tuple[Path, Path]]:
    for path in (recording / _FILES).rglob("*"):
        name = path.relative_to(recording).as_posix()
        if path.is_file() and (moved := in_neutral_places(name, places)) != name:
            yield path, recording / moved


def _remove_empty(folder: Path) -> None:
    inside: Iterable[Path] = sorted(folder.rglob("*"), reverse=True)
    for path in inside:
        if path.is_dir() and not any(path.iterdir()):
            path.rmdir()
