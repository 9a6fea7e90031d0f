"""Buoyancy, as the plugin ``Buoyancy`` of Gazebo Sim describes it: layers of fluids lift collision shapes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cbrt
from typing import ClassVar

import numpy as np

from nrp_core.scene.inertia import shape_inertia
from nrp_core.scene.rigid import matrix_of
from nrp_core.world import (
    Element,
    Engine,
    FloatArray,
    Geometry,
    Link,
    Model,
    ModelParts,
    Part,
    Pose,
    Reading,
    triangles_of,
)
from nrp_medium.element import Flow, Immersed, MediumPart, cross

WATER = 1000.0
"""The density if the file gives none, kg/m^3."""


@dataclass(frozen=True, slots=True)
class Buoyancy(Immersed):
    """Fluids that lift the models of a world by Archimedes' principle; in a model, that model alone.

    Args:
        density: of the lowest fluid, kg/m^3.
        layers: the heights (m) at which other fluids begin, and their densities.
        enabled: the models, or the links as ``model::link``, that it lifts; empty for all.
    """

    tag: ClassVar[str] = "buoyancy"
    of_world: ClassVar[bool] = True

    density: float = WATER
    layers: tuple[tuple[float, float], ...] = ()
    enabled: tuple[str, ...] = ()

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Buoyancy:
        """Read a ``Buoyancy`` with its units and defaults."""
        graded = plugin.find("graded_buoyancy")
        enabled = tuple(each.text for each in plugin.all("enable"))
        if graded is None or plugin.find("uniform_fluid_density"):
            return cls("buoyancy", "", (), (), plugin.number("uniform_fluid_density", WATER), (), enabled)
        layers = {
            each.number("above_depth", 0.0): each.number("density", 0.0)
            for each in graded.all("density_change")
        }
        density = graded.number("default_density", WATER)
        return cls("buoyancy", "", (), (), density, tuple(sorted(layers.items())), enabled)

    def part(self, model: Model, engine: Engine) -> Part:
        links = () if model.static else model.links
        lifted = [link for link in links if self._lifts(model, link) and any(solids_of(link))]
        return BuoyancyPart(self, lifted, model, engine) if lifted else Part()

    def _lifts(self, model: Model, link: Link) -> bool:
        path = f"{model.name}::{link.name}::"
        return not self.enabled or any(path.startswith(f"{each}::") for each in self.enabled)


class BuoyancyPart(MediumPart):
    """Lifts the links of a model."""

    def __init__(self, fluids: Buoyancy, lifted: list[Link], model: Model, engine: Engine) -> None:
        super().__init__(fluids, [link.name for link in lifted], model, engine)
        self._fluids = fluids
        self._solids = [tuple(solids_of(link)) for link in lifted]

    def _push(self, flow: Flow) -> FloatArray:
        upward = -np.array(self._engine.scene.gravity)
        wrenches = np.zeros((len(self._links), 6))
        for row, solids, turn, origin in zip(wrenches, self._solids, flow.turns, flow.origins, strict=True):
            mass, moment = 0.0, np.zeros(3)
            for solid in solids:
                for density, part, at in self._displaced(solid, turn, float(origin[2])):
                    mass += density * part
                    moment += density * at
            row[:3] = turn.T @ (mass * upward)
            row[3:] = turn.T @ cross(moment, upward)
        return wrenches

    def _displaced(
        self, solid: Solid, turn: FloatArray, height: float
    ) -> Iterator[tuple[float, float, FloatArray]]:
        """Yield densities, volumes (m^3) and first moments (m^4), whose sum is that of the displaced fluids.

        A fluid reaches down to the bottom of the world, and the one above replaces it.
        """
        below = self._fluids.density
        whole, moment = solid.volume, solid.volume * (turn @ solid.centre)
        densities = [below, *(density for _, density in self._fluids.layers)]
        yield densities[-1], whole, moment
        for (level, above), under in zip(self._fluids.layers, densities, strict=False):
            part, at = solid.below(turn, level - height)
            yield under - above, part, at


@dataclass(frozen=True)
class Solid:
    """A shape of a link.

    Args:
        volume: m^3.
        centre: the centre of the volume in the frame of the link, m.
        corners: of its triangles, counter-clockwise as seen from outside, shape ``(m, 3, 3)``; those of round
            shapes are scaled to the volume.
    """

    volume: float
    centre: FloatArray
    corners: FloatArray

    @classmethod
    def of(cls, pose: Pose, geometry: Geometry) -> Solid | None:
        """Return the solid of a shape at a pose in the link; None for one without volume."""
        whole = shape_inertia(geometry, 1.0)
        if whole is None:
            return None
        place = matrix_of(pose)
        points, faces = triangles_of(geometry)
        corners = (points @ place[:, :3].T + place[:, 3])[faces]
        centre = np.array((pose @ whole.pose).position)
        drawn, _ = _flux(corners, float(corners[..., 2].max()))
        return cls(whole.mass, centre, centre + (corners - centre) * cbrt(whole.mass / drawn))

    def below(self, turn: FloatArray, level: float) -> tuple[float, FloatArray]:
        """Return volume and first moment below a level, both from the link's origin, in the world's axes."""
        corners = self.corners @ turn.T
        heights = corners[..., 2]
        if heights.min() >= level:
            return 0.0, np.zeros(3)
        if heights.max() <= level:
            return self.volume, self.volume * (turn @ self.centre)
        return _flux(_clip(corners, level), level)


def solids_of(link: Link) -> Iterator[Solid]:
    """Yield the solids of the collision shapes of a link."""
    for collision in link.collisions:
        if (solid := Solid.of(collision.pose, collision.geometry)) is not None:
            yield solid


def _clip(corners: FloatArray, level: float) -> FloatArray:
    """Return the parts of triangles below a level."""
    under = corners[..., 2] < level
    count = under.sum(axis=1)
    mixed = (count == 1) | (count == 2)
    cut, one = corners[mixed], count[mixed] == 1
    alone = np.argmax(under[mixed] == one[:, None], axis=1)  # the corner on its own side
    order = (alone[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(cut, order[..., None], axis=1).swapaxes(0, 1)
    ab, ac = (a + (b - a) * _share(a, b, level), a + (c - a) * _share(a, c, level))
    small = np.stack([a, ab, ac], axis=1)[one]
    quads = np.stack([ab, b, c, ab, c, ac], axis=1)[~one].reshape(-1, 3, 3)
    return np.concatenate([corners[count == 3], small, quads])


def _share(start: FloatArray, end: FloatArray, level: float) -> FloatArray:
    share: FloatArray = ((level - start[:, 2]) / (end[:, 2] - start[:, 2]))[:, None]
    return share


def _flux(corners: FloatArray, level: float) -> tuple[float, FloatArray]:
    """Return volume and first moment between surfaces below a level and the level, by Gauss's theorem.

    The fluxes of ``(0, 0, w)``, ``(0, 0, x w)`` and ``(0, 0, (z^2 - level^2) / 2)`` with ``w = z - level``
    are 0 at the level, and their divergences 1, x and z.
    """
    a, b, c = corners.swapaxes(0, 1)
    areas = cross(b - a, c - a)[:, 2] / 2
    w = corners[..., 2] - level
    total = w.sum(axis=1)
    products = np.einsum("mi,mik->mk", w, corners) + total[:, None] * corners.sum(axis=1)
    moment = areas @ products / 12
    moment[2] = areas @ ((total**2 + (w**2).sum(axis=1)) / 24 + level * total / 3)
    return float(areas @ total / 3), moment
