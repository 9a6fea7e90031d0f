"""Find the files that an experiment names: in its folder, then in folders of models; also in archives."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from filecmp import cmp
from functools import cached_property, partial
from pathlib import Path, PurePosixPath

from nrp_core.archives import unpack
from nrp_core.scene.reading.context import main_file
from nrp_legacy.documents import FileNamed

_STAND_INS = Path(__file__).with_name("stand_ins")
EMPTY_ROOM, NO_BRAIN = _STAND_INS / "empty_room.sdf", _STAND_INS / "no_brain.py"
"""Replacements for files that are not found."""
_SHELVES = ("", "robots", "brains", "environments", "bibi", "brain_model")
"""Folders of a model library in which its models stand."""
_BRAINS = (".py", ".h5")
_FORMATS = {".sdf": (".urdf", ".urdf.xacro", ".xacro"), ".urdf": (".sdf", ".urdf.xacro", ".xacro")}
"""Formats of robots and rooms, and those in which another owner may have the same model."""
_SHARED = ("model", "__init__")
"""Stems of files that every model or package has, so that they do not identify one."""
_LEVELS = 3
"""The number of folders above an experiment in which a library may stand."""
_STORAGE = "storage://"
_STORAGE_FOLDER = "nrpStorage"
"""The folder of the platform that held the folders of experiments."""
_SCHEMES = (_STORAGE, "model://", "package://", "file://")


def installed_models() -> list[Path]:
    """Return the folder of models in the environment variables of a platform installation, if any."""
    said = (Path(os.environ.get("NRP_MODELS_DIRECTORY") or "/"), Path(os.environ.get("HBP") or "/", "Models"))
    return [folder for folder in said if folder != Path("/") and folder.is_dir()][:1]


def models_beside(folder: Path) -> list[Path]:
    """Return the folders ``Models`` in and beside an experiment, and in those above it, up to its repository.

    Args:
        folder: the folder of the experiment.
    """
    places = [folder / "resources", *_folders_above(folder)]
    return [found for place in places for found in sorted(place.glob("[Mm]odels")) if found.is_dir()]


def _folders_above(folder: Path) -> Iterator[Path]:
    """Yield a folder and those above it, up to that of its repository."""
    for above in (folder, *folder.parents[:_LEVELS]):
        yield above
        if any(above.glob(".git")):
            break


class Library:
    """The folders in which files are searched.

    Args:
        folder: the folder of the experiment.
        models: the folders of model libraries, in order of search.

    Attributes:
        elsewhere: the files that were found by their names alone, or in another format, by the names that
            were given.
    """

    def __init__(self, folder: Path, models: Sequence[Path] = ()) -> None:
        self.folder = folder
        self.elsewhere: dict[str, Path] = {}
        self._models = [found for path in models for found in (path, path / "Models") if found.is_dir()]

    @property
    def has_models(self) -> bool:
        """Whether a folder of models exists."""
        return bool(self._models)

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
        return self._first(named.names, named.folders) or self._by_name_alone(named.name)

    def find_code(self, name: str) -> Path | None:
        """Return a file of code by its name."""
        return self._first((name,)) or self._by_name_alone(name)

    def find_data(self, name: str) -> Path | None:
        """Return a file or folder that code names."""
        plain = _plain(name).rstrip("/")
        if not plain:
            return None
        places = (*self._candidates(plain), *self._in_experiment(plain))
        found = next((place.resolve() for place in places if place.exists()), None)
        if found is None and PurePosixPath(plain).name == _STORAGE_FOLDER:
            return self.folder.parent
        return found or self.find_code(plain)

    def find_mesh(self, uri: str) -> Path | None:
        """Find a mesh or an image of a model that is missing at its path in the whole repository.

        Its path must end with as many parts of the name as any; there must be only one, or copies of one.
        """
        parts = [part.lower() for part in _parts(uri)]
        named = {path.resolve(): path for path in self._meshes.get(parts[-1], ())} if parts else {}
        ends = (parts[i:] for i in range(len(parts)))
        alike = (
            [path for path in named.values() if path.is_file() and _ends_with(path, end)] for end in ends
        )
        copies = next(filter(None, alike), [])
        if not copies or not _are_copies(copies):
            return None
        self._found_elsewhere(uri.rpartition("/")[0] or uri, copies[0].parent)
        return copies[0]

    def find_sdf(self, named: FileNamed) -> Path | None:
        """Return the file of a robot or room, unpacked if it is in an archive."""

        def main(folder: Path, _name: str) -> Path | None:
            wanted = PurePosixPath(_plain(named.name))
            found = next((path for path in sorted(folder.rglob(wanted.name)) if path.is_file()), None)
            is_other = wanted.suffix.lower() in _FORMATS and not _is_shared(wanted.name)
            other = None if found else main_file(folder)
            return found or (self._found_elsewhere(named.name, other) if is_other else other)

        names = []
        for name in named.names:
            names += [name, f"{name}/model.sdf", f"{name}/{Path(name).name}.sdf", f"{name}.sdf"]
            if name.endswith(".sdf"):
                names += [f"{folder}.zip" for folder in (Path(name).parent.name, *named.folders) if folder]
            names += [name.removesuffix(".zip")] if name.endswith(".zip") else []
        path = PurePosixPath(named.name)
        others = [str(path.with_suffix(end)) for end in _FORMATS.get(path.suffix.lower(), ())]
        found = self._main(names, named.folders, main)
        found = found or self._found_elsewhere(named.name, self._first(others, named.folders))
        return (
            found
            or self._by_name_alone(*names)
            or self._by_name_alone(*others, meant=named.name)
            or self._only_model(named.name)
        )

    def find_brain(self, named: FileNamed) -> Path | None:
        """Return the file of a brain, unpacked if it is in an archive."""
        others = (f"{name}{end}" for name in named.names for end in (f"/{Path(name).name}.py", ".py", ".h5"))
        names = [*named.names, *others]
        return self._main(names, named.folders, _main_script) or self._by_name_alone(*names)

    def _main(
        self, names: Sequence[str], inner: Sequence[str], main: Callable[[Path, str], Path | None]
    ) -> Path | None:
        """Return the first file that exists; for an archive or a folder, its main file."""
        path = self._first(names, inner)
        if path is not None:
            return path if path.suffix.lower() != ".zip" else main(unpack(path), path.stem)
        places = (place for name in names for place in self._candidates(_plain(name), inner))
        folders = (place for place in places if place.is_dir() and place.resolve() not in self._tops)
        return next((file for folder in folders if (file := main(folder, folder.name))), None)

    def _first(self, names: Iterable[str], folders: Sequence[str] = ()) -> Path | None:
        """Return the first file that exists.

        Args:
            names: relative to the experiment, or to a folder of models; ``storage://experiment/file`` is a
                file of the experiment.
            folders: the folders that they may be in.
        """
        given = list(names)
        for find in (partial(self._in_place, folders=folders), self._of_experiment, self._by_its_end):
            found = next((path for name in given if (path := find(name))), None)
            if found is not None:
                return found.resolve()
        return None

    def _in_place(self, name: str, folders: Sequence[str]) -> Path | None:
        return next((path for path in self._candidates(_plain(name), folders) if path.is_file()), None)

    def _of_experiment(self, name: str) -> Path | None:
        found = next((path for path in self._in_experiment(_plain(name)) if path.is_file()), None)
        if found is None or found.parent != self.folder or name.startswith(_STORAGE):
            return found
        return self._found_elsewhere(name, found) if _is_shared(found.name) else found

    def _candidates(self, name: str, folders: Sequence[str] = ()) -> Iterator[Path]:
        shelves = (library / shelf for library in self._models for shelf in _SHELVES)
        for place in (self.folder, self.folder / "resources", self.folder.parent, *shelves):
            yield from (place / folder / name for folder in folders)
            yield place / name

    def _in_experiment(self, name: str) -> Iterator[Path]:
        """Yield where ``storage://experiment/file`` and ``../Experiments/experiment/file`` are."""
        rest = name.split("/")
        return (self.folder.joinpath(*rest[i:]) for i in range(1, len(rest)))

    def _by_its_end(self, name: str) -> Path | None:
        """Return the first file whose path ends with these parts, ignoring case.

        Leading folders may be missing here, such as folders or variables of another machine. At least a
        folder and a file must match.
        """
        parts = [part.lower() for part in _parts(name)]
        for i in range(len(parts) - 1):
            end = parts[i:]
            for path in self._files_named(parts[-1]):
                if _ends_with(path, end):
                    return path
        return None

    def _by_name_alone(self, *names: str, meant: str = "") -> Path | None:
        """Return the file of one of these names, ignoring case and folders, for the name that is meant.

        The experiment, or else its libraries together, must have only one, or copies of one.
        """
        for name in names:
            parts = _parts(name)
            found = [] if not parts or _is_shared(parts[-1]) else self._files_named(parts[-1])
            own = [path for path in found if path.is_relative_to(self.folder)]
            copies = own or found
            if copies and _are_copies(copies):
                return (
                    copies[0] if own and len(parts) == 1 else self._found_elsewhere(meant or name, copies[0])
                )
        return None

    def _only_model(self, name: str) -> Path | None:
        """Return the only ``model.sdf`` of the experiment for one in a folder of a similar name."""
        *_, folder, file = ("", *_parts(name))
        own = [path for path in self._files_named(file) if path.is_relative_to(self.folder)]
        if not folder or len(own) != 1:
            return None
        ends = sorted((folder.lower(), own[0].parent.name.lower()), key=len)
        return self._found_elsewhere(name, own[0]) if ends[1].startswith(ends[0]) else None

    def _found_elsewhere(self, name: str, path: Path | None) -> Path | None:
        if path is not None:
            self.elsewhere[name] = path
        return path

    def _files_named(self, name: str) -> list[Path]:
        """Return the files of a name, ignoring case, without links to files of another machine."""
        return [path for path in self._files.get(name.lower(), ()) if path.is_file()]

    @cached_property
    def _files(self) -> Mapping[str, list[Path]]:
        """All files of the experiment and the libraries by their lower-case names."""
        return _files_in((self.folder, *self._models))

    @cached_property
    def _meshes(self) -> Mapping[str, list[Path]]:
        """All files of the libraries and of the repository of the experiment by their lower-case names."""
        *_, top = _folders_above(self.folder)
        return _files_in((top if any(top.glob(".git")) else self.folder, *self._models))

    @cached_property
    def _tops(self) -> set[Path]:
        """The folders that are not models themselves."""
        return {
            self.folder.resolve(),
            self.folder.parent.resolve(),
            *(root.resolve() for root in self.roots()),
        }


def _files_in(places: Iterable[Path]) -> Mapping[str, list[Path]]:
    """Return all files in folders by their lower-case names."""
    found = defaultdict[str, list[Path]](list)
    for place in places:
        for folder, folders, names in os.walk(place, followlinks=True):
            _leave_out_circles(folder, folders)
            for name in sorted(names):
                found[name.lower()].append(Path(folder, name))
    return found


def _ends_with(path: Path, parts: Sequence[str]) -> bool:
    """Return whether a path ends with these parts, ignoring case; they are in lower case."""
    return [part.lower() for part in path.parts[-len(parts) :]] == list(parts)


def _are_copies(paths: Sequence[Path]) -> bool:
    return all(cmp(paths[0], path, shallow=False) for path in paths[1:])


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


def _parts(name: str) -> list[str]:
    """Return the parts of a name that another machine may have, too."""
    return [part for part in PurePosixPath(_plain(name)).parts if part not in ("..", ".", "/")]


def _is_shared(name: str) -> bool:
    return PurePosixPath(name).stem.lower() in _SHARED
