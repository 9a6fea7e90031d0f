"""Images drawn by OpenGL.

``python -m nrp_world_mujoco.gl egl`` tries a library, in a separate process because some abort it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from importlib import import_module
from typing import Any

import numpy as np

from nrp_core.world.render.cameras import SKY, ImageArray, Optics
from nrp_world_mujoco.library import VISUALS, mujoco

_MIRROR = np.diag([1.0, 1.0, -1.0]).ravel()


class GlRenderer:
    """Draws any camera of a model; must be used in the thread that created it.

    Args:
        model: a compiled MuJoCo model, from a specification that was prepared.
        library: ``egl`` or ``osmesa``.
    """

    def __init__(self, model: Any, library: str) -> None:
        self._model = model
        width, height = int(model.vis.global_.offwidth), int(model.vis.global_.offheight)
        # the context's class is taken from its own module: that of mujoco.Renderer depends on MUJOCO_GL at
        # the first import of MuJoCo
        self._window = import_module(f"mujoco.{library}").GLContext(width, height)
        self._window.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        for flag in ("SHADOW", "REFLECTION", "SKYBOX", "FOG", "HAZE"):
            self._scene.flags[getattr(mujoco.mjtRndFlag, f"mjRND_{flag}")] = False
        self._shown = mujoco.MjvOption()
        self._shown.geomgroup[:] = 0
        self._shown.geomgroup[VISUALS] = 1
        self._shown.sitegroup[:] = 0
        self._eye = mujoco.MjvCamera()
        self._eye.type = mujoco.mjtCamera.mjCAMERA_FIXED

    @staticmethod
    def prepare(spec: Any, optics: Iterable[Optics]) -> None:
        """Set the options that a model needs before it is compiled: flat light and the size of the buffer."""
        sizes = [(1, 1), *((each.width, each.height) for each in optics)]
        visual = spec.visual
        visual.global_.offwidth = max(width for width, _ in sizes)
        visual.global_.offheight = max(height for _, height in sizes)
        visual.quality.offsamples = 0
        visual.quality.shadowsize = 0
        visual.headlight.ambient = [1, 1, 1]
        visual.headlight.diffuse = [0, 0, 0]
        visual.headlight.specular = [0, 0, 0]
        spec.stat.extent = 1.0  # the unit of clip distances

    def image(self, data: Any, camera: int, optics: Optics) -> ImageArray:
        """Return the image of a camera, shape ``(height, width, 3)``, RGB; positions must be up to date."""
        self._model.vis.map.znear = optics.near
        self._model.vis.map.zfar = optics.far
        self._eye.fixedcamid = camera
        self._window.make_current()
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, data, self._shown, None, self._eye, everything, self._scene)
        self._add_sky(optics)
        frame = mujoco.MjrRect(0, 0, optics.width, optics.height)
        mujoco.mjr_render(frame, self._scene, self._context)
        image = np.empty((optics.height, optics.width, 3), np.uint8)
        mujoco.mjr_readPixels(image, None, frame, self._context)
        return np.ascontiguousarray(image[::-1])  # OpenGL counts rows from below

    def _add_sky(self, optics: Optics) -> None:
        """Draw a box around the camera, mirrored so that its faces look inwards; faster than a skybox."""
        sky, place = self._scene.geoms[self._scene.ngeom], self._scene.camera[0].pos
        size = np.full(3, optics.far / 2)
        box = mujoco.mjtGeom.mjGEOM_BOX
        mujoco.mjv_initGeom(sky, box, size, np.array(place, float), _MIRROR, np.array(SKY, np.float32))
        self._scene.ngeom += 1

    def close(self) -> None:
        """Free the context."""
        self._window.make_current()
        self._context.free()
        self._window.free()


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
