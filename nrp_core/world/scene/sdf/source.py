"""Open and check files of SDF or URDF, and the files that they include."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from nrp_core._support.archives import unpacked
from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.formats import read_added
from nrp_core.world.scene.reading.left_out import leave_out
from nrp_core.world.scene.reading.repeated import check_repeated
from nrp_core.world.scene.reading.resources import main_file
from nrp_core.world.scene.reading.xml import Element, read_xml
from nrp_core.world.scene.sdf.params import change_included
from nrp_core.world.scene.sdf.vocabulary import check_names, check_vocabulary
from nrp_core.world.scene.urdf import to_sdf
from nrp_core.world.scene.urdf.expand import expanded, is_xacro

OLDEST, NEWEST = (1, 4), (1, 12)
_SCOPES_RESERVED = (1, 8)
"""The first version in which no name may contain ``::``."""


@dataclass(frozen=True, slots=True)
class Source:
    """A file.

    Args:
        root: its ``<sdf>``; for URDF the equivalent one.
        version: the version of SDF.
        trail: the chain of including files, this one last.
    """

    root: Element
    version: tuple[int, int]
    trail: tuple[Path, ...]

    @classmethod
    def open(cls, path: Path, reading: Reading, trail: tuple[Path, ...] = ()) -> Source:
        """Read a file, also one in an archive or written in xacro.

        Raises:
            SceneError: it does not exist, is not well-formed, or is neither SDF nor URDF.
        """
        if path.suffix.lower() == ".zip":
            path = _in_archive(path)
        root = read_xml(path)
        leave_out(root, reading.without)
        written = root.tag in ("sdf", "gazebo")
        expands = root.tag == "robot" and is_xacro(root)
        if reading.args and not trail and not expands:
            raise root.error("this is not a xacro file, so it has no arguments")
        if expands:
            root = expanded(path, partial(reading.resources.package, user=path), reading.args)
        check_repeated(root, reading.notes)
        if root.tag == "robot":
            root = to_sdf(root, reading.notes)
        if root.tag not in ("sdf", "gazebo"):
            root = read_added(root, reading.notes) or root
        if root.tag not in ("sdf", "gazebo"):
            raise root.error(f"this is neither SDF nor URDF: its root is <{root.tag}>")
        if root.tag == "gazebo":
            root = root.find("sdf") or root  # which it may contain, or be by its old name
            root.attributes.setdefault("version", "1.4")
        check_vocabulary(root, reading.notes)
        version = _version(root, reading)
        if written and version >= _SCOPES_RESERVED:
            check_names(root)
        return cls(root, version, (*trail, path.resolve()))

    def include(self, include: Element, reading: Reading) -> Source | None:
        """Open the file that an ``<include>`` refers to; None if it is missing and the reading is lenient.

        Raises:
            SceneError: it is missing, cannot be changed as the include says, or includes form a cycle.
        """
        uri = include.require("uri")
        if reading.lenient and uri.text and reading.resources.locate(uri) is None:
            reading.notes.warn(include, Code.NRP260, f"there is no '{uri.text}': left out", subject=uri.text)
            return None
        path = reading.resources.model_file(uri)
        if path.resolve() in self.trail:
            circle = " -> ".join(file.name for file in (*self.trail, path))
            raise include.error(f"files include each other in a cycle: {circle}")
        source = Source.open(path, reading, self.trail)
        change_included(source.root.find("world") or source.root, include)
        return source


def _in_archive(archive: Path) -> Path:
    """Return the file of the model in an archive."""
    found = main_file(unpacked(archive, SceneError))
    if found is None:
        raise SceneError("the archive holds no SDF or URDF file", path=archive)
    return found


def _version(root: Element, reading: Reading) -> tuple[int, int]:
    text = root.attribute("version")
    match = re.fullmatch(r"(\d+)\.(\d+)(\.\d+)?", text)
    if match is None:
        raise root.error(f"an SDF version must be written like '1.9', not '{text}'")
    version = int(match[1]), int(match[2])
    if not OLDEST <= version <= NEWEST:
        reading.notes.warn(
            root, Code.NRP263, f"SDF {text} is not a supported version; supported: 1.4 to 1.12"
        )
    return version
