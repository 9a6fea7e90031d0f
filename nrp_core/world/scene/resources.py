"""Files that a robot or a room refers to: ``model://``, ``package://``, ``file://`` and plain paths.

Looked for, in this order: beside the file that refers to them, in the folder above it, in the folders given
by the user, in those of the environment variables that Gazebo users have set, and among the few
standard models that ship here (``ground_plane``, ``sun``).
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from nrp_core.world.scene.xml_tree import Element, read_xml

ENVIRONMENT = ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "GAZEBO_RESOURCE_PATH")
SHIPPED = Path(__file__).with_name("models")

_SCHEMES = ("model", "package", "file")


class Resources:
    """Where files are looked for.

    Args:
        search_path: folders of the user, first come first.
    """

    def __init__(self, search_path: Iterable[Path | str] = ()) -> None:
        variables = [os.environ.get(name, "") for name in ENVIRONMENT]
        from_environment = [folder for value in variables for folder in value.split(os.pathsep) if folder]
        self._folders = [*map(Path, search_path), *map(Path, from_environment), SHIPPED]

    def find(self, uri: Element) -> Path | None:
        """Return the file that a ``<uri>`` refers to, None where there is none."""
        return next((path for path in self._candidates(uri) if path.is_file()), None)

    def model_file(self, uri: Element) -> Path:
        """Return the SDF file that a ``<uri>`` refers to, itself or by the folder of a model.

        Raises:
            SceneError: there is none.
        """
        if not uri.text:
            raise uri.error(f"the <{uri.tag}> is empty")
        path = next((path for path in self._candidates(uri) if path.exists()), None)
        if path is None:
            folders = dict.fromkeys(str(path.parent) for path in self._candidates(uri))
            looked = f"looked in {', '.join(folders)}" if folders else "only files of this machine are read"
            raise uri.error(f"there is no '{uri.text}'; {looked}")
        return _model_in(path, uri) if path.is_dir() else path

    def _candidates(self, uri: Element) -> Iterator[Path]:
        scheme, separator, rest = uri.text.partition("://")
        if separator and scheme not in _SCHEMES:
            return
        beside = uri.path.parent
        for folder in (beside, beside.absolute().parent, *self._folders):
            yield folder / (rest if separator else uri.text)


def _model_in(folder: Path, element: Element) -> Path:
    """Return the newest SDF file of a model's folder."""
    config = folder / "model.config"
    if config.exists():
        files = [(_version(sdf), folder / sdf.text) for sdf in read_xml(config).all("sdf")]
        if files:
            return max(files)[1]
    plain = folder / "model.sdf"
    if not plain.exists():
        raise element.error(f"the folder {folder} holds neither a model.config nor a model.sdf")
    return plain


def _version(sdf: Element) -> tuple[int, ...]:
    return tuple(int(part) for part in sdf.attributes.get("version", "0").split(".") if part.isdigit())
