"""Nodes with positions: layers, masks, distances and the functions that ask for them (``nest.spatial``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.brain import BoolArray, FloatArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_pynest.parameters import Parameter, Places

_ROUNDING = 1e-10
"""A mask includes positions on its border, as in NEST, up to an error of rounding."""


@dataclass(frozen=True)
class Layer:
    """The positions of the nodes of one call of ``Create``.

    Args:
        positions: shape ``(n, dimensions)``.
        extent: size of the layer in each dimension.
        center: its center.
        wrap: whether the layer's opposite edges are the same place.
        shape: columns, rows and levels of a grid; None for free positions.
    """

    positions: FloatArray
    extent: FloatArray
    center: FloatArray
    wrap: bool = False
    shape: tuple[int, ...] | None = None

    def described(self, n: int) -> dict[str, Any]:
        """Return what NEST tells of the positions of ``n`` nodes."""
        told = {"center": tuple(self.center), "extent": tuple(self.extent), "edge_wrap": self.wrap,
                "network_size": n}  # fmt: skip
        places = {"shape": self.shape} if self.shape else {"positions": tuple(map(tuple, self.positions))}
        return {**told, **places}

    def displacement(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Return the shortest way from positions to others; across the edges if the layer wraps."""
        way = end - start
        if not self.wrap:
            return way
        return np.asarray((way + self.extent / 2) % self.extent - self.extent / 2)


@dataclass(frozen=True)
class Grid:
    """Nodes on a grid; in NEST 3 the order is column by column, from the upper left."""

    shape: Sequence[int]
    center: Sequence[float] | None = None
    extent: Sequence[float] | None = None
    edge_wrap: bool = False

    def layer(self, _n: int, _random: np.random.RandomState) -> Layer:
        """Return the positions."""
        shape = tuple(map(int, self.shape))
        extent = np.ones(len(shape)) if self.extent is None else np.asarray(self.extent, float)
        center = np.zeros(len(shape)) if self.center is None else np.asarray(self.center, float)
        steps = extent / np.array(shape)
        axes = [
            center[k] - extent[k] / 2 + (np.arange(count) + 0.5) * steps[k] for k, count in enumerate(shape)
        ]
        axes[1] = axes[1][::-1]
        positions = np.stack([one.ravel() for one in np.meshgrid(*axes, indexing="ij")], axis=1)
        return Layer(positions, extent, center, self.edge_wrap, shape)


@dataclass(frozen=True)
class Free:
    """Nodes at given or random positions."""

    pos: Any
    extent: Sequence[float] | None = None
    edge_wrap: bool = False
    num_dimensions: int | None = None

    def layer(self, n: int, random: np.random.RandomState) -> Layer:
        """Return the positions.

        Raises:
            NetworkError: random positions have neither an extent nor a number of dimensions.
        """
        if isinstance(self.pos, Parameter):
            dimensions = self.num_dimensions or (0 if self.extent is None else len(self.extent))
            if not dimensions:
                raise NetworkError("nest.spatial.free: random positions need extent or num_dimensions")
            positions = np.stack([self.pos.at(Places(n, random)) for _ in range(dimensions)], axis=1)
        elif isinstance(self.pos[0], Parameter):  # one for each dimension
            positions = np.stack([one.at(Places(n, random)) for one in self.pos], axis=1)
        else:
            listed = self.pos if np.ndim(self.pos[0]) else [self.pos]
            positions = np.array([_position(one, random) for one in listed], float)
        low, high = positions.min(axis=0), positions.max(axis=0)
        if self.extent is not None:
            extent = np.asarray(self.extent, float)
            center = np.zeros(len(extent)) if isinstance(self.pos, Parameter) else (low + high) / 2
        else:
            extent, center = 1.1 * (high - low), (low + high) / 2  # NEST adds 10 %
        return Layer(positions, extent, center, self.edge_wrap)


def _position(one: Any, random: np.random.RandomState) -> list[float]:
    return [float(x.at(Places(1, random))[0]) if isinstance(x, Parameter) else float(x) for x in one]


def grid(shape: Sequence[int], center: Any = None, extent: Any = None, edge_wrap: bool = False) -> Grid:
    """Return positions on a grid."""
    return Grid(shape, center, extent, edge_wrap)


def free(pos: Any, extent: Any = None, edge_wrap: bool = False, num_dimensions: int | None = None) -> Free:
    """Return given or random positions."""
    return Free(pos, extent, edge_wrap, num_dimensions)


# -- parameters of positions


class _Axes:
    """Coordinates as parameters: ``x``, ``y``, ``z`` and ``n(dimension)``."""

    def __init__(self, what: str) -> None:
        self._what = what
        self.x, self.y, self.z = (self.n(k) for k in range(3))

    def n(self, dimension: int) -> Parameter:
        """Return a coordinate."""
        return Parameter(lambda places: places.of(self._what)[:, dimension])


class _Distance(Parameter):
    """The distance between source and target, and its parts along each axis."""

    def __init__(self) -> None:
        super().__init__(lambda places: np.sqrt((places.of("displacement") ** 2).sum(axis=1)))
        self.x, self.y, self.z = (self.n(k) for k in range(3))

    def n(self, dimension: int) -> Parameter:
        """Return the distance along one axis."""
        return Parameter(lambda places: np.abs(places.of("displacement")[:, dimension]))


def spatial_module() -> ModuleType:
    """Return ``nest.spatial``."""
    made = ModuleType("nest.spatial")
    vars(made).update(
        grid=grid, free=free, distance=_Distance(), pos=_Axes("positions"), source_pos=_Axes("sources"),
        target_pos=_Axes("targets"),
    )  # fmt: skip
    return made


# -- masks


@dataclass(frozen=True)
class Mask:
    """The region in which nodes are connected, around the node that :func:`inside` is asked for.

    Args:
        kind: NEST's name of the shape.
        settings: its sizes.
        anchor: where the node lies in it.
    """

    kind: str
    settings: Mapping[str, Any]
    anchor: Sequence[float] = ()


def mask_of(given: Any) -> Mask:
    """Return a mask from ``CreateMask`` or from its dictionary.

    Raises:
        NetworkError: its shape is not supported.
    """
    if isinstance(given, Mask):
        return given
    anchor = given.get("anchor", ())
    kinds = [name for name in given if name != "anchor"]
    if len(kinds) != 1 or kinds[0] not in _SHAPES:
        name = kinds[0] if kinds else ""
        raise NetworkError(f"nest: the mask '{name}' is not supported{did_you_mean(name, _SHAPES)}")
    return Mask(kinds[0], given[kinds[0]], anchor)


def inside(mask: Mask, displacement: FloatArray) -> BoolArray:
    """Return which displacements, shape ``(n, dimensions)``, lie in a mask."""
    way = displacement - np.asarray(mask.anchor, float) if len(mask.anchor) else displacement
    return np.asarray(_SHAPES[mask.kind](way, mask.settings), bool)


def inside_layer(mask: Mask, layer: Layer, start: FloatArray, end: FloatArray) -> BoolArray:
    """Return which positions lie in a mask around others; a layer that wraps continues beyond its edges."""
    way = layer.displacement(start, end)
    copies = product((-1.0, 0.0, 1.0) if layer.wrap else (0.0,), repeat=way.shape[1])
    found: BoolArray = np.logical_or.reduce(
        [inside(mask, way + np.array(copy) * layer.extent) for copy in copies]
    )
    return found


def _ball(way: FloatArray, settings: Mapping[str, Any]) -> Any:
    return (way**2).sum(axis=1) <= float(settings["radius"]) ** 2 + _ROUNDING


def _ring(way: FloatArray, settings: Mapping[str, Any]) -> Any:
    squares = (way**2).sum(axis=1)
    inner = float(settings["inner_radius"]) ** 2 + _ROUNDING  # its border belongs to the hole
    return (squares > inner) & (squares <= float(settings["outer_radius"]) ** 2 + _ROUNDING)


def _box(way: FloatArray, settings: Mapping[str, Any]) -> Any:
    turned = _turned(way, float(settings.get("azimuth_angle", 0.0)))
    low, high = np.asarray(settings["lower_left"], float), np.asarray(settings["upper_right"], float)
    return ((turned >= low - _ROUNDING) & (turned <= high + _ROUNDING)).all(axis=1)


def _ellipse(way: FloatArray, settings: Mapping[str, Any]) -> Any:
    turned = _turned(way, float(settings.get("azimuth_angle", 0.0)))
    axes = [float(settings["major_axis"]), float(settings["minor_axis"])]
    axes += [float(settings.get("polar_axis", axes[0]))] * (way.shape[1] - 2)
    return ((turned / (np.array(axes) / 2)) ** 2).sum(axis=1) <= 1 + _ROUNDING


def _turned(way: FloatArray, degrees: float) -> FloatArray:
    if not degrees:
        return way
    angle = np.deg2rad(degrees)
    made = way.copy()
    made[:, 0] = way[:, 0] * np.cos(angle) + way[:, 1] * np.sin(angle)
    made[:, 1] = way[:, 1] * np.cos(angle) - way[:, 0] * np.sin(angle)
    return made


_SHAPES = {
    "circular": _ball, "spherical": _ball, "doughnut": _ring, "rectangular": _box, "box": _box,
    "elliptical": _ellipse, "ellipsoidal": _ellipse,
}  # fmt: skip
