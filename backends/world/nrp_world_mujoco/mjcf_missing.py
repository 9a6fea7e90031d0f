"""Replacements of the files of an MJCF model that are not there, which MuJoCo refuses to do without."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, Final

from nrp_core.findings import Code, Findings
from nrp_core.world.scene.meshes import LFS
from nrp_world_mujoco.library import mujoco

_HALF_M: Final = 0.025
"""Half of the side of the cube in the place of a mesh."""
_POINTER_BYTES: Final = 1024
_GREY: Final = (0.5, 0.5, 0.5)


def replace_missing(spec: Any, path: Path, warnings: Findings) -> None:
    """Give a specification cubes and grey for its absent meshes and images, with a warning of each.

    Args:
        spec: the specification that MuJoCo read.
        path: the file that it read.
        warnings: receives the warnings.
    """
    for mesh in spec.meshes:
        for file, lacking in _absent([mesh.file], spec.meshdir, spec, path):
            warnings.add(
                Code.NRP258,
                f"the mesh '{file}' {lacking}: replaced by a cube of {200 * _HALF_M:g} cm",
                subject=file,
                path=path,
            )
            mesh.file, mesh.scale = "", (1.0, 1.0, 1.0)
            corners = product((-_HALF_M, _HALF_M), repeat=3)
            mesh.uservert = [number for corner in corners for number in corner]
    for image in spec.textures:
        for file, lacking in list(_absent([image.file, *image.cubefiles], spec.texturedir, spec, path))[:1]:
            warnings.add(Code.NRP259, f"the image '{file}' {lacking}: shown grey", subject=file, path=path)
            image.file, image.cubefiles = "", [""] * len(image.cubefiles)
            image.builtin, image.rgb1, image.rgb2 = mujoco.mjtBuiltin.mjBUILTIN_FLAT, _GREY, _GREY
            image.width = image.height = 2


def _absent(files: list[str], folder: str, spec: Any, path: Path) -> Iterator[tuple[str, str]]:
    """Yield the files, given relative to a folder beside the model, that do not exist, and what they lack."""
    for file in filter(None, files):
        place = path.parent / folder / (Path(file).name if spec.strippath else file)
        if not place.is_file():
            yield file, "is not there"
        elif place.stat().st_size < _POINTER_BYTES and place.read_bytes().startswith(LFS):
            yield file, "is a Git LFS pointer"
