"""Replace the objects of a brain file by their running counterparts, anywhere in its variables."""

from __future__ import annotations

from collections.abc import Callable
from operator import is_
from types import ModuleType
from typing import Any

import numpy as np
from nrp_pynest.built import BuiltBrain
from pyNN.common import Assembly, BasePopulation, IDMixin
from pyNN.common import Projection as AnyProjection

from nrp_core.brain import IntArray, Projection
from nrp_core.errors import CapabilityError
from nrp_core.network.pynn.populations import ids_of
from nrp_legacy.live.cells import Cells


class Synapses:
    """A projection.

    Args:
        built: the objects of the brain file.
        label: the label of the projection.
    """

    def __init__(self, built: BuiltBrain, label: str) -> None:
        self._built, self.label = built, label

    def __len__(self) -> int:
        return int(self._built.projection(self.label).size)

    def size(self) -> int:
        """Return the number of synapses."""
        return len(self)

    def get(self, name: Any, format: str = "list", with_address: bool = True, **_options: Any) -> Any:  # noqa: A002
        """Return weights (PyNN's units) or delays (ms).

        Args:
            name: ``weight`` or ``delay``; several names give a list.
            format: ``array`` for a matrix over the cells with synapses, NaN for no synapse, else ``list``.
            with_address: whether entries of a list begin with source and target.
        """
        if not isinstance(name, str):
            return [self.get(one, format, with_address) for one in name]
        projection = self._built.projection(self.label)
        values = projection.delay_ms if name == "delay" else self._built.brain.read_weights(self.label)
        pre, post = _places(projection)
        if format == "array":
            matrix = np.full((pre.max(initial=-1) + 1, post.max(initial=-1) + 1), np.nan)
            matrix[pre, post] = values
            return matrix
        rows = zip(pre.tolist(), post.tolist(), values.tolist(), strict=True)
        return list(rows) if with_address else values.tolist()

    def set(self, **values: Any) -> None:
        """Set ``weight``: one number, a list, or a matrix as from :meth:`get`.

        Raises:
            CapabilityError: another parameter is to change, which brains here do not support.
        """
        if values.keys() - {"weight"}:
            raise CapabilityError(
                f"{', '.join(values)}: only the weight of a synapse can change during a run"
            )
        weight = np.asarray(values["weight"], dtype=float)
        if weight.ndim > 1:
            weight = weight[_places(self._built.projection(self.label))]
        self._built.brain.set_weights(self.label, weight)

    def getWeights(self, format: str = "list", **_options: Any) -> Any:  # noqa: A002, N802 - PyNN 0.7
        """Return weights."""
        return self.get("weight", format, with_address=False)

    def getDelays(self, format: str = "list", **_options: Any) -> Any:  # noqa: A002, N802 - PyNN 0.7
        """Return delays."""
        return self.get("delay", format, with_address=False)

    def setWeights(self, weights: Any) -> None:  # noqa: N802 - PyNN 0.7
        """Set weights."""
        self.set(weight=weights)


def _places(projection: Projection) -> tuple[IntArray, IntArray]:
    """Return the indices of the source and target of each synapse among the cells with synapses."""
    ends = (projection.pre_index, projection.post_index)
    pre, post = (np.unique(cells, return_inverse=True)[1] for cells in ends)
    return pre, post


_OF_FILES = "@"
"""In the names of modules that are files of users, see :mod:`nrp_core.scripts`."""

IdsOf = Callable[[Any], IntArray | None]
"""Returns the global ids of a collection of nodes of NEST, None for other values."""


class Contents:
    """The variables of one file, cells and synapses in them replaced.

    Lists, dictionaries, objects and modules of the file are changed in place, so that its functions see the
    running brain. Nodes of NEST stay, because its functions pass them to NEST; from outside they are seen as
    cells.

    Args:
        built: the objects of the brain file.
        nodes: returns the nodes of NEST in a value.
    """

    def __init__(self, built: BuiltBrain, nodes: IdsOf) -> None:
        self._built, self._nodes = built, nodes
        self._seen: dict[int, Any] = {}

    def replace(self, variables: dict[str, Any]) -> None:
        """Replace the contents of variables."""
        for name, value in list(variables.items()):
            if name[:2] != "__":
                variables[name] = self._replaced(value, name)

    def shown(self, value: Any, name: str) -> Any:
        """Return a value for transfer functions, with cells for nodes of NEST, also in collections.

        A collection without nodes is returned itself, so that functions can change it.
        """
        ids = self._nodes(value)
        if ids is not None:
            return Cells(self._built, name, ids)
        if type(value) is list or isinstance(value, tuple):
            return _with(value, [self.shown(one, f"{name}[{i}]") for i, one in enumerate(value)])
        if type(value) is dict:
            parts = {key: self.shown(one, f"{name}[{key!r}]") for key, one in value.items()}
            return value if all(map(is_, parts.values(), value.values())) else parts
        return Seen(value, name, self.shown) if self._holds_nodes(value) else value

    def _holds_nodes(self, value: Any) -> bool:
        return _is_of_users(value) and any(self._nodes(one) is not None for one in vars(value).values())

    def _replaced(self, value: Any, name: str) -> Any:
        if isinstance(value, (BasePopulation, Assembly)):
            return Cells(self._built, name, ids_of(value))
        if isinstance(value, IDMixin):
            return Cells(self._built, name, np.array([int(value)]))
        if isinstance(value, AnyProjection):
            return Synapses(self._built, value.label)
        if id(value) in self._seen:
            return self._seen[id(value)]
        return self._within(value, name)

    def _within(self, value: Any, name: str) -> Any:
        """Replace the contents of a collection or object."""
        if isinstance(value, tuple):
            return _with(value, [self._replaced(one, f"{name}[{i}]") for i, one in enumerate(value)])
        self._seen[id(value)] = value
        if type(value) is list:
            value[:] = [self._replaced(one, f"{name}[{i}]") for i, one in enumerate(value)]
        elif isinstance(value, dict):
            for key, one in list(value.items()):
                value[key] = self._replaced(one, f"{name}[{key!r}]")
        elif isinstance(value, ModuleType):
            if _OF_FILES in value.__name__:
                self.replace(vars(value))
        elif _is_of_users(value):
            for key, one in list(vars(value).items()):
                if (new := self._replaced(one, f"{name}.{key}")) is not one:
                    setattr(value, key, new)
        return value


class Seen:
    """An object of a brain file whose nodes of NEST are seen as cells.

    Args:
        of: the object.
        name: its name.
        show: returns the visible value of an attribute.
    """

    def __init__(self, of: Any, name: str, show: Callable[[Any, str], Any]) -> None:
        vars(self).update(_of=of, _name=name, _show=show)

    def __getattr__(self, name: str) -> Any:
        return self._show(getattr(self._of, name), f"{self._name}.{name}")

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._of, name, value)


def _with(value: Any, parts: list[Any]) -> Any:
    """Return a list, tuple or named tuple with other items; itself if they are the same."""
    return value if all(map(is_, parts, value)) else getattr(type(value), "_make", type(value))(parts)


def _is_of_users(value: Any) -> bool:
    """Whether a value is an object, or a class with attributes, that a file of the user defines."""
    kind = value if isinstance(value, type) else type(value)
    return _OF_FILES in str(kind.__module__) and hasattr(value, "__dict__")
