"""Scans of lasers by rays of ODE, against the collision shapes that Gazebo has."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from nrp_core.scene.merged_bodies import body_of, place_in_frame
from nrp_core.scene.rigid import rotation_matrix
from nrp_core.world import FloatArray
from nrp_core.world.raycast.beams import Beams, Span, directions
from nrp_world_gazebo.build import NOWHERE, Built
from nrp_world_gazebo.motion import motion_of
from nrp_world_gazebo.wire import operation


def scan(built: Built, model: str, link: str, beams: Beams) -> FloatArray:
    """Return the distance along each ray, m.

    It is ``inf`` for a ray that hits nothing, and ``-inf`` for one that another model blocks nearer than the
    minimum distance (REP 117). The body that carries the scanner is ignored, and so are parts of its model
    that are nearer than the minimum.
    """
    gazebo, places = built.gazebo, built.bodies[model]
    body, place = places[body_of([each for each, _ in places], link)]
    gazebo.refresh()
    at = place_in_frame(body) if body.fixed else motion_of(gazebo.links[place.link]).pose @ place.held
    held = next(part.pose for part in body.links if part.name == link)
    eye = at @ held @ beams.pose
    rays = directions(beams) @ rotation_matrix(eye.orientation).T
    ignored = [] if place.link == NOWHERE else place.links
    nearest, farthest = beams.reach

    def hits(ignored: Sequence[int], reach: Span) -> FloatArray:
        head = operation("b", len(ignored), *ignored, len(rays), values=(*eye.position, *reach))
        return np.frombuffer(gazebo.ask(head + rays.tobytes()), float, len(rays))

    distances = hits(ignored, beams.reach)
    distances = np.where(distances > farthest, inf, distances)
    if nearest > 0:
        own = [link for _, each in places if each.link != NOWHERE for link in each.links]
        distances = np.where(hits(own, (0.0, nearest)) < nearest, -inf, distances)
    return distances
