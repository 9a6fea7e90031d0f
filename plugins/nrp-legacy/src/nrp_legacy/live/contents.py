"""Replace the objects of a brain file by their running counterparts, anywhere in its variables."""

from __future__ import annotations

from collections.abc import Callable
from operator import is_
from types import ModuleType
from typing import Any

import numpy as np
from pyNN.common import Assembly, BasePopulation, IDMixin
from pyNN.common import Projection as AnyProjection

from nrp_core._support.arrays import IntArray
from nrp_core.brain.pynn.populations import ids_of
from nrp_legacy.live.built import BuiltBrain
from nrp_legacy.live.cells import Cells
from nrp_legacy.live.synapses import Synapses

_OF_FILES = "@"
"""In the names of modules that are files of users, see :mod:`nrp_core._support.scoped_import`."""

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
