"""Muscles along straight lines, which PyBullet does not have: their forces are set before each step."""

from __future__ import annotations

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine_kit.muscles import ViaPointMuscles
from nrp_core.world.rigid import BodyPath
from nrp_core.world.scene.model import Scene
from nrp_world_pybullet.build import BASE, Built
from nrp_world_pybullet.library import bullet


class Muscles(ViaPointMuscles):
    """The muscles of a scene.

    Args:
        scene: the scene.
        built: its handles.
        client: the physics client.
        step_s: the physics step, s.
    """

    def __init__(self, scene: Scene, built: Built, client: int, step_s: float) -> None:
        self._built, self._client = built, client
        bodies = {model: [body for body, _ in each] for model, each in built.bodies.items()}
        super().__init__(scene, bodies, self._read, step_s)

    def push(self) -> None:
        """Apply the forces of the next step."""
        client, frame = self._client, bullet.WORLD_FRAME
        motions = self._motions  # at which the wrenches were computed
        for row, (body, wrench) in enumerate(zip(self.carriers, self.step().tolist(), strict=True)):
            _, place = self._built.bodies[body[0]][body[1]]
            where, at = (place.multibody, place.link), motions[row, :3].tolist()
            bullet.applyExternalForce(*where, wrench[:3], at, frame, physicsClientId=client)
            bullet.applyExternalTorque(*where, wrench[3:], frame, physicsClientId=client)

    def _read(self, path: BodyPath, row: FloatArray) -> None:
        _, place = self._built.bodies[path[0]][path[1]]
        body, link, client = place.multibody, place.link, self._client
        if link == BASE:
            (x, y, z), turn = bullet.getBasePositionAndOrientation(body, client)
            linear, angular = bullet.getBaseVelocity(body, client)
        else:
            state = bullet.getLinkState(body, link, 1, 1, client)
            (x, y, z), turn, linear, angular = state[0], state[1], state[6], state[7]
        row[:] = (x, y, z, *turn, *linear, *angular)
