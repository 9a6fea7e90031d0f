"""Muscles along straight lines, which PyBullet does not have: their forces are set before each step."""

from __future__ import annotations

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine_kit.muscles import ViaPointMuscles
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
        self._client = client
        bodies = {model: [body for body, _ in each] for model, each in built.bodies.items()}
        super().__init__(scene, bodies, step_s)
        self._places = [built.bodies[model][index][1] for model, index in self.carriers]
        self._bases = [(row, each.multibody) for row, each in enumerate(self._places) if each.link == BASE]
        self._links: dict[int, tuple[list[int], list[int]]] = {}  # rows and links of each multi-body
        for row, place in enumerate(self._places):
            if place.link != BASE:
                rows, links = self._links.setdefault(place.multibody, ([], []))
                rows.append(row)
                links.append(place.link)

    def push(self) -> None:
        """Apply the forces of the next step."""
        client, frame = self._client, bullet.WORLD_FRAME
        wrenches, motions = self.step().tolist(), self._motions  # at which the wrenches were computed
        for place, wrench, at in zip(self._places, wrenches, motions[:-1, :3].tolist(), strict=True):
            where = place.multibody, place.link
            bullet.applyExternalForce(*where, wrench[:3], at, frame, physicsClientId=client)
            bullet.applyExternalTorque(*where, wrench[3:], frame, physicsClientId=client)

    def _read(self, motions: FloatArray) -> None:
        client = self._client
        for row, body in self._bases:
            place, turn = bullet.getBasePositionAndOrientation(body, client)
            linear, angular = bullet.getBaseVelocity(body, client)
            motions[row] = (*place, *turn, *linear, *angular)
        for body, (rows, links) in self._links.items():
            states = bullet.getLinkStates(body, links, 1, 1, client)
            motions[rows] = [(*each[0], *each[1], *each[6], *each[7]) for each in states]
