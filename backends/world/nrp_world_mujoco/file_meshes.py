"""Meshes that MuJoCo reads itself: from their own files, or as an MJCF file lists their corners.

It centres each mesh, turns it along its principal axes and rounds it. The hull of a mesh that went through
that before has its corners in other places and in another order, so that other ones touch.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.origin import Native
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.mechanisms import BuiltParts, copy_all, parsed, pose_of, written
from nrp_world_mujoco.shapes import placed


def files_of(spec: Any, path: Path) -> dict[str, dict[str, str]]:
    """Return the attributes of the meshes of an MJCF file, by name, without those whose file is not there.

    Args:
        spec: the specification that MuJoCo read.
        path: the file; those of meshes are given relative to it.
    """
    usual = mujoco.MjSpec().add_mesh()
    found = {}
    for mesh in spec.meshes:
        file = Path(spec.meshdir) / (Path(mesh.file).name if spec.strippath else mesh.file)
        if mesh.file:
            if not (path.parent / file).is_file():
                continue
            values = {"file": str(file)}
        else:
            lists = {"vertex": mesh.uservert, "face": mesh.userface}
            values = {
                name: " ".join(f"{each:.9g}" for each in given) for name, given in lists.items() if len(given)
            }
        for name in ("scale", "refpos", "refquat", "maxhullvert"):
            given = getattr(mesh, name)
            if np.any(given != getattr(usual, name)):
                values[name] = " ".join(f"{number:.17g}" for number in np.ravel(given))
        if mesh.inertia != usual.inertia:
            values["inertia"] = mesh.inertia.name.rpartition("_")[2].lower()
        found[mesh.name] = values
    return found


class FileMeshes:
    """Adds meshes from files to a specification.

    Args:
        spec: the specification.
    """

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self._names: dict[str, str] = {}

    def add(self, model: str, element: Native) -> None:
        """Add the mesh of a ``<mujoco:mesh>``: a file, relative to that of the element, or its corners.

        Raises:
            SceneError: the element is invalid.
        """
        name, file = element.attribute("name"), element.attribute("file")
        if not name or not (file or element.attribute("vertex")):
            raise element.error('it needs name="...", and file="..." or vertex="..."')
        section = ET.Element("asset")
        part = written(element)
        if file:
            part.set("file", str((element.path or Path()).parent.resolve() / file))
        section.append(part)
        mesh = self._spec.add_mesh(name=f"{model}/{name}/mesh")
        copy_all(parsed(element, section).meshes[0], mesh)
        self._names[f"{model}/{name}"] = mesh.name

    def use(self, element: Native, geoms: Iterable[Any], parts: BuiltParts) -> None:
        """Give shapes the mesh, and the pose, that a ``<mujoco:geom>`` states.

        Raises:
            SceneError: the element is invalid.
        """
        model, name = parts.model.name, element.attribute("mesh") or ""
        mesh = self._names.get(f"{model}/{name}")
        if mesh is None:
            known = [full.removeprefix(f"{model}/") for full in self._names]
            raise element.error(f"the model has no <mujoco:mesh> '{name}'{did_you_mean(name, known)}")
        _, place = parts.links[element.attribute("link") or ""]
        for geom in geoms:
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, mesh
            for field, value in placed(place @ pose_of(element)).items():
                setattr(geom, field, value)

    def finish(self) -> None:
        """Delete the meshes that no shape has any more."""
        used = {geom.meshname for geom in self._spec.geoms} if self._names else set()
        for mesh in [mesh for mesh in self._spec.meshes if self._names and mesh.name not in used]:
            self._spec.delete(mesh)


def pose_in_file(model: Any, geom: int) -> Mapping[str, Any]:
    """Return the pose of a shape with a mesh as its file has it, before MuJoCo moves it with the mesh."""
    mesh = int(model.geom_dataid[geom])
    back, turn, position, offset = np.empty(4), np.empty(4), np.empty(3), np.empty(3)
    mujoco.mju_negQuat(back, model.mesh_quat[mesh])
    mujoco.mju_mulQuat(turn, model.geom_quat[geom], back)
    mujoco.mju_rotVecQuat(offset, model.mesh_pos[mesh], turn)
    np.subtract(model.geom_pos[geom], offset, out=position)
    return {"pos": position, "quat": turn}
