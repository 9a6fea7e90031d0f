"""The paths of muscles after each step, for viewers and videos."""

from __future__ import annotations

from nrp_core.messages.base import Time
from nrp_core.messages.foxglove_msgs import Color, LinePrimitive, SceneEntity, SceneUpdate
from nrp_core.messages.geometry_msgs import Point
from nrp_core.recording.layout import MUSCLES, WORLD_FRAME, Role
from nrp_core.recording.writing.signals import PERIOD_NS, Add, RecordEntry, Signal, about_role
from nrp_core.scene.model import Scene
from nrp_core.world.drives.muscles import drawn_muscles, drawn_paths
from nrp_core.world.render.tubes import activation_rgba
from nrp_core.world.world import World


class MusclePaths(Signal):
    """The paths of all muscles as lines in one entity, at most 25 times a second of simulated time."""

    _about = about_role(Role.MUSCLES)

    def __init__(self, world: World) -> None:
        self._world = world
        self._scene: Scene | None = None
        self._due_ns = 0

    def take(self, now_ns: int, add: Add) -> None:
        scene = self._world.scene
        if scene is not self._scene:
            self._scene, self._due_ns = scene, now_ns
            self._muscles = drawn_muscles(scene)
        if now_ns < self._due_ns or not self._muscles:
            return
        self._due_ns = (now_ns // PERIOD_NS + 1) * PERIOD_NS
        lines = [
            LinePrimitive(
                thickness=2 * muscle.radius,
                points=[Point(*point) for point in points],
                color=Color(*activation_rgba(activation)),
            )
            for muscle, points, activation in drawn_paths(self._world.engine, self._muscles)
        ]
        entity = SceneEntity(Time.from_ns(now_ns), WORLD_FRAME, "muscles", lines=lines)
        add(RecordEntry(now_ns, MUSCLES, SceneUpdate, self._about, message=SceneUpdate([], [entity])))
