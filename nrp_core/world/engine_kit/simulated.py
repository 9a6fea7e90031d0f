"""The bodies of a model that every engine simulates."""

from __future__ import annotations

from nrp_core.world.engine_kit.planar_servo import without_wheel_friction
from nrp_core.world.engine_kit.springs import with_steady_springs
from nrp_core.world.scene.merged_bodies import Body, bodies_of
from nrp_core.world.scene.model import Model


def simulated_bodies(model: Model, step_s: float, physical: bool) -> tuple[Body, ...]:
    """Return the bodies of a model, prepared for an engine.

    Args:
        model: the model.
        step_s: the physics step.
        physical: whether wheels move the robot by friction.
    """
    return with_steady_springs(without_wheel_friction(model, bodies_of(model), physical), step_s)
