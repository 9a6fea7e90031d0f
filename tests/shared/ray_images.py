"""Images of a scene that MuJoCo's own ray casts draw, from its shapes as plain MJCF geoms."""

from __future__ import annotations

from collections.abc import Sequence
from math import tan
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from nrp_core.scene.model import Box, Capsule, Cylinder, Geometry, Mesh, Model, Plane, Sphere
from nrp_core.scene.rigid import Pose, rotation_matrix
from nrp_core.world.render.cameras import SKY, bytes_of, flat


def ray_image(
    models: Sequence[Model], eye: Pose, width: int, height: int, fov: float
) -> npt.NDArray[np.uint8]:
    """Return the image of a camera that looks along x of ``eye``, shape ``(height, width, 3)``.

    Args:
        models: the models; links are where all joints are at 0.
        eye: pose of the camera in the world.
        width: pixels.
        height: pixels.
        fov: horizontal field of view, rad.
    """
    spec = mujoco.MjSpec()
    for model in models:
        for link in model.links:
            for visual in link.visuals:
                pose = model.pose @ link.pose @ visual.pose
                x, y, z, w = pose.orientation
                geom = _geom(spec, visual.geometry)
                spec.worldbody.add_geom(pos=pose.position, quat=(w, x, y, z), rgba=flat(visual.rgba), **geom)
    compiled = spec.compile()
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    step = 2 * tan(fov / 2) / width
    right, down = np.meshgrid(np.arange(width) - (width - 1) / 2, np.arange(height) - (height - 1) / 2)
    rays = np.stack([np.ones_like(right), -right * step, -down * step], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    rays = rays @ rotation_matrix(eye.orientation).T
    seen, distances = np.empty(len(rays), np.int32), np.empty(len(rays))
    mujoco.mj_multiRay(
        compiled,
        data,
        np.array(eye.position),
        rays.ravel(),
        None,
        1,
        -1,
        seen,
        distances,
        None,
        len(rays),
        1e3,
    )
    colors = [*np.rint(compiled.geom_rgba[:, :3] * 255), bytes_of(SKY)]
    return np.array(colors, np.uint8)[seen].reshape(height, width, 3)


def _geom(spec: Any, geometry: Geometry) -> dict[str, Any]:
    kinds = mujoco.mjtGeom
    match geometry:
        case Box((x, y, z)):
            return {"type": kinds.mjGEOM_BOX, "size": (x / 2, y / 2, z / 2)}
        case Sphere(radius):
            return {"type": kinds.mjGEOM_SPHERE, "size": (radius, 0, 0)}
        case Cylinder(radius, length):
            return {"type": kinds.mjGEOM_CYLINDER, "size": (radius, length / 2, 0)}
        case Capsule(radius, length):
            return {"type": kinds.mjGEOM_CAPSULE, "size": (radius, length / 2, 0)}
        case Plane((width, depth)):
            return {"type": kinds.mjGEOM_BOX, "size": (width / 2, depth / 2, 1e-4)}
        case Mesh(path, scale):
            name = f"mesh{len(spec.meshes)}"
            spec.add_mesh(name=name, file=str(path), scale=scale)
            return {"type": kinds.mjGEOM_MESH, "meshname": name}
    raise AssertionError(geometry)
