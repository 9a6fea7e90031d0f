"""Positions of the models of a running world, and horizontal distances."""

from __future__ import annotations

from collections.abc import Callable

from nrp_core.errors import CapabilityError, SceneError
from nrp_core.experiment.events.geometry import Footprint, GroundPoint
from nrp_core.experiment.model.event_schema import Near
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Link, Model, Scene
from nrp_core.world.world import World


class GroundPositions:
    """The poses of all models, read once per step.

    Args:
        world: an open world; without poses if its engine does not report them.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._scene: Scene | None = None
        self._poses: dict[str, Pose] = {}
        self.refresh()

    def refresh(self) -> None:
        """Read the present poses; those of static models change only with the scene."""
        if not self._world.capabilities.poses:
            return
        engine = self._world.engine
        if engine.scene is not self._scene:
            self._scene = engine.scene
            self._poses = {model.name: model.pose for model in self._scene.models}
            self._moving = [model.name for model in self._scene.models if not model.static]
        for name in self._moving:
            self._poses[name] = engine.model_pose(name)

    def __contains__(self, model: object) -> bool:
        return model in self._poses

    def pose(self, model: str) -> Pose:
        """Return the pose of a model."""
        return self._poses[model]

    def ground(self, model: str) -> GroundPoint:
        """Return the horizontal position of a model's origin."""
        x, y, _ = self._poses[model].position
        return x, y


def require_poses(world: World) -> None:
    """Refuse a world without poses of models.

    Raises:
        CapabilityError: its engine does not report poses of models.
    """
    if not world.capabilities.poses:
        raise CapabilityError("the world does not report where models are, so no distance is known")


class Proximity:
    """The horizontal distance of a :class:`~nrp_core.experiment.model.event_schema.Near`.

    Args:
        near: the model and the target.
        scene: the scene of the world.

    Attributes:
        target: returns the target's footprint now.

    Raises:
        SceneError: the scene does not have the model or visual, or a joint moves the visual relative to its
            model.
        CapabilityError: the visual is a mesh.
    """

    def __init__(self, near: Near, scene: Scene) -> None:
        self._model = scene.model(near.model).name
        self.target = _target(near, scene)

    def distance(self, where: GroundPositions) -> float:
        """Return the distance now, m."""
        return self.target(where).distance(where.ground(self._model))


def _target(near: Near, scene: Scene) -> Callable[[GroundPositions], Footprint]:
    if near.visual is not None:
        return _VisualFootprint(near.visual, scene)
    if near.other is not None:
        other = scene.model(near.other).name
        return lambda where: Footprint((where.ground(other),))
    assert near.point is not None  # checked when it was read
    place = Footprint((near.point,))
    return lambda _where: place


class _VisualFootprint:
    """The footprint of a visual, computed again only after a motion of its model."""

    def __init__(self, path: str, scene: Scene) -> None:
        visual = scene.visual(path)
        model, link = next(
            (model, link)
            for model, link in scene.links()
            if any(f"{model.name}/{link.name}/{visual.name}" == path for visual in link.visuals)
        )
        _require_rigid(model, link)
        self._model, self._geometry = model.name, visual.geometry
        self._on_model = link.pose @ visual.pose
        self._pose = model.pose
        self._footprint = Footprint.of(self._geometry, self._pose @ self._on_model)

    def __call__(self, where: GroundPositions) -> Footprint:
        pose = where.pose(self._model)
        if pose != self._pose:
            self._pose = pose
            self._footprint = Footprint.of(self._geometry, pose @ self._on_model)
        return self._footprint


def _require_rigid(model: Model, link: Link) -> None:
    """Refuse a link that a joint moves relative to its model."""
    holding = {joint.child: joint for joint in model.joints}
    name = link.name
    while name in holding:
        joint = holding[name]
        if joint.kind != "fixed":
            raise SceneError(
                f"the distance to link '{model.name}/{link.name}' is not known: joint '{joint.name}' moves it"
            )
        name = joint.parent
