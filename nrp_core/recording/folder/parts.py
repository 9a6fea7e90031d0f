"""The parts of a brain and a world as data, which viewers can show without the experiment."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network, Projection
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.world.scene.devices import View
from nrp_core.world.scene.model import Scene
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.world import World

MOST_EDGES = 2_000
"""The individual synapses of larger projections are not described."""


def groups_data(network: Network) -> dict[str, Any]:
    """Return the populations and, for each named view, its ranges of ids by population and its members."""
    views: dict[str, dict[str, list[list[int]]]] = {}
    for name, neurons in network.views.items():
        for label, first in network.offsets.items():
            last = first + network.populations[label].size
            ids = np.unique(neurons[(neurons >= first) & (neurons < last)]) - first
            if ids.size:
                views.setdefault(name, {})[label] = _ranges(ids)
    populations = {
        label: {"size": population.size, "cell_type": population.cell_type}
        for label, population in network.populations.items()
    }
    members = {name: neurons.tolist() for name, neurons in network.views.items()}
    return {"populations": populations, "views": views, "members": members}


def _ranges(ids: IntArray) -> list[list[int]]:
    """Return ascending ids as half-open ranges."""
    cuts = np.flatnonzero(np.diff(ids) > 1) + 1
    return [[int(part[0]), int(part[-1]) + 1] for part in np.split(ids, cuts)]


def projection_data(projection: Projection) -> dict[str, Any]:
    """Return the description of a projection.

    ``edges`` holds presynaptic index, postsynaptic index (within their populations) and weight of each
    synapse; None for more than :data:`MOST_EDGES`.
    """
    weights = projection.weight
    excites = projection.is_excitatory and not bool(np.any(weights[:1] < 0))
    return {
        "id": projection.label,
        "label": projection.label,
        "pre": projection.pre,
        "post": projection.post,
        "receptor": projection.receptor,
        "synapse": projection.synapse_type,
        "size": projection.size,
        "excites": excites,
        "edges": _edges(projection) if projection.size <= MOST_EDGES else None,
    }


def _edges(projection: Projection) -> list[list[float]]:
    pairs = [(int(a), int(b)) for pre, post in projection.pairs() for a, b in zip(pre, post, strict=True)]
    return [[a, b, float(w)] for (a, b), w in zip(pairs, projection.weight, strict=True)]


def mounts_data(world: World) -> Iterator[dict[str, Any]]:
    """Yield the cameras and laser scanners, each with its pose in its parent frame.

    ``view`` holds the horizontal field of view, rad, and the aspect ratio of a camera; None for a laser
    scanner.
    """
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


def lights_data(scene: Scene) -> list[dict[str, Any]]:
    """Return the lights that are on, in SI units; a range of None has no end."""
    return [
        {
            "kind": light.kind,
            "position": list(light.pose.position),
            "direction": list(light.direction),
            "color": list(light.diffuse[:3]),
            "casts_shadows": light.casts_shadows,
            "range_m": light.attenuation[0] if isfinite(light.attenuation[0]) else None,
            "attenuation": list(light.attenuation[1:]),
            "cone_rad": light.cone[1],
        }
        for light in scene.lights
        if any(light.diffuse[:3])
    ]


def _view_data(view: View) -> dict[str, float]:
    return {"fov_rad": view.horizontal_fov, "aspect": view.width / view.height}
