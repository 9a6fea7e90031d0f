"""Launch files of ROS, of which the models that they spawn take part; programs are not started.

``roslaunch`` is documented at http://wiki.ros.org/roslaunch/XML, the node ``spawn_model`` in ``gazebo_ros``.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from nrp_core.errors import ExperimentError
from nrp_core.xml import Element, read_xml
from nrp_legacy.documents import ROBOT, PoseNumbers, attribute, local
from nrp_legacy.files import Library

_ARGUMENT: Final = re.compile(r"\$\((\w+)\s*([^()\s]*)\s*([^()]*)\)")
"""``$(arg NAME)``, ``$(find PACKAGE)``, ``$(env NAME)``, ``$(optenv NAME DEFAULT)``, ``$(dirname)``."""
_AXES: Final = ("-x", "-y", "-z", "-R", "-P", "-Y")
_MODEL: Final = re.compile(r"[^\s'\"=]+\.(?:urdf|xacro|sdf)\b")
"""The file that a command prints or converts: ``cat robot.urdf``, ``xacro 'robot.urdf.xacro' a:=1``."""


@dataclass(frozen=True, slots=True)
class Spawned:
    """A model that a launch file spawns.

    Args:
        name: its name.
        file: its file, or None if it is missing.
        pose: its initial pose.
        element: the node that spawns it.
    """

    name: str
    file: Path | None
    pose: PoseNumbers
    element: Element


def spawned_models(path: Path, library: Library) -> list[Spawned]:
    """Return the models that a launch file and those that it includes spawn.

    Args:
        path: the launch file.
        library: the search path for files of packages.

    Raises:
        ExperimentError: a file is not XML.
    """
    launch = _Launch(library)
    launch.read(path, {})
    return [launch.spawned(node, words) for node, words in launch.spawners]


@dataclass
class _Launch:
    library: Library
    descriptions: dict[str, str] = field(default_factory=dict)
    """The texts that name the model of each parameter."""
    spawners: list[tuple[Element, list[str]]] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)

    def read(self, path: Path, given: Mapping[str, str]) -> None:
        """Read a file, given values of its arguments."""
        if path in self.files:
            return
        self.files.append(path)
        self._block(read_xml(path, ExperimentError), {"dirname": str(path.parent), **given}, given)

    def _block(self, parent: Element, known: dict[str, str], given: Mapping[str, str]) -> None:
        for element in parent.children:
            values = {local(name): self._text(value, known) for name, value in element.attributes.items()}
            if values.get("if") in ("0", "false") or values.get("unless") in ("1", "true"):
                continue
            match local(element.tag):
                case "group":
                    self._block(element, dict(known), given)
                case "arg":
                    default = values.get("value", values.get("default", ""))
                    known[values.get("name", "")] = given.get(values.get("name", ""), default)
                case "param":
                    said = (values.get(key) for key in ("textfile", "command", "value"))
                    name = values.get("name", "").rpartition("/")[2]
                    self.descriptions[name] = next((one for one in said if one), "")
                case "include":
                    passed = {
                        attribute(one, "name") or "": self._text(attribute(one, "value") or "", known)
                        for one in element.children
                    }
                    found = self._file(values.get("file", ""))
                    if found is not None:
                        self.read(found, passed)
                case "node":
                    if "spawn_model" in values.get("type", ""):
                        self.spawners.append((element, shlex.split(values.get("args", ""))))

    def _text(self, text: str, known: Mapping[str, str]) -> str:
        """Return a text in which arguments have their values."""

        def value(match: re.Match[str]) -> str:
            kind, name, rest = match.groups()
            variables = {**self.library.environment(), **os.environ}
            values = {"find": name, "arg": known.get(name, ""), "dirname": known.get("dirname", "")}
            return values.get(kind, variables.get(name, rest.strip()))

        return _ARGUMENT.sub(value, text)

    def _file(self, name: str) -> Path | None:
        """Return a file; its name begins with that of its package."""
        found = self.library.find_data(name.removeprefix("file://"))
        package = Path(name).parts[0] if name else ""
        is_of_it = found is not None and (Path(name).is_absolute() or package in found.parts)
        return found if found is not None and found.is_file() and is_of_it else None

    def spawned(self, node: Element, words: list[str]) -> Spawned:
        """Return the model that a node spawns, given its arguments."""
        after = dict(zip(words, [*words[1:], ""], strict=True))
        said = after.get("-file") or self.descriptions.get(after.get("-param", "").rpartition("/")[2], "")
        model = _MODEL.search(said)
        return Spawned(
            after.get("-model", ROBOT), model and self._file(model.group()),
            tuple(_number(after.get(axis, "")) for axis in _AXES), node,  # type: ignore[arg-type]
        )  # fmt: skip


def _number(text: str) -> float:
    try:
        return float(text or 0.0)
    except ValueError:
        return 0.0
