"""Selection of neurons by name, index and location, and of projections by name."""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import NeuronSelectionError, NrpError
from nrp_core.network.changes import projection_of
from nrp_core.network.data import Network, Projection
from nrp_core.network.groups import SEPARATOR


class Region(ABC):
    """A part of space."""

    @abstractmethod
    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which positions lie in it, its border included; shape ``(n, 3)`` gives ``(n,)``."""


class Box(Region):
    """A box along the axes.

    Args:
        low, high: two opposite corners, um; infinite on an open side.

    Raises:
        NeuronSelectionError: these are not points, or the first is not below the second.
    """

    def __init__(self, low: Sequence[float], high: Sequence[float]) -> None:
        self.low, self.high = point(low, "a corner of a box"), point(high, "a corner of a box")
        if len(self.low) != len(self.high):
            raise NeuronSelectionError(
                f"{self!r}: its corners must be alike, not of {len(self.low)} and {len(self.high)} numbers"
            )
        if (self.low > self.high).any():
            raise NeuronSelectionError(f"{self!r} is empty: its first corner must have the smaller numbers")

    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        some = positions_um[:, : len(self.low)]
        return np.asarray(((some >= self.low) & (some <= self.high)).all(axis=1))

    def __repr__(self) -> str:
        return f"Box({_text(self.low)}, {_text(self.high)})"


class Sphere(Region):
    """A ball, or a cylinder if the center has two numbers.

    Args:
        center: a point, um.
        radius: um.

    Raises:
        NeuronSelectionError: the point or the radius is invalid.
    """

    def __init__(self, center: Sequence[float], radius: float) -> None:
        self.center, self.radius = point(center, "the center of a sphere", finite=True), radius
        if not (isinstance(radius, (int, float, np.number)) and radius >= 0):
            raise NeuronSelectionError(f"the radius of a sphere is 0 um or more, not {radius!r}")

    def contains(self, positions_um: FloatArray) -> npt.NDArray[np.bool_]:
        return np.asarray(distances_um(positions_um, self.center) <= self.radius)

    def __repr__(self) -> str:
        return f"Sphere({_text(self.center)}, {self.radius:g})"


def point(value: Any, what: str, *, finite: bool = False) -> FloatArray:
    """Return a point of two or three numbers.

    Args:
        value: the numbers, um.
        what: name of the point, for the message.
        finite: whether to refuse infinity; NaN is always refused.

    Raises:
        NeuronSelectionError: the value is not a point.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    unusable = np.isnan(array).any() or (finite and np.isinf(array).any())
    if array.ndim != 1 or len(array) not in (2, 3) or unusable:
        raise NeuronSelectionError(f"{what} is two or three numbers in um, e.g. (0, 50, 100), not {value!r}")
    return array


def distances_um(positions_um: FloatArray, center: FloatArray) -> FloatArray:
    """Return the distances of positions, shape ``(n, 3)``, from a point, in the coordinates of the point."""
    distances: FloatArray = np.linalg.norm(positions_um[:, : len(center)] - center, axis=1)
    return distances


def _text(values: FloatArray) -> str:
    return f"({', '.join(f'{value:g}' for value in values)})"


GROUP: Final = "group"
PROJECTION: Final = "projection"


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """An ordered selection of neurons.

    Indices work as in NumPy, with two differences: a single index gives a selection of one neuron, and a
    tuple joins the selections of its items: ``sensors[0, 2]``, ``sensors[0, 3:5]``.

    Args:
        ids: global ids, shape ``(n,)``.
        label: the name of their population or view.
        network: their network, which has their positions.
    """

    ids: IntArray
    label: str
    network: Network | None = None

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def size(self) -> int:
        """Number of neurons."""
        return len(self.ids)

    def __getitem__(self, index: Any) -> Selection:
        return self._of(self._chosen(index))

    def __add__(self, other: Selection) -> Selection:
        if not isinstance(other, Selection):
            return NotImplemented
        ids = np.concatenate([self.ids, other.ids])
        return Selection(ids, f"{self.label} + {other.label}", self.network)

    def __radd__(self, other: int) -> Selection:
        if other != 0:  # sum() begins with 0
            return NotImplemented
        return self

    @property
    def positions_um(self) -> FloatArray:
        """Their positions, shape ``(n, 3)``.

        Raises:
            NeuronSelectionError: the network has no positions.
        """
        if self.network is None:
            raise NeuronSelectionError(f"'{self.label}' has no positions")
        return self.network.positions_of(self.ids)

    def within(self, region: Region) -> Selection:
        """Return the neurons in a region, in order; there may be none.

        Raises:
            NeuronSelectionError: they have no positions, or the argument is not a region.
        """
        if not isinstance(region, Region):
            raise NeuronSelectionError(f"a region is a Box or a Sphere, not {region!r}")
        return self._of(self.ids[region.contains(self.positions_um)])

    def nearest(self, center: Sequence[float], n: int = 1) -> Selection:
        """Return the ``n`` neurons nearest to a point (um), the nearest first; ties go to the first neurons.

        Raises:
            NeuronSelectionError: they have no positions, the argument is not a point, or there are fewer
                than ``n``.
        """
        if not isinstance(n, (int, np.integer)) or isinstance(n, bool) or not 0 < n <= self.size:
            raise NeuronSelectionError(
                f"'{self.label}' has {self.size} neurons; cannot select the nearest {n!r}"
            )
        distances = distances_um(self.positions_um, point(center, "the center of a search", finite=True))
        return self._of(self.ids[np.argsort(distances, kind="stable")[:n]])

    def _of(self, ids: IntArray) -> Selection:
        return Selection(ids, self.label, self.network)

    def _chosen(self, index: Any) -> IntArray:
        if isinstance(index, tuple):
            return np.concatenate([self.ids[:0], *map(self._chosen, index)])
        if isinstance(index, slice):
            return self.ids[index]
        wanted = np.asarray(index)
        if wanted.size == 0:
            return self.ids[:0]
        if wanted.dtype.kind not in ("iu" if wanted.ndim == 0 else "iub") or wanted.ndim > 1:
            raise NeuronSelectionError(f"neurons are selected by integers, slices and lists, not {index!r}")
        try:
            return np.atleast_1d(self.ids[wanted])
        except IndexError:
            raise NeuronSelectionError(
                f"'{self.label}' has {self.size} neurons, 0..{self.size - 1}; {index!r} is out of range"
            ) from None


class Groups:
    """Populations and groups by their names, which need not be names of Python: ``group["5-HT"]``.

    Args:
        find: returns the neurons of a name.
    """

    __slots__ = ("_find",)

    def __init__(self, find: Callable[[str], Selection]) -> None:
        self._find = find

    def __repr__(self) -> str:
        return "the groups of the brain"

    def __getitem__(self, name: str) -> Selection:
        if not isinstance(name, str):
            raise NeuronSelectionError(f"brain.group is indexed by the name of a group, not by {name!r}")
        return self._find(name)


class BrainRoot:
    """The value of ``nrp.brain``: every population and view of a network by its name.

    ``group`` has them by name too, unless one of them is called ``group``. The name of a model, of several,
    gives what it has: ``nrp.brain.red.eyes``.

    Args:
        network: the network.
        begin: what the names of the model begin with: ``red.``.
    """

    __slots__ = ("_begin", "_network")

    def __init__(self, network: Network, begin: str = "") -> None:
        self._network, self._begin = network, begin

    def __getitem__(self, name: object) -> Any:
        meant = f"nrp.brain.group[{name!r}]" if isinstance(name, str) else f"nrp.brain.NAME[{name!r}]"
        raise NeuronSelectionError(f"nrp.brain holds populations by their names: write {meant}")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        whole, known = self._begin + name, (*self._network.views, *self._network.populations)
        if whole in known:
            return self._named(name)
        if any(one.startswith(whole + SEPARATOR) for one in known):
            return BrainRoot(self._network, whole + SEPARATOR)
        return Groups(self._named) if name == GROUP else self._named(name)

    def _named(self, name: str) -> Selection:
        return Selection(self._network.neurons(self._begin + name), self._begin + name, self._network)

    def _projection(self, label: str) -> Projection:
        return projection_of(self._network, self._begin + label)


Find: TypeAlias = Callable[[Any], Any]
Root: TypeAlias = Any
"""A :class:`~nrp_core.dsl.selection.BrainRoot`, or anything with populations as attributes."""


class Selector:
    """An expression over the brain, evaluated later.

    Attributes, indices and arithmetic are recorded: ``nrp.brain.sensors[0:3:2]``,
    ``nrp.brain.left + nrp.brain.right``, ``nrp.brain.sensors.size - 1``. So are selections by location:
    ``nrp.brain.sensors.within(nrp.Sphere((0, 0), 50))``, ``nrp.brain.sensors.nearest((0, 0), 3)``, and
    names that are not names of Python: ``nrp.brain.group["5-HT"]``.

    Args:
        find: evaluates the expression, given the root of the brain.
        text: the expression as text.
    """

    __slots__ = ("_find", "_text")

    # Without these, Python would index a selector for ever, because no index is out of range.
    __iter__ = None
    __contains__ = None

    def __init__(self, find: Find, text: str) -> None:
        self._find = find
        self._text = text

    def __repr__(self) -> str:
        return self._text

    def __getattr__(self, name: str) -> Selector:
        if name.startswith("_"):  # Python's protocols for copying, pickling and display
            raise AttributeError(name)
        found, text = lambda root: getattr(self._find(root), name), f"{self._text}.{name}"
        return ProjectionSelector(found, text, self._find) if name == PROJECTION else Selector(found, text)

    def __getitem__(self, index: Any) -> Selector:
        def find(root: Root) -> Any:
            return self._find(root)[_evaluate(index, root)]

        return Selector(find, f"{self._text}[{_index_text(index)}]")

    def within(self, region: Any) -> Selector:
        """Select the neurons in a region: ``nrp.brain.cells.within(nrp.Box((0, 0), (100, 50)))``.

        Args:
            region: a :class:`~nrp_core.dsl.selection.Box` or
                :class:`~nrp_core.dsl.selection.Sphere`, um.
        """
        return self._choosing("within", region)

    def nearest(self, center: Any, n: Any = 1) -> Selector:
        """Select the ``n`` neurons nearest to a point (um), the nearest first."""
        return self._choosing("nearest", center, n)

    def _choosing(self, method: str, *arguments: Any) -> Selector:
        def find(root: Root) -> Any:
            found = self._find(root)
            if not isinstance(found, Selection):
                raise NeuronSelectionError(f"{self._text} are not neurons with a location")
            return getattr(found, method)(*_evaluate(arguments, root))

        return Selector(find, f"{self._text}.{method}({', '.join(map(repr, arguments))})")

    def __add__(self, other: Any) -> Selector:
        return _combine(operator.add, "+", self, other)

    def __radd__(self, other: Any) -> Selector:
        if isinstance(other, int) and other == 0:  # sum() begins with 0
            return self
        return _combine(operator.add, "+", other, self)

    def __sub__(self, other: Any) -> Selector:
        return _combine(operator.sub, "-", self, other)

    def __rsub__(self, other: Any) -> Selector:
        return _combine(operator.sub, "-", other, self)

    def __mul__(self, other: Any) -> Selector:
        return _combine(operator.mul, "*", self, other)

    def __rmul__(self, other: Any) -> Selector:
        return _combine(operator.mul, "*", other, self)

    def __floordiv__(self, other: Any) -> Selector:
        return _combine(operator.floordiv, "//", self, other)


class ProjectionSelector(Selector):
    """The value of ``nrp.brain.projection``, which is called with a label.

    Without a call it is the population of this name, if any.

    Args:
        owner: finds the brain, or the model of several, that has the projection.
    """

    __slots__ = ("_owner",)

    def __init__(self, find: Find, text: str, owner: Find) -> None:
        super().__init__(find, text)
        self._owner = owner

    def __call__(self, label: Any) -> Selector:
        """Select the projection with a label: ``nrp.brain.projection("eyes -> motors")``."""
        return Selector(
            lambda root: self._owner(root)._projection(_evaluate(label, root)), f"{self!r}({label!r})"
        )


brain = Selector(lambda root: root, "brain")
"""The future brain: its attributes are the populations of the network."""


def nrange(start: Any, stop: Any, step: Any = 1) -> Selector:
    """Return a range whose bounds may depend on the brain: ``nrange(0, nrp.brain.sensors.size)``."""
    bounds = (start, stop, 1 if step is None else step)
    return Selector(lambda root: range(*_evaluate(bounds, root)), f"nrange{bounds}")


def resolve(function: Callable[[Any], Any]) -> Selector:
    """Return the result of ``function(brain)``, evaluated once the brain exists, e.g. neurons or a number."""
    if not callable(function):
        raise TypeError(f"resolve takes a function of the brain, not {function!r}")
    return Selector(lambda root: _evaluate(function(root), root), f"resolve({_name_of(function)})")


def map_neurons(source: Any, selector: Callable[[Any], Any]) -> Selector:
    """Return one selection for each item of ``source``; a device on them becomes a device group.

    Args:
        source: a range, list or number of items; it may depend on the brain.
        selector: gives the neurons for an item, e.g. ``lambda i: nrp.brain.sensors[i]``.
    """

    def find(root: Root) -> list[Any]:
        items = _evaluate(source, root)
        items = range(items) if isinstance(items, int) else items
        return _flatten(_evaluate(selector(item), root) for item in items)

    return Selector(find, f"map_neurons({source!r}, {_name_of(selector)})")


def chain_neurons(*selectors: Any) -> Selector:
    """Return all selections in sequence; a device on them becomes a device group."""
    return Selector(
        lambda root: _flatten(_evaluate(selector, root) for selector in selectors),
        f"chain_neurons({', '.join(map(repr, selectors))})",
    )


def evaluate(value: Any, root: Root) -> Any:
    """Return a value in which every selector, also in lists and tuples, is replaced by its result.

    Raises:
        NeuronSelectionError: a selector cannot be evaluated on this brain.
    """
    try:
        return _evaluate(value, root)
    except NrpError:
        raise
    except Exception as error:
        raise NeuronSelectionError(f"{value!r}: {type(error).__name__}: {error}") from error


def select(selector: Any, root: Root) -> Selection | list[Selection]:
    """Return the neurons that a selector finds: one selection, or a list for a device group.

    Raises:
        NeuronSelectionError: a population or index does not exist, or no neuron is found.
    """
    found = evaluate(selector, root)
    parts = found if isinstance(found, list) else [found]
    for part in parts:
        if not isinstance(part, Selection):
            raise NeuronSelectionError(f"{selector!r} gives {part!r:.60}, which are not neurons")
    if not parts or not all(map(len, parts)):
        raise NeuronSelectionError(f"{selector!r} selects no neurons")
    return parts if isinstance(found, list) else parts[0]


def select_projection(selector: Any, root: Root) -> Projection:
    """Return the projection that a selector finds.

    Raises:
        NetworkError: no projection has this label.
        NeuronSelectionError: the selector finds something else.
    """
    found = evaluate(selector, root)
    if not isinstance(found, Projection):
        raise NeuronSelectionError(
            f"{selector!r} is not a projection; one is selected by its label: "
            "nrp.brain.projection('eyes -> motors')"
        )
    return found


def _evaluate(value: Any, root: Root) -> Any:
    if isinstance(value, Selector):
        return value._find(root)
    if isinstance(value, (list, tuple)):
        return type(value)(_evaluate(item, root) for item in value)
    if isinstance(value, slice):
        return slice(*(_evaluate(item, root) for item in (value.start, value.stop, value.step)))
    return value


def _combine(operation: Callable[[Any, Any], Any], sign: str, left: Any, right: Any) -> Selector:
    def find(root: Root) -> Any:
        return operation(_evaluate(left, root), _evaluate(right, root))

    return Selector(find, f"({left!r} {sign} {right!r})")


def _flatten(items: Iterable[Any]) -> list[Any]:
    flat: list[Any] = []
    for item in items:
        flat += item if isinstance(item, list) else [item]
    return flat


def _name_of(function: Callable[..., Any]) -> str:
    return getattr(function, "__name__", repr(function))


def _index_text(index: Any) -> str:
    if isinstance(index, slice):
        bounds = [index.start, index.stop] if index.step is None else [index.start, index.stop, index.step]
        return ":".join("" if bound is None else repr(bound) for bound in bounds)
    if isinstance(index, tuple):
        return ", ".join(map(_index_text, index))
    return repr(index)
