"""Find the files that an experiment names: beside it, then in the folders of models; in archives too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from nrp_core.archives import unpacked

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

    def find(self, name: str, *, model: str | None = None) -> Path | None:
        """Return a file by the name that a document gives it, or None.

        Args:
            name: relative to the experiment, or to a folder of models; ``storage://experiment/file`` is a
                file of the experiment.
            model: the model of a library that it belongs to.
        """
        plain = _plain(name)
        for path in self._candidates(plain, model):
            if path.is_file():
                return path.resolve()
        return self._by_its_end(plain)

    def find_sdf(self, name: str, *, model: str | None = None) -> Path | None:
        """Return the file of a robot or room; of an archive, the one that it unpacks to."""
        names = [name, f"{name}/model.sdf", f"{name}/{Path(name).name}.sdf"]
        if name.endswith(".sdf"):
            names.append(f"{Path(name).parent.name or model}.zip")
        path = next((path for one in names if (path := self.find(one, model=model))), None)
        return path if path is None or path.suffix != ".zip" else _inside(path, (".sdf", ".urdf"))

    def find_brain(self, name: str, *, model: str | None = None) -> Path | None:
        """Return the file of a brain; of an archive, the one that it unpacks to."""
        path = self.find(name, model=model)
        return path if path is None or path.suffix != ".zip" else _inside(path, (".py", ".h5"))

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
        """Return the one file of the libraries whose path ends so."""
        end = [part for part in Path(name).parts if part not in ("..", ".", "/")]
        if not end:
            return None
        found = (path for library in self._models for path in sorted(library.rglob(end[-1])))
        return next((path.resolve() for path in found if list(path.parts[-len(end) :]) == end), None)


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
