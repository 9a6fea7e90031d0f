"""Find the files that an experiment names: in its folder, then in folders of models; also in archives."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path, PurePosixPath

from nrp_core.archives import unpack
from nrp_core.world.scene.reading.context import main_file
from nrp_legacy.documents import FileNamed

_STAND_INS = Path(__file__).with_name("stand_ins")
EMPTY_ROOM, NO_BRAIN = _STAND_INS / "empty_room.sdf", _STAND_INS / "no_brain.py"
"""Replacements for files that are not found."""
_SHELVES = ("", "robots", "brains", "environments", "bibi", "brain_model")
"""Folders of a model library in which its models stand."""
_BRAINS = (".py", ".h5")
_SCHEMES = ("storage://", "model://", "file://")


def installed_models() -> list[Path]:
    """Return the folder of models in the environment variables of a platform installation, if any."""
    said = (Path(os.environ.get("NRP_MODELS_DIRECTORY") or "/"), Path(os.environ.get("HBP") or "/", "Models"))
    return [folder for folder in said if folder != Path("/") and folder.is_dir()][:1]


class Library:
    """The folders in which files are searched.

    Args:
        folder: the folder of the experiment.
        models: the folders of model libraries, in order of search.
    """

    def __init__(self, folder: Path, models: Sequence[Path] = ()) -> None:
        self.folder = folder
        self._models = [found for path in models for found in (path, path / "Models") if found.is_dir()]

    def roots(self) -> list[Path]:
        """Return the folders in which rooms and robots find the models that they refer to."""
        shelves = (library / shelf for library in self._models for shelf in _SHELVES)
        textures = self.folder / "resources" / "textures"
        others = (folder for folder in (*shelves, textures) if folder.is_dir())
        return list(dict.fromkeys((self.folder, *others)))

    def environment(self) -> dict[str, str]:
        """Return the environment variables with the folders of the platform."""
        models = self._models[0] if self._models else self.folder
        return {
            "HBP": str(models.parent),
            "NRP_MODELS_DIRECTORY": str(models),
            "NRP_EXPERIMENTS_DIRECTORY": str(self.folder.parent),
            "NRP_EXPERIMENT_DIRECTORY": str(self.folder),
            "NRP_SIMULATION_DIR": str(self.folder),
            "NRP_INSTALL_MODE": "user",
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

    def find_data(self, name: str) -> Path | None:
        """Return a file or folder that code names."""
        plain = _plain(name).rstrip("/")
        places = (place for place in self._candidates(plain, None) if plain and place.exists())
        return next((place.resolve() for place in places), None) or self._by_its_end(plain)

    def find_sdf(self, named: FileNamed) -> Path | None:
        """Return the file of a robot or room; of an archive, the one that it unpacks to."""
        names = []
        for name in named.names:
            names += [name, f"{name}/model.sdf", f"{name}/{Path(name).name}.sdf", f"{name}.sdf"]
            names += [f"{Path(name).parent.name or named.model}.zip"] if name.endswith(".sdf") else []
        return self._main(names, named.model, lambda folder, _name: main_file(folder))

    def find_brain(self, named: FileNamed) -> Path | None:
        """Return the file of a brain; of an archive, the one that it unpacks to."""
        others = (f"{name}{end}" for name in named.names for end in (f"/{Path(name).name}.py", ".py", ".h5"))
        return self._main([*named.names, *others], named.model, _main_script)

    def _main(
        self, names: Sequence[str], model: str | None, main: Callable[[Path, str], Path | None]
    ) -> Path | None:
        """Return the first file that exists; for an archive or a folder, its main file."""
        path = self._first(names, model)
        if path is not None:
            return path if path.suffix.lower() != ".zip" else main(unpack(path), path.stem)
        places = (place for name in names for place in self._candidates(_plain(name), model))
        folders = (place for place in places if place.is_dir() and place.resolve() not in self._tops)
        return next((file for folder in folders if (file := main(folder, folder.name))), None)

    def _first(self, names: Iterable[str], model: str | None) -> Path | None:
        """Return the first file that exists.

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
        """Return the first file whose path ends with these parts, ignoring case.

        Leading folders may be missing here, such as folders or variables of another machine. At least a
        folder and a file must match.
        """
        parts = [part.lower() for part in PurePosixPath(name).parts if part not in ("..", ".", "/")]
        named = self._files.get(parts[-1], ()) if parts else ()
        for i in range(max(len(parts) - 1, 1)):
            end = parts[i:]
            for path in named:
                if [part.lower() for part in path.parts[-len(end) :]] == end:
                    return path.resolve()
        return None

    @cached_property
    def _files(self) -> Mapping[str, list[Path]]:
        """All files of the experiment and the libraries by their lower-case names."""
        found = defaultdict[str, list[Path]](list)
        for place in (self.folder, *self._models):
            for folder, folders, names in os.walk(place, followlinks=True):
                _leave_out_circles(folder, folders)
                for name in sorted(names):
                    found[name.lower()].append(Path(folder, name))
        return found

    @cached_property
    def _tops(self) -> set[Path]:
        """The folders that are not models themselves."""
        return {
            self.folder.resolve(),
            self.folder.parent.resolve(),
            *(root.resolve() for root in self.roots()),
        }


def _main_script(folder: Path, name: str) -> Path | None:
    """Return the main file of a brain: one named like its folder, else the least deep one.

    Args:
        folder: that it is in.
        name: that the file may have too.
    """
    found = [path for end in _BRAINS for path in sorted(folder.rglob(f"*{end}")) if path.stem != "__init__"]
    named = [path for path in found if path.stem in ("model", name, path.parent.name)]
    return min(named or found, key=lambda path: len(path.parts), default=None)


def _leave_out_circles(folder: str, folders: list[str]) -> None:
    """Exclude cyclic links from a walk."""
    here = os.path.realpath(folder) + os.sep
    folders[:] = sorted(
        name for name in folders
        if name[:1] != "." and not here.startswith(os.path.realpath(Path(folder, name)) + os.sep)
    )  # fmt: skip


def _plain(name: str) -> str:
    """Return a name as parts with slashes between them, relative unless there is such a file."""
    if Path(name).is_file():
        return name
    for scheme in _SCHEMES:
        name = name.removeprefix(scheme)
    return name.strip().replace("\\", "/").lstrip("/")
