"""Scans of lasers by rays of ODE, against the collision shapes that Gazebo has."""

from __future__ import annotations

from math import inf

import numpy as np

from nrp_core.world import FloatArray
from nrp_core.world.raycast.beams import Beams, directions
from nrp_core.world.rigid import rotation_matrix
from nrp_core.world.scene.merged_bodies import body_of, place_in_frame
from nrp_world_gazebo.build import NOWHERE, Built
from nrp_world_gazebo.motion import motion_of
from nrp_world_gazebo.wire import operation


def scan(built: Built, model: str, link: str, beams: Beams) -> FloatArray:
    """Return the distance along each ray, m; ``inf`` for a ray that hits nothing.

    The body that carries the scanner is ignored.
    """
    gazebo, places = built.gazebo, built.bodies[model]
    body, place = places[body_of([each for each, _ in places], link)]
    gazebo.refresh()
    at = place_in_frame(body) if body.fixed else motion_of(gazebo.links[place.link]).pose @ place.held
    held = next(part.pose for part in body.links if part.name == link)
    eye = at @ held @ beams.pose
    rays = directions(beams) @ rotation_matrix(eye.orientation).T
    ignored = [] if place.link == NOWHERE else place.links
    head = operation("b", len(ignored), *ignored, len(rays), values=(*eye.position, *beams.reach))
    distances = np.frombuffer(gazebo.ask(head + rays.tobytes()), float, len(rays))
    return np.where(distances > beams.reach[1], inf, distances)
