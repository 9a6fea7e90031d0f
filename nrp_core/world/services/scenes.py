"""Requests about the scene and its physics: models, lights, colours, and the pause."""

from __future__ import annotations

from dataclasses import replace
from math import isclose
from pathlib import Path
from tempfile import TemporaryDirectory

from nrp_core.clock import seconds
from nrp_core.errors import SceneError, TimestepError, did_you_mean
from nrp_core.messages import gazebo_srvs as srv
from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.messages.std_srvs import EmptyRequest, EmptyResponse
from nrp_core.scene.materials import color_of, glows
from nrp_core.scene.model import Light, Model, Rgba
from nrp_core.scene.rigid import Pose
from nrp_core.world.model_states import pose_of, vector_of
from nrp_core.world.service import PREFIX, Service
from nrp_core.world.world import World


def physics_services(world: World) -> list[Service]:
    """Return the services of :class:`PhysicsRequests`."""
    physics = PhysicsRequests(world)
    return [
        Service(PREFIX + "get_physics_properties", srv.GetPhysicsPropertiesRequest, physics.properties),
        Service(PREFIX + "set_physics_properties", srv.SetPhysicsPropertiesRequest, physics.set_properties),
    ]


class PhysicsRequests:
    """Answers requests about physics.

    Args:
        world: the world.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def properties(self, _request: srv.GetPhysicsPropertiesRequest) -> srv.GetPhysicsPropertiesResponse:
        """Return the physics step and gravity; for Gazebo's other settings, their defaults."""
        step_s, gravity = seconds(self._world.engine.step_ns), Vector3(*self._world.scene.gravity)
        return srv.GetPhysicsPropertiesResponse(step_s, self._world.paused, 1.0 / step_s, gravity)

    def set_properties(self, request: srv.SetPhysicsPropertiesRequest) -> srv.SetPhysicsPropertiesResponse:
        """Set gravity."""
        step_s, asked_s = seconds(self._world.engine.step_ns), float(request.time_step)
        if asked_s and not isclose(asked_s, step_s):
            raise TimestepError(
                f"the physics step is {step_s:g} s for the whole run and cannot be changed to {asked_s:g} s; "
                "set it with the option timestep of the experiment's world"
            )
        self._world.set_gravity(vector_of(request.gravity))
        return srv.SetPhysicsPropertiesResponse()


def scene_services(world: World) -> list[Service]:
    """Return the services of :class:`SceneRequests`."""
    scenes = SceneRequests(world)
    return [
        Service(PREFIX + "get_model_properties", srv.GetModelPropertiesRequest, scenes.model_properties),
        Service(PREFIX + "get_world_properties", srv.GetWorldPropertiesRequest, scenes.world_properties),
        Service(PREFIX + "spawn_sdf_model", srv.SpawnModelRequest, scenes.spawn),
        Service(PREFIX + "spawn_urdf_model", srv.SpawnModelRequest, scenes.spawn),
        Service(PREFIX + "spawn_sdf_entity", srv.SpawnModelRequest, scenes.spawn),
        Service(PREFIX + "delete_model", srv.DeleteModelRequest, scenes.delete),
        Service(PREFIX + "set_visual_properties", srv.SetVisualPropertiesRequest, scenes.set_visual),
        Service(PREFIX + "get_lights_name", srv.GetLightsNameRequest, scenes.light_names),
        Service(PREFIX + "get_light_properties", srv.GetLightPropertiesRequest, scenes.light),
        Service(PREFIX + "set_light_properties", srv.SetLightPropertiesRequest, scenes.set_light),
        Service(PREFIX + "delete_light", srv.DeleteLightRequest, scenes.delete_light),
        Service(PREFIX + "pause_physics", EmptyRequest, scenes.pause),
        Service(PREFIX + "unpause_physics", EmptyRequest, scenes.unpause),
        Service(PREFIX + "reset_world", EmptyRequest, scenes.reset_world),
        Service(PREFIX + "reset_simulation", EmptyRequest, scenes.reset_simulation),
    ]


class SceneRequests:
    """Answers requests about the scene.

    Args:
        world: the world.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def model_properties(self, request: srv.GetModelPropertiesRequest) -> srv.GetModelPropertiesResponse:
        """Return the parts of a model."""
        model = self._world.scene.model(request.model_name)
        return srv.GetModelPropertiesResponse(
            canonical_body_name=model.links[0].name,
            body_names=[link.name for link in model.links],
            geom_names=[collision.name for link in model.links for collision in link.collisions],
            joint_names=[joint.name for joint in model.joints],
            is_static=model.static,
        )

    def world_properties(self, _request: srv.GetWorldPropertiesRequest) -> srv.GetWorldPropertiesResponse:
        """Return the names of the models."""
        names = [model.name for model in self._world.scene.models]
        return srv.GetWorldPropertiesResponse(seconds(self._world.now_ns), names)

    def spawn(self, request: srv.SpawnModelRequest) -> srv.SpawnModelResponse:
        """Add a model or a light, from the text of its file."""
        pose = pose_of(request.initial_pose)
        if request.reference_frame not in ("", "world"):
            reference = self._world.scene.model(request.reference_frame)
            pose = self._world.engine.model_motion(reference.name).pose @ pose
        added = _read(request.model_name, request.model_xml, pose)
        if isinstance(added, Model):
            self._world.spawn(added)
            return srv.SpawnModelResponse()
        lights = self._world.scene.lights
        if any(light.name == added.name for light in lights):
            raise SceneError(f"the scene already has a light '{added.name}'")
        self._world.set_lights((*lights, added))
        return srv.SpawnModelResponse()

    def delete(self, request: srv.DeleteModelRequest) -> srv.DeleteModelResponse:
        """Delete a model."""
        self._world.delete(request.model_name)
        return srv.DeleteModelResponse()

    def set_visual(self, request: srv.SetVisualPropertiesRequest) -> srv.SetVisualPropertiesResponse:
        """Set the colour of a visual."""
        path = f"{request.model_name}/{request.link_name}/{request.visual_name}"
        self._world.scene.visual(path)
        self._world.set_material(path, *_read_color(request.property_name, request.property_value))
        return srv.SetVisualPropertiesResponse()

    def light_names(self, _request: srv.GetLightsNameRequest) -> srv.GetLightsNameResponse:
        """Return the names of the lights."""
        return srv.GetLightsNameResponse([light.name for light in self._world.scene.lights])

    def light(self, request: srv.GetLightPropertiesRequest) -> srv.GetLightPropertiesResponse:
        """Return the colour and attenuation of a light."""
        light = self._light(request.light_name)
        return srv.GetLightPropertiesResponse(ColorRGBA(*light.diffuse), *light.attenuation[1:])

    def set_light(self, request: srv.SetLightPropertiesRequest) -> srv.SetLightPropertiesResponse:
        """Set the colour of a light."""
        light, color = self._light(request.light_name), request.diffuse
        diffuse = float(color.r), float(color.g), float(color.b), float(color.a)
        self._world.set_lights(
            replace(each, diffuse=diffuse) if each is light else each for each in self._world.scene.lights
        )
        return srv.SetLightPropertiesResponse()

    def delete_light(self, request: srv.DeleteLightRequest) -> srv.DeleteLightResponse:
        """Delete a light."""
        light = self._light(request.light_name)
        self._world.set_lights(each for each in self._world.scene.lights if each is not light)
        return srv.DeleteLightResponse()

    def pause(self, _request: EmptyRequest) -> EmptyResponse:
        """Pause all motion."""
        self._world.paused = True
        return EmptyResponse()

    def unpause(self, _request: EmptyRequest) -> EmptyResponse:
        """Resume all motion."""
        self._world.paused = False
        return EmptyResponse()

    def reset_world(self, _request: EmptyRequest) -> EmptyResponse:
        """Reset the poses of all models; the time continues."""
        self._world.reset("poses")
        return EmptyResponse()

    def reset_simulation(self, _request: EmptyRequest) -> EmptyResponse:
        """Reset everything except the time, which belongs to the run."""
        self._world.reset("state")
        return EmptyResponse()

    def _light(self, name: str) -> Light:
        lights = {light.name: light for light in self._world.scene.lights}
        if name not in lights:
            raise SceneError(f"the scene has no light '{name}'{did_you_mean(name, lights)}")
        return lights[name]


def _read(name: str, text: str, pose: Pose) -> Model | Light:
    """Return the model or light in the text of a file, with a name and at a pose."""
    from nrp_core.scene.sdf import read_model, read_scene  # few runs need readers of files

    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.sdf"
        path.write_text(text)
        scene = read_scene(path) if "<light" in text else None
        if scene is not None and scene.lights and not scene.models:
            light = scene.lights[0]
            shines = pose.rotate(light.pose.rotate_back(light.direction))
            return replace(light, name=name or light.name, pose=pose, direction=shines)
        return read_model(path, name=name or None, pose=pose)


def _read_color(kind: str, value: str) -> tuple[Rgba, bool | None]:
    """Return the colour in a property of a visual, and whether it glows; None: as before."""
    if kind in _COLORS:
        try:
            red, green, blue, *alpha = map(float, value.split())
        except ValueError:
            raise SceneError(
                f"a colour must be 'red green blue alpha', each from 0 to 1, not '{value}'"
            ) from None
        return (red, green, blue, alpha[0] if alpha else 1.0), _COLORS[kind]
    if kind not in ("", "material:script:name"):
        can = f"material:script:name, {', '.join(_COLORS)}"
        raise SceneError(f"the property '{kind}' of a visual cannot be set; valid: {can}")
    return color_of(value), glows(value)


_COLORS = {"material:diffuse": None, "material:ambient": None, "material:emissive": True}
