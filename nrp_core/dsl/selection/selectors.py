"""Neuron selectors: expressions over ``nrp.brain`` that are evaluated once the brain exists."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

from nrp_core.dsl.selection.selection import Selection
from nrp_core.errors import NeuronSelectionError, NrpError

Find: TypeAlias = Callable[[Any], Any]
Root: TypeAlias = Any
"""A :class:`~nrp_core.dsl.selection.selection.BrainRoot`, or anything with populations as attributes."""


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
        return Selector(lambda root: getattr(self._find(root), name), f"{self._text}.{name}")

    def __getitem__(self, index: Any) -> Selector:
        def find(root: Root) -> Any:
            return self._find(root)[_evaluate(index, root)]

        return Selector(find, f"{self._text}[{_index_text(index)}]")

    def within(self, region: Any) -> Selector:
        """Select the neurons in a region: ``nrp.brain.cells.within(nrp.Box((0, 0), (100, 50)))``.

        Args:
            region: a :class:`~nrp_core.dsl.selection.regions.Box` or
                :class:`~nrp_core.dsl.selection.regions.Sphere`, um.
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
        return _combined(operator.add, "+", self, other)

    def __radd__(self, other: Any) -> Selector:
        if isinstance(other, int) and other == 0:  # sum() begins with 0
            return self
        return _combined(operator.add, "+", other, self)

    def __sub__(self, other: Any) -> Selector:
        return _combined(operator.sub, "-", self, other)

    def __rsub__(self, other: Any) -> Selector:
        return _combined(operator.sub, "-", other, self)

    def __mul__(self, other: Any) -> Selector:
        return _combined(operator.mul, "*", self, other)

    def __rmul__(self, other: Any) -> Selector:
        return _combined(operator.mul, "*", other, self)

    def __floordiv__(self, other: Any) -> Selector:
        return _combined(operator.floordiv, "//", self, other)


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
        return _flattened(_evaluate(selector(item), root) for item in items)

    return Selector(find, f"map_neurons({source!r}, {_name_of(selector)})")


def chain_neurons(*selectors: Any) -> Selector:
    """Return all selections one after another; a device on them becomes a device group."""
    return Selector(
        lambda root: _flattened(_evaluate(selector, root) for selector in selectors),
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


def _evaluate(value: Any, root: Root) -> Any:
    if isinstance(value, Selector):
        return value._find(root)
    if isinstance(value, (list, tuple)):
        return type(value)(_evaluate(item, root) for item in value)
    if isinstance(value, slice):
        return slice(*(_evaluate(item, root) for item in (value.start, value.stop, value.step)))
    return value


def _combined(operation: Callable[[Any, Any], Any], sign: str, left: Any, right: Any) -> Selector:
    def find(root: Root) -> Any:
        return operation(_evaluate(left, root), _evaluate(right, root))

    return Selector(find, f"({left!r} {sign} {right!r})")


def _flattened(items: Iterable[Any]) -> list[Any]:
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
