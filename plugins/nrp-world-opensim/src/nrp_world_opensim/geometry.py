"""The shapes of a file of OpenSim that are drawn, as visuals of SDF."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import opensim
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.utilities import cached_folder
from nrp_core.world import FloatArray, Pose
from nrp_core.xml import read_xml

from nrp_world_opensim.library import pose_of, triple

_ALONG_Y = Pose((0.0, 0.0, 0.0), (-(0.5**0.5), 0.0, 0.0, 0.5**0.5))
"""OpenSim's cylinders lie along y, those of a scene along z."""
_MESH = "mesh.stl"


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape of a body.

    Args:
        pose: its pose in the frame of the body, m.
        text: geometry and material as elements of SDF.
    """

    pose: Pose
    text: str


class Shapes:
    """Converts shapes.

    Args:
        path: the file that they are in; meshes are beside it, or in its folder ``Geometry``.

    Attributes:
        left_out: the names of shapes that are not drawn, by the reason.
    """

    def __init__(self, path: Path) -> None:
        self._folder = path.parent
        self.left_out: dict[str, list[str]] = {}

    def by_frame(self, model: Any, state: Any) -> Mapping[str, list[Shape]]:
        """Return the visible shapes of each body and of the ground."""
        found: dict[str, list[Shape]] = {}
        for component in model.getComponentsList():
            geometry = opensim.Geometry.safeDownCast(component)
            if geometry is None or not geometry.get_Appearance().get_visible():
                continue
            text, turn = self._text(geometry)
            if text:
                frame = geometry.getFrame()
                place = pose_of(frame.findTransformInBaseFrame()) @ turn
                look = _material(geometry.get_Appearance())
                shape = Shape(place, f"<geometry>{text}</geometry>{look}")
                found.setdefault(frame.findBaseFrame().getName(), []).append(shape)
        return found

    def _text(self, geometry: Any) -> tuple[str, Pose]:
        """Return the geometry in SDF, empty if it cannot be drawn, and its pose in the frame of the shape."""
        kind, scale = geometry.getConcreteClassName(), triple(geometry.get_scale_factors())
        match kind:
            case "Mesh":
                return self._mesh(opensim.Mesh.safeDownCast(geometry).get_mesh_file(), scale), Pose()
            case "Sphere":
                radii = opensim.Sphere.safeDownCast(geometry).get_radius() * np.array(scale)
                if len(set(radii.tolist())) == 1:
                    return f"<sphere><radius>{radii[0]}</radius></sphere>", Pose()
                return f"<ellipsoid><radii>{_text(radii)}</radii></ellipsoid>", Pose()
            case "Ellipsoid":
                radii = np.multiply(triple(opensim.Ellipsoid.safeDownCast(geometry).get_radii()), scale)
                return f"<ellipsoid><radii>{_text(radii)}</radii></ellipsoid>", Pose()
            case "Brick":
                half = triple(opensim.Brick.safeDownCast(geometry).get_half_lengths())
                return f"<box><size>{_text(2 * np.multiply(half, scale))}</size></box>", Pose()
            case "Cylinder":
                cylinder = opensim.Cylinder.safeDownCast(geometry)
                radius, half = cylinder.get_radius() * scale[0], cylinder.get_half_height() * scale[1]
                size = f"<radius>{radius}</radius><length>{2 * half}</length>"
                return f"<cylinder>{size}</cylinder>", _ALONG_Y
            case "FrameGeometry":  # the axes of a frame
                return "", Pose()
        self._omit(f"a scene has no shapes of the kind {kind}", geometry.getName())
        return "", Pose()

    def _mesh(self, name: str, scale: tuple[float, float, float]) -> str:
        places = [self._folder / name, self._folder / "Geometry" / name]
        path = next((place for place in places if place.is_file()), None)
        if path is None:
            self._omit("it is neither beside the file nor in its folder 'Geometry'", name)
            return ""
        if path.suffix.lower() == ".vtp":
            triangles = read_vtp(path)
            if triangles is None:
                self._omit("binary files of VTK are not read", name)
                return ""
            path = _kept(triangles)
        factors = f"<scale>{_text(scale)}</scale>" if scale != (1.0, 1.0, 1.0) else ""
        return f"<mesh><uri>{escape(str(path.resolve()))}</uri>{factors}</mesh>"

    def _omit(self, what: str, name: str) -> None:
        self.left_out.setdefault(what, []).append(name)


def read_vtp(path: Path) -> FloatArray | None:
    """Return the triangles of the polygons in a file of VTK, shape ``(n, 3, 3)``; None if it is not text.

    Raises:
        SceneError: the file is not well-formed.
    """
    root = read_xml(path, kind=SceneError)
    piece = root.require("PolyData").require("Piece")
    points = piece.require("Points").all("DataArray")
    arrays = {each.attribute("Name"): each for each in piece.require("Polys").all("DataArray")}
    used = [*points, *(arrays[name] for name in ("connectivity", "offsets") if name in arrays)]
    if len(used) != 3 or any(each.attributes.get("format") != "ascii" for each in used):
        return None
    places, corners, ends = (np.array(each.text.split(), float) for each in used)
    vertices, corners = places.reshape(-1, 3), corners.astype(int)
    faces = []
    for polygon in np.split(corners, ends.astype(int)[:-1]):
        faces += [(polygon[0], polygon[i], polygon[i + 1]) for i in range(1, len(polygon) - 1)]
    triangles: FloatArray = vertices[np.array(faces, int).reshape(-1, 3)]
    return triangles


def _kept(triangles: FloatArray) -> Path:
    """Return a file with triangles, which is written once."""
    digest = hashlib.blake2b(np.ascontiguousarray(triangles).tobytes(), digest_size=16).hexdigest()

    def fill(folder: Path) -> None:
        write_stl(folder / _MESH, triangles)

    return cached_folder("opensim", digest, fill, lambda folder: (folder / _MESH).is_file()) / _MESH


def _material(appearance: Any) -> str:
    colour = _text(triple(appearance.get_color()))
    clear = f"<transparency>{1 - appearance.get_opacity()}</transparency>"
    return f"<material><diffuse>{colour} 1</diffuse></material>{clear}"


def _text(numbers: Any) -> str:
    return " ".join(repr(float(number)) for number in numbers)
