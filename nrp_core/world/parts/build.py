"""Which parts a scene has."""

from __future__ import annotations

from nrp_core.world.parts.base import Engine, Part
from nrp_core.world.parts.camera import CameraPart
from nrp_core.world.parts.color import ColorPart
from nrp_core.world.parts.drive import DrivePart
from nrp_core.world.parts.joints import JointStatesPart
from nrp_core.world.parts.model_states import ModelStatesPart
from nrp_core.world.scene.model import Camera, Scene


def parts_of(scene: Scene, engine: Engine) -> list[Part]:
    """Return the parts that serve the topics of a scene."""
    parts: list[Part] = [ModelStatesPart(scene, engine)]
    for model, link in scene.links():
        parts += [CameraPart(s, model.name, link.name, engine) for s in link.sensors if isinstance(s, Camera)]
        parts += [ColorPart(f"{model.name}/{link.name}/{v.name}", v.rgba, engine) for v in link.visuals]
    for model in scene.models:
        parts += [DrivePart(drive, model, engine) for drive in model.drives]
        if model.joint_states_topic is not None:
            parts.append(JointStatesPart(model, engine))
    return parts
