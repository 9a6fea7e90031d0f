"""How the sensors that look into the room are mounted, so that the page can show where they look."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.world.scene.sensing import View
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.world import World


def mounts_data(world: World) -> Iterator[dict[str, Any]]:
    """Yield the cameras and laser scanners, each with its pose in the frame that it moves with."""
    frames = SceneFrames(world).now
    for model, link in world.scene.links():
        for sensor in link.sensors:
            looks = sensor if isinstance(sensor, Laser) else sensor.view
            if looks is None:
                continue
            frame, place = frames.place(model.name, link.name)
            pose = place @ looks.pose
            yield {
                "topic": sensor.topic,
                "frame": frame,
                "position": list(pose.position),
                "orientation": list(pose.orientation),
                "view": _view_data(looks) if isinstance(looks, View) else None,
            }


def _view_data(view: View) -> dict[str, float]:
    return {"fov_rad": view.horizontal_fov, "aspect": view.width / view.height}
