"""Methods of populations and projections that PyNN 0.7 had, for the classes of one simulator."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrp_core.brain.pynn.former import by_name

_RECORDED = {"record_v": "v", "record_gsyn": ["gsyn_exc", "gsyn_inh"]}
_NOTHING_YET = {"getSpikes": 2, "get_v": 3, "get_gsyn": 4}
"""Methods that return recorded data, which are empty here, with the number of columns."""
_WRITTEN = ("printSpikes", "print_v", "print_gsyn")
_OF_WEIGHTS = {
    "setWeights": "weight", "randomizeWeights": "weight", "setDelays": "delay", "randomizeDelays": "delay",
}  # fmt: skip


def add_methods_to_cells(cells: type) -> None:
    """Add ``set("tau_m", 10.0)``, ``rset``, ``record_v`` and similar methods to a class of cells."""
    methods: dict[str, Any] = {
        "set": by_name(cells.set),  # type: ignore[attr-defined]
        "initialize": by_name(cells.initialize),  # type: ignore[attr-defined]
        "rset": lambda self, name, values: self.set(**{name: values}),
        "tset": lambda self, name, values: self.set(**{name: np.ravel(values)}),
        "randomInit": lambda self, values: self.initialize(v=values),
        "record": _of_spikes(cells.record),  # type: ignore[attr-defined]
        **{name: _recording(what) for name, what in _RECORDED.items()},
        **{name: _empty(columns) for name, columns in _NOTHING_YET.items()},
        **dict.fromkeys(_WRITTEN, _nothing),
        "meanSpikeCount": lambda _self, **_more: 0.0,
    }
    for name, method in methods.items():
        setattr(cells, name, method)


def let_label_follow(population: type) -> None:
    """Make a class of populations accept its label in place of the structure, as in PyNN 0.7."""
    today = population.__init__  # type: ignore[misc]

    def begin(
        self: Any, size: Any, cellclass: Any, cellparams: Any = None, structure: Any = None,
        *values: Any, **more: Any,
    ) -> None:  # fmt: skip
        if isinstance(structure, str):
            structure, more = None, {"label": structure, **more}
        today(self, size, cellclass, cellparams, structure, *values, **more)

    population.__init__ = begin  # type: ignore[misc]


def with_methods_for_weights(projection: type) -> type:
    """Return a class of projections with ``setWeights``, ``getWeights`` and similar methods."""
    methods: dict[str, Any] = {
        **{name: _setting(attribute) for name, attribute in _OF_WEIGHTS.items()},
        "getWeights": _getting("weight"), "getDelays": _getting("delay"),
        "printWeights": _nothing, "saveConnections": _nothing, "setSynapseDynamics": _nothing,
    }  # fmt: skip
    for name, method in methods.items():
        setattr(projection, name, method)
    return projection


def _of_spikes(today: Callable[..., Any]) -> Callable[..., Any]:
    return lambda self, variables="spikes", *values, **more: today(self, variables, *values, **more)


def _recording(what: Any) -> Callable[..., Any]:
    return lambda self, **_more: self.record(what)


def _empty(columns: int) -> Callable[..., Any]:
    return lambda _self, *_values, **_more: np.empty((0, columns))


def _setting(name: str) -> Callable[..., Any]:
    return lambda self, value: self.set(**{name: value})


def _getting(name: str) -> Callable[..., Any]:
    def get(self: Any, format: str = "list", **_more: Any) -> Any:  # noqa: A002 - the name of PyNN
        return self.get(name, format, with_address=False) if format == "list" else self.get(name, format)

    return get


def _nothing(_self: Any, *_values: Any, **_more: Any) -> None:
    """Do nothing, because it is not needed here."""
