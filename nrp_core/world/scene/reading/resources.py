"""Find the files that robots and rooms refer to: ``model://``, ``package://``, ``file://`` and plain paths.

They are searched in this order: beside the file that refers to them, in its parent folder, in the folders
given by the user, in those of the environment variables of Gazebo and ROS, among the standard models that
ship here (``ground_plane``, ``sun``), then in the folders above the file that have the name of the model
or package, and last among the packages of the ROS workspace that the file is in.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from nrp_core.errors import SceneError
from nrp_core.world.scene.reading.workspaces import in_workspace, package_name
from nrp_core.world.scene.reading.xml import Element, read_xml

ENVIRONMENT = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
    "ROS_PACKAGE_PATH",
)
INSTALLED = "AMENT_PREFIX_PATH"
"""Variable of ROS 2: folders with installed packages in ``share``."""
SHIPPED = Path(__file__).parents[1] / "models"

_SCHEMES = ("model", "package", "file")
_MAIN_FILES = (".sdf", ".world", ".urdf", ".xacro")


class Resources:
    """The places where files are searched.

    Args:
        search_path: folders given by the user, in order.
    """

    def __init__(self, search_path: Iterable[Path | str] = ()) -> None:
        variables = [folder for name in ENVIRONMENT for folder in _folders_in(name)]
        installed = [folder / "share" for folder in _folders_in(INSTALLED)]
        self._of_user = list(map(Path, search_path))
        self._folders = [*self._of_user, *variables, *installed, SHIPPED]

    def find(self, uri: Element) -> Path | None:
        """Return the file that a ``<uri>`` refers to, None if it does not exist."""
        return next((path for path in self._candidates(uri.text, uri.path) if path.is_file()), None)

    def media(self) -> list[Path]:
        """Return the folders of the user in which scripts of materials and their textures are looked for."""
        inner = ("", "materials/scripts", "materials/textures")
        return [place for folder in self._of_user for each in inner if (place := folder / each).is_dir()]

    def locate(self, uri: Element) -> Path | None:
        """Return the file or folder that a ``<uri>`` refers to, None if it does not exist."""
        return next((path for path in self._candidates(uri.text, uri.path) if path.exists()), None)

    def model_file(self, uri: Element) -> Path:
        """Return the model file that a ``<uri>`` refers to, directly or by the folder of the model.

        Raises:
            SceneError: it does not exist.
        """
        if not uri.text:
            raise uri.error(f"the <{uri.tag}> is empty")
        candidates = list(self._candidates(uri.text, uri.path))
        path = next((path for path in candidates if path.exists()), None)
        if path is None:
            folders = dict.fromkeys(str(path.parent) for path in candidates)
            looked = f"looked in {', '.join(folders)}" if folders else "only files of this machine are read"
            raise uri.error(f"there is no '{uri.text}'; {looked}")
        if not path.is_dir():
            return path
        found = listed_file(path)
        if found is None:
            raise uri.error(f"the folder {path} holds neither a model.config nor a model.sdf")
        return found

    def package(self, name: str, user: Path) -> Path:
        """Return the folder of a ROS package that a file refers to.

        Raises:
            SceneError: it does not exist.
        """
        for folder in self._candidates(f"package://{name}", user):
            if folder.is_dir():
                return folder
        for folder in user.absolute().parents:
            if folder.name == name or package_name(folder) == name:
                return folder
        raise SceneError(f"there is no package '{name}' in the search path", path=user)

    def _candidates(self, uri: str, user: Path) -> Iterator[Path]:
        scheme, separator, rest = uri.partition("://")
        if separator and scheme not in _SCHEMES:
            return
        beside = user.absolute().parent
        for folder in (user.parent, beside.parent, *self._folders):
            yield folder / (rest if separator else uri)
        if scheme in ("model", "package") and separator:
            name, _, inner = rest.partition("/")
            yield from (folder / inner for folder in (beside, *beside.parents) if folder.name == name)
            yield from (folder / inner for folder in (beside, beside.parent) if inner)  # another name
            if name:
                yield from (folder / inner for folder in in_workspace(name, user))
            else:  # package:///meshes/a.stl is in the package of the file
                yield from (folder / inner for folder in beside.parents)


def main_file(folder: Path) -> Path | None:
    """Return the file of the model or room in a folder: the one it lists, else the least deep one."""
    configs = sorted(folder.rglob("model.config"), key=_depth)
    if configs:
        return listed_file(configs[0].parent)
    named = (sorted(folder.rglob(f"*{suffix}"), key=_depth) for suffix in _MAIN_FILES)
    return next((files[0] for files in named if files), None)


def listed_file(folder: Path) -> Path | None:
    """Return the SDF file with the newest version in a model's folder, None if it has none."""
    config = folder / "model.config"
    if config.exists():
        files = [(_version(sdf), folder / sdf.text) for sdf in read_xml(config).all("sdf")]
        if files:
            return max(files)[1]
    plain = folder / "model.sdf"
    return plain if plain.exists() else None


def _folders_in(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _depth(path: Path) -> tuple[int, str]:
    return len(path.parts), str(path)


def _version(sdf: Element) -> tuple[int, ...]:
    return tuple(int(part) for part in sdf.attributes.get("version", "0").split(".") if part.isdigit())
