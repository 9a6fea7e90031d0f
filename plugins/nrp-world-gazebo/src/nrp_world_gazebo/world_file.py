"""The world that Gazebo loads: its models in separate files, and the experiment's additions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from lxml import etree

from nrp_core.clock import seconds
from nrp_core.scene.merged_bodies import Body
from nrp_core.world import Model, Scene
from nrp_world_gazebo.elements import Xml, element, model_element, numbers, pose_element
from nrp_world_gazebo.lights import light_element, waking_camera
from nrp_world_gazebo.process import Run

_VERSION = "1.6"
_PLUGIN = "libnrp_gazebo.so"
_CONFIG = '<?xml version="1.0"?><model><name>{name}</name><sdf version="{version}">model.sdf</sdf></model>'


def write_world(
    run: Run, scene: Scene, step_ns: int, bodies: Mapping[str, Sequence[Body]], own: Mapping[str, Xml]
) -> None:
    """Write the world of a scene.

    Args:
        run: the folder.
        scene: the scene.
        step_ns: the physics step.
        bodies: the bodies of each model.
        own: the ``<sdf>`` of models that Gazebo reads from their own files.
    """
    world = element("world", _physics(step_ns), numbers("gravity", *scene.gravity), name="nrp")
    for number, model in enumerate(scene.models):
        given = own.get(model.name)
        sdf = _sdf(model_element(model, bodies[model.name], seconds(step_ns))) if given is None else given
        world.append(_include(run.models / f"nrp_{number}", model, sdf))
    told = [element("socket", text=str(run.socket))]
    if run.images.exists():
        told.append(element("images", text=str(run.images)))
        world.extend(map(light_element, scene.lights))
        world.append(waking_camera())
    world.append(element("plugin", *told, name="nrp_lockstep", filename=_PLUGIN))
    run.world.write_bytes(etree.tostring(_sdf(world), pretty_print=True))


def _sdf(content: Xml) -> Xml:
    return element("sdf", content, version=_VERSION)


def _include(folder: Path, model: Model, sdf: Xml) -> Xml:
    """Write the files of a model and return the element that includes it."""
    folder.mkdir(parents=True)
    version = sdf.get("version", _VERSION)
    (folder / "model.config").write_text(_CONFIG.format(name=folder.name, version=version))
    (folder / "model.sdf").write_bytes(etree.tostring(sdf, pretty_print=True))
    return element(
        "include",
        element("uri", text=f"model://{folder.name}"),
        element("name", text=model.name),
        element("static", text=str(int(model.static))),
        pose_element(model.pose),
    )


def _physics(step_ns: int) -> Xml:
    """Return the physics: ODE as fast as possible, with its direct solver.

    The iterative one, ``quick``, begins each step with the forces of the last one, which no state contains.
    """
    return element(
        "physics",
        numbers("max_step_size", seconds(step_ns)),
        element("real_time_factor", text="0"),
        element("real_time_update_rate", text="0"),
        element("ode", element("solver", element("type", text="world"))),
        name="nrp",
        type="ode",
    )
