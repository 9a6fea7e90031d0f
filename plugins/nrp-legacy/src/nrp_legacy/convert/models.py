"""Rooms and robots of an imported experiment, with the models that they refer to."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from xml.sax.saxutils import quoteattr

from nrp_core.world.scene.devices import JointController, TrajectoryController
from nrp_legacy.files import Library

MODELS = "models"
_REFERENCE = re.compile(r"(?:model|package)://([\w.-]+)")
_TEXTS = (".sdf", ".urdf", ".world", ".xacro")


class Models:
    """Copies models into a folder, each once.

    Args:
        library: the search path for models.
        folder: the folder of the imported experiment.
    """

    def __init__(self, library: Library, folder: Path) -> None:
        self._library, self._folder = library, folder
        self._copied: set[Path] = set()

    def copy(self, path: Path) -> str:
        """Copy a room or robot and what it refers to; return its file, relative to the folder."""
        if path.parent in (self._library.folder, self._library.folder.parent):
            shutil.copy(path, self._folder / path.name)
            self._follow(path)
            return path.name
        self._copy_folder(path.parent)
        return f"{MODELS}/{path.parent.name}/{path.name}"

    def _copy_folder(self, source: Path) -> None:
        if source in self._copied:
            return
        self._copied.add(source)
        shutil.copytree(source, self._folder / MODELS / source.name, dirs_exist_ok=True)
        for path in sorted(source.rglob("*")):
            if path.suffix in _TEXTS:
                self._follow(path)

    def _follow(self, path: Path) -> None:
        for name in dict.fromkeys(_REFERENCE.findall(path.read_text("utf-8", "replace"))):
            found = (root / name for root in self._library.roots())
            folder = next((folder for folder in found if folder.is_dir()), None)
            if folder is not None:
                self._copy_folder(folder.resolve())


def add_controllers(
    path: Path, controllers: list[JointController], followers: list[TrajectoryController]
) -> bool:
    """Write controllers of joints into the file of a robot; return whether this succeeded."""
    text = path.read_text("utf-8")
    before, end, after = text.rpartition("</model>")
    if not end:
        return False
    lines = [
        f"    <controller joint_name={quoteattr(one.joint)}><type>{one.kind}</type>"
        f"<topic>{one.topic}</topic></controller>"
        for one in controllers
    ]
    plugin = [
        '<plugin name="commanded_joints" filename="libgeneric_controller_plugin.so">',
        *lines,
        "  </plugin>",
    ]
    added = [*(plugin if lines else []), *map(_plugin, followers)]
    path.write_text(before + "  " + "\n".join(added) + "\n  " + end + after, encoding="utf-8")
    return True


def _plugin(follower: TrajectoryController) -> str:
    joints = "".join(f"<joint_name>{joint}</joint_name>" for joint in follower.joints)
    return (
        f'<plugin name={quoteattr(follower.name)} filename="gz-sim-joint-trajectory-controller-system">'
        f"<topic>{follower.command_topic}</topic>{joints}</plugin>"
    )
