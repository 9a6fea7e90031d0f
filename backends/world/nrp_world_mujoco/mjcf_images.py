"""Images on the shapes of an MJCF file, where MuJoCo's renderer has them.

A mesh has its own texture coordinates. An image goes once around a sphere and the side of a cylinder. It is
projected through a box along each axis, and through a cylinder along z, so that every other side shows it
mirrored. The six images of a cube are projected from the middle of the shape. Where a material is not
``texuniform``, a shape other than a mesh has the image as if it were of size 1 and then scaled; MuJoCo's
manual says the opposite of cubes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.cache import cached_folder
from nrp_core.findings import Code, Findings
from nrp_core.scene.meshes import LFS
from nrp_core.scene.meshes.gltf import glb
from nrp_core.scene.meshes.triangles import Triangles, mapped_triangles
from nrp_core.scene.model import Box, Capsule, Cylinder, Geometry, Plane, Sphere
from nrp_core.scene.tessellation import triangles_of
from nrp_world_mujoco.library import mujoco

_HALF_M: Final = 0.025
"""Half of the side of the cube in the place of a mesh."""
_POINTER_BYTES: Final = 1024
_GREY: Final = (0.5, 0.5, 0.5)

_NAMED = 3
"""How many more meshes a finding names."""


def replace_missing(spec: Any, path: Path, warnings: Findings) -> None:
    """Replace missing meshes by cubes and missing images by grey, with a warning.

    Args:
        spec: the specification that MuJoCo read.
        path: the file that it read.
        warnings: receives the warnings.
    """
    lost: list[str] = []
    for mesh in spec.meshes:
        for file, lacking in _absent([mesh.file], spec.meshdir, spec, path):
            lost.append(f"'{file}' {lacking}" if not lost else f"'{file}'")
            mesh.file, mesh.scale = "", (1.0, 1.0, 1.0)
            corners = product((-_HALF_M, _HALF_M), repeat=3)
            mesh.uservert = [number for corner in corners for number in corner]
    if lost:
        first, *others = lost
        names = ", ".join(others[:_NAMED]) + (", ..." if len(others) > _NAMED else "")
        more = f" (and {len(others)} more: {names})" if others else ""
        message = f"the mesh {first}: replaced by a cube of {200 * _HALF_M:g} cm{more}"
        warnings.add(Code.NRP258, message, subject=first.split("'")[1], path=path)
    for image in spec.textures:
        for file, lacking in list(_absent([image.file, *image.cubefiles], spec.texturedir, spec, path))[:1]:
            warnings.add(Code.NRP258, f"the image '{file}' {lacking}: shown grey", subject=file, path=path)
            image.file, image.cubefiles = "", [""] * len(image.cubefiles)
            image.builtin, image.rgb1, image.rgb2 = mujoco.mjtBuiltin.mjBUILTIN_FLAT, _GREY, _GREY
            image.width = image.height = 2


def _absent(files: list[str], folder: str, spec: Any, path: Path) -> Iterator[tuple[str, str]]:
    """Yield the missing files, whose paths are relative to a folder beside the model, and what lacks them."""
    for file in filter(None, files):
        place = path.parent / folder / (Path(file).name if spec.strippath else file)
        if not place.is_file():
            yield file, "is not there"
        elif place.stat().st_size < _POINTER_BYTES and place.read_bytes().startswith(LFS):
            yield file, "is a Git LFS pointer"


_ROLES = (mujoco.mjtTextureRole.mjTEXROLE_RGB, mujoco.mjtTextureRole.mjTEXROLE_RGBA)
_CUBE = np.array([  # which axis an image is seen along, which ones it extends to the right and upwards
    [(1, 0, 0), (0, 0, -1), (0, 1, 0)],
    [(-1, 0, 0), (0, 0, 1), (0, 1, 0)],
    [(0, 1, 0), (1, 0, 0), (0, 0, -1)],
    [(0, -1, 0), (1, 0, 0), (0, 0, 1)],
    [(0, 0, 1), (1, 0, 0), (0, 1, 0)],
    [(0, 0, -1), (-1, 0, 0), (0, 1, 0)],
])  # fmt: skip
"""The faces of a cube map in their order (OpenGL 4.6, table 8.19)."""
_HALVINGS = 4
"""How often a triangle is divided that several images of a cube are on."""
_FILE, _IMAGE = "mesh.glb", "image.png"


class Images:
    """The shapes of a file with images on them.

    Args:
        model: the compiled model.
    """

    def __init__(self, model: Any) -> None:
        self._m = model
        self._kept, self._means = cache(self._written), cache(self._mean_of)
        self._seals = cache(self._seal_of)

    def on(self, geom: int) -> Path | None:
        """Return a mesh with the shape of a geom and its image.

        None for a geom without an image, for a height field, and for a capsule or a mesh without texture
        coordinates, on which a flat image would have to be distorted.
        """
        m, texture = self._m, self._texture(geom)
        material, kind = int(m.geom_matid[geom]), mujoco.mjtGeom(m.geom_type[geom])
        if texture is None or kind == mujoco.mjtGeom.mjGEOM_HFIELD:
            return None
        triangles, size = self._shape(geom, kind)
        uniform = bool(m.mat_texuniform[material])
        if mujoco.mjtTexture(m.tex_type[texture]) != mujoco.mjtTexture.mjTEXTURE_2D:
            triangles, places = _around(triangles, np.ones(3) if uniform else size)
        else:
            mapped = self._mapped(geom, kind)
            if mapped is None:
                return None
            extent = m.geom_size[geom] if kind == mujoco.mjtGeom.mjGEOM_MESH else size
            repeats = m.mat_texrepeat[material] * (extent[:2] if uniform else 1.0)
            triangles, places = (
                mapped[0],
                mapped[1] * repeats * (1, -1) + (0, 1),
            )  # MuJoCo counts from the top
        return self._kept(texture, triangles.tobytes(), places.astype(np.float32).tobytes())

    def mean(self, geom: int) -> FloatArray:
        """Return the mean red, green and blue of the image of a geom, 0..1; 1 for one without an image."""
        texture = self._texture(geom)
        return np.ones(3) if texture is None else self._means(texture)

    def _mean_of(self, texture: int) -> FloatArray:
        mean: FloatArray = self._pixels(texture).mean(axis=(0, 1)) / 255
        return mean

    def _seal_of(self, texture: int) -> bytes:
        pixels = self._pixels(texture)
        return hashlib.blake2b(pixels.tobytes() + repr(pixels.shape).encode(), digest_size=16).digest()

    def _texture(self, geom: int) -> int | None:
        material = int(self._m.geom_matid[geom])
        of_roles = [int(self._m.mat_texid[material][role]) for role in _ROLES] if material >= 0 else []
        return next((texture for texture in of_roles if texture >= 0), None)

    def _written(self, texture: int, triangles: bytes, places: bytes) -> Path | None:
        digest = hashlib.blake2b(digest_size=16)
        for part in (triangles, places, self._seals(texture)):
            digest.update(part)

        def fill(folder: Path) -> None:
            import cv2

            cv2.imwrite(str(folder / _IMAGE), self._pixels(texture)[..., ::-1])
            mapped = (
                np.frombuffer(triangles).reshape(-1, 3, 3),
                np.frombuffer(places, np.float32).reshape(-1, 3, 2),
            )
            data = glb(mapped, folder / _IMAGE, (1.0, 1.0, 1.0), turned=False)
            assert data is not None  # it was written above
            (folder / _FILE).write_bytes(data)

        whole = cached_folder("mjcf", digest.hexdigest(), fill, lambda folder: (folder / _FILE).is_file())
        return whole / _FILE

    def _pixels(self, texture: int) -> Any:
        """Return the pixels of an image, RGB, shape ``(height, width, 3)``."""
        m = self._m
        shape = int(m.tex_height[texture]), int(m.tex_width[texture]), int(m.tex_nchannel[texture])
        start = int(m.tex_adr[texture])
        pixels = m.tex_data[start : start + np.prod(shape)].reshape(shape)
        return pixels[..., :3] if shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)

    def _shape(self, geom: int, kind: Any) -> tuple[Triangles, FloatArray]:
        """Return the triangles of a geom, and the half extents by which MuJoCo scales a shape of size 1."""
        m, kinds = self._m, mujoco.mjtGeom
        a, b, c = m.geom_size[geom].tolist()
        if kind == kinds.mjGEOM_MESH:
            mesh = int(m.geom_dataid[geom])
            faces = m.mesh_face[m.mesh_faceadr[mesh] :][: m.mesh_facenum[mesh]]
            return m.mesh_vert[m.mesh_vertadr[mesh] :][faces].astype(np.float64), np.ones(3)
        if kind == kinds.mjGEOM_PLANE:
            width, depth = (2 * side if side > 0 else 100.0 for side in (a, b))
            vertices, corners = triangles_of(Plane((width, depth)))
            return vertices[corners], np.array([a if a > 0 else 1.0, b if b > 0 else 1.0, 1.0])
        vertices, corners = triangles_of(self._solids(geom)[kind])
        if kind == kinds.mjGEOM_ELLIPSOID:
            vertices = vertices * (a, b, c)
        sizes = {
            kinds.mjGEOM_BOX: (a, b, c),
            kinds.mjGEOM_ELLIPSOID: (a, b, c),
            kinds.mjGEOM_SPHERE: (a, a, a),
        }
        return vertices[corners], np.array(sizes.get(kind, (a, a, b)))

    def _solids(self, geom: int) -> dict[Any, Geometry]:
        """Return the shapes that a geom could be, by its kind; an ellipsoid is scaled then."""
        a, b, c = self._m.geom_size[geom].tolist()
        kinds = mujoco.mjtGeom
        return {
            kinds.mjGEOM_SPHERE: Sphere(a),
            kinds.mjGEOM_ELLIPSOID: Sphere(1.0),
            kinds.mjGEOM_CAPSULE: Capsule(a, 2 * b),
            kinds.mjGEOM_CYLINDER: Cylinder(a, 2 * b),
            kinds.mjGEOM_BOX: Box((2 * a, 2 * b, 2 * c)),
        }

    def _mapped(self, geom: int, kind: Any) -> tuple[Triangles, FloatArray] | None:
        """Return a geom with its texture coordinates, from the top; None for a geom without any."""
        m, mesh = self._m, int(self._m.geom_dataid[geom])
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            if m.mesh_texcoordadr[mesh] < 0:
                return None
            corners = m.mesh_facetexcoord[m.mesh_faceadr[mesh] :][: m.mesh_facenum[mesh]]
            places = m.mesh_texcoord[m.mesh_texcoordadr[mesh] :][corners]
            return self._shape(geom, kind)[0], places.astype(np.float64)
        if kind == mujoco.mjtGeom.mjGEOM_PLANE:
            triangles, size = self._shape(geom, kind)
            flat = triangles[..., :2] / size[:2]
            return triangles, np.stack([1 + flat[..., 0], 1 - flat[..., 1]], axis=-1) / 2
        mapped = mapped_triangles(self._solids(geom)[kind])
        if mapped is None:
            return None
        triangles, places = mapped[0], mapped[1].astype(np.float64) * (1, -1) + (0, 1)
        if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return triangles * m.geom_size[geom], places
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            return triangles, _through_a_box(triangles / m.geom_size[geom])
        if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
            ends = (triangles[..., 2] == triangles[:, :1, 2]).all(axis=1)
            places[ends] = (1 + triangles[ends][..., :2] / m.geom_size[geom][0]) / 2
        return triangles, places


def _through_a_box(triangles: Triangles) -> FloatArray:
    """Return the places of the corners of a box of half extents 1, from the top."""
    places = [(1 + triangles[..., right], 1 - triangles[..., up]) for right, up in ((1, 2), (0, 2), (0, 1))]
    sides = np.ptp(triangles, axis=1).argmin(axis=1)  # the axes that they face
    seen: FloatArray = np.moveaxis(np.array(places), 1, -1)[sides, np.arange(len(triangles))] / 2
    return seen


def _around(triangles: Triangles, size: FloatArray) -> tuple[Triangles, FloatArray]:
    """Return triangles, each with one image of a cube, and the places of their corners, from below."""
    for _ in range(_HALVINGS):
        faces = ((triangles / size) @ _CUBE[:, 0].T).argmax(axis=2)
        mixed = (faces != faces[:, :1]).any(axis=1)
        a, b, c = triangles[mixed].swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        triangles = np.concatenate([triangles[~mixed], *parts])
    directions = triangles / size
    faces = (directions.mean(axis=1) @ _CUBE[:, 0].T).argmax(axis=1)
    along, right, up = (np.einsum("mki,mi->mk", directions, _CUBE[faces, way]) for way in range(3))
    places = np.stack([right, up], axis=-1) / np.maximum(along, 1e-9)[..., None]
    places = (1 + np.clip(places, -1.0, 1.0)) / 2
    places[..., 1] = (len(_CUBE) - 1 - faces[:, None] + places[..., 1]) / len(_CUBE)
    return triangles, places
