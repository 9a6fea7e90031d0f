"""Find the files that an experiment names: beside it, then in the folders of models; in archives too."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

from nrp_core.archives import unpacked
from nrp_legacy.documents import FileNamed

_STAND_INS = Path(__file__).with_name("stand_ins")
EMPTY_ROOM, NO_BRAIN = _STAND_INS / "empty_room.sdf", _STAND_INS / "no_brain.py"
"""What there is where an experiment names nothing that is found."""
_SHELVES = ("", "robots", "brains", "environments", "bibi", "brain_model")
"""Folders of a model library in which its models stand."""
_SCHEMES = ("storage://", "model://", "file://")


class Library:
    """The folders in which files are looked for.

    Args:
        folder: of the experiment.
        models: of model libraries, first come first.
    """

    def __init__(self, folder: Path, models: Sequence[Path] = ()) -> None:
        self.folder = folder
        self._models = [found for path in models for found in (path, path / "Models") if found.is_dir()]

    def roots(self) -> list[Path]:
        """Return the folders in which rooms and robots find the models that they refer to."""
        shelves = (library / shelf for library in self._models for shelf in _SHELVES)
        return [self.folder, *dict.fromkeys(folder for folder in shelves if folder.is_dir())]

    def environment(self) -> dict[str, str]:
        """Return the variables in which the platform told where its folders are."""
        models = self._models[0] if self._models else self.folder
        return {
            "HBP": str(models.parent),
            "NRP_MODELS_DIRECTORY": str(models),
            "NRP_EXPERIMENTS_DIRECTORY": str(self.folder.parent),
            "GAZEBO_MODEL_PATH": os.pathsep.join(map(str, self._models)),
            "ROS_MASTER_URI": "http://localhost:11311",
            "NRP_VIRTUAL_ENV": sys.prefix,
        }

    def find(self, named: FileNamed) -> Path | None:
        """Return a file by the name that a document gives it, or None."""
        return self._first(named.names, named.model)

    def find_code(self, name: str) -> Path | None:
        """Return a file of code by its name."""
        return self._first((name,), None)

    def find_sdf(self, named: FileNamed) -> Path | None:
        """Return the file of a robot or room; of an archive, the one that it unpacks to."""
        names = []
        for name in named.names:
            names += [name, f"{name}/model.sdf", f"{name}/{Path(name).name}.sdf"]
            names += [f"{Path(name).parent.name or named.model}.zip"] if name.endswith(".sdf") else []
        path = self._first(names, named.model)
        return path if path is None or path.suffix != ".zip" else _inside(path, (".sdf", ".urdf"))

    def find_brain(self, named: FileNamed) -> Path | None:
        """Return the file of a brain; of an archive, the one that it unpacks to."""
        names = (*named.names, *(f"{name}/{Path(name).name}.py" for name in named.names))
        path = self._first(names, named.model)
        return path if path is None or path.suffix != ".zip" else _inside(path, (".py", ".h5"))

    def _first(self, names: Iterable[str], model: str | None) -> Path | None:
        """Return the first file that there is.

        Args:
            names: relative to the experiment, or to a folder of models; ``storage://experiment/file`` is a
                file of the experiment.
            model: the model of a library that they belong to.
        """
        plain = [_plain(name) for name in names]
        candidates = (path for name in plain for path in self._candidates(name, model))
        found = next((path.resolve() for path in candidates if path.is_file()), None)
        return found or next((path for name in plain if (path := self._by_its_end(name))), None)

    def _candidates(self, name: str, model: str | None) -> Iterator[Path]:
        beside = (self.folder, self.folder / "resources", self.folder.parent)
        yield from (place / name for place in beside)
        if model is not None:
            yield self.folder / model / name
        for library in self._models:
            for shelf in _SHELVES:
                yield library / shelf / name
                if model is not None:
                    yield library / shelf / model / name
        # `storage://experiment/file` and `../Experiments/experiment/file`
        rest = name.replace("\\", "/").split("/")
        yield from (self.folder.joinpath(*rest[i:]) for i in range(1, len(rest)))

    def _by_its_end(self, name: str) -> Path | None:
        """Return the first file of the libraries whose path ends so, in whichever case."""
        end = [part.lower() for part in Path(name).parts if part not in ("..", ".", "/")]
        named = self._files.get(end[-1], ()) if end else ()
        ends = (path for path in named if [part.lower() for part in path.parts[-len(end) :]] == end)
        return next((path.resolve() for path in ends), None)

    @cached_property
    def _files(self) -> Mapping[str, list[Path]]:
        """All files of the libraries by their names, in small letters."""
        found = defaultdict[str, list[Path]](list)
        for library in self._models:
            for folder, folders, names in os.walk(library):
                folders.sort()
                for name in sorted(names):
                    found[name.lower()].append(Path(folder, name))
        return found


def _plain(name: str) -> str:
    for scheme in _SCHEMES:
        name = name.removeprefix(scheme)
    return name.strip().lstrip("/") if not Path(name).is_file() else name


def _inside(archive: Path, suffixes: Iterable[str]) -> Path | None:
    """Return the main file of an archive."""
    folder = unpacked(archive)
    found = [path for suffix in suffixes for path in sorted(folder.rglob(f"*{suffix}"))]
    named = [path for path in found if path.stem in ("model", archive.stem)] or found
    return min(named, key=lambda path: len(path.parts), default=None)
