"""``python -m nrp_world_mujoco.try_gl egl`` tries a library, in a separate process because some abort it."""

from __future__ import annotations

import sys

from nrp_core.world.render.optics import Optics
from nrp_world_mujoco.gl import GlRenderer
from nrp_world_mujoco.library import VISUALS, mujoco


def draws(library: str) -> bool:
    """Draw a red sphere and return whether it is red."""
    optics = Optics(16, 12, vertical_fov=0.5, near=0.1, far=10.0)
    spec = mujoco.MjSpec()
    spec.worldbody.add_camera()
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1, 0, 0], pos=[0, 0, -3], rgba=[1, 0, 0, 1], group=VISUALS
    )
    GlRenderer.prepare(spec, [optics])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    image = GlRenderer(model, library).image(data, 0, optics)
    return bool((image[6, 8] == (255, 0, 0)).all())


if __name__ == "__main__":
    sys.exit(0 if draws(sys.argv[1]) else 1)
