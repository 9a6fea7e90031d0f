"""Adds to a current simulator the names and methods of PyNN 0.7, which brains of 2014 and 2015 use."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import ModuleType
from typing import Any

import numpy as np
from nrp_pynest.kernel import Kernel
from nrp_pynest.models import valid_recovery_ms
from nrp_pynest.native import native_cell, native_synapse, synapse_model_of
from nrp_spynnaker import pynn07
from nrp_spynnaker.pynn07 import by_name

from nrp_core.brain import FloatArray

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


def accept_positional_label(population: type) -> None:
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


def add_spellings(sim: ModuleType, kernel: Kernel) -> None:
    """Add connectors with weights and delays, ``target`` and ``synapse_dynamics`` to a simulator.

    Args:
        sim: the simulator.
        kernel: the models that a script copies in NEST beside it.
    """
    names = vars(sim)
    for kind in ("Population", "PopulationView", "Assembly"):
        add_methods_to_cells(names[kind])
    accept_positional_label(names["Population"])
    names.update(
        SynapseDynamics=pynn07.SynapseDynamics,
        TsodyksMarkramMechanism=pynn07.TsodyksMarkramMechanism,
        Projection=_projection(sim, with_methods_for_weights(names["Projection"])),
        TsodyksMarkramSynapse=_recovering(names["TsodyksMarkramSynapse"]),
        native_cell_type=lambda name: native_cell(sim, name, kernel),
        native_synapse_type=lambda name: native_synapse(sim, name, kernel),
        STDPMechanism=pynn07.mechanism(names["STDPMechanism"]),
        AdditiveWeightDependence=pynn07.dependence(names["AdditiveWeightDependence"]),
        MultiplicativeWeightDependence=pynn07.dependence(names["MultiplicativeWeightDependence"]),
        RandomDistribution=pynn07.distribution(names["RandomDistribution"]),
        initialize=lambda cells, *old, **values: cells.initialize(*old, **values),
        **{name: pynn07.connector(names[name]) for name in pynn07.CONNECTORS},
    )
    vars(names["random"])["RandomDistribution"] = names["RandomDistribution"]


def _recovering(today: type) -> type:
    class TsodyksMarkramSynapse(today):  # type: ignore[misc]
        def __init__(self, *values: Any, tau_rec: Any = 100.0, **more: Any) -> None:
            numbers = isinstance(tau_rec, (int, float, list, np.ndarray))
            super().__init__(*values, tau_rec=valid_recovery_ms(tau_rec) if numbers else tau_rec, **more)

    return TsodyksMarkramSynapse


def _projection(sim: ModuleType, today: type) -> type:
    class Projection(pynn07.projection(today, vars(sim))):  # type: ignore[misc]
        def __init__(
            self, presynaptic_population: Any, postsynaptic_population: Any, connector: Any = None,
            *values: Any, method: Any = None, **more: Any,
        ) -> None:  # fmt: skip
            connector = method if connector is None else connector
            given = [one for one in (*values, *more.values()) if isinstance(one, str)]
            self._all_inhibit = "inhibitory" in given and postsynaptic_population.conductance_based
            super().__init__(presynaptic_population, postsynaptic_population, connector, *values, **more)

        def _meant(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
            """Return the sizes of negative weights of conductances that inhibit, as NEST takes them."""
            meant: Mapping[str, FloatArray] = super()._meant(values)
            inhibits = self.receptor_type == "inhibitory" and self.post.conductance_based
            if not inhibits or "weight" not in meant or self._is_routed(meant["weight"]):
                return meant
            return {**meant, "weight": abs(meant["weight"])}

        def _check(self, values: Mapping[str, FloatArray]) -> None:
            """Check values; of weights of both signs, which NEST takes, only the sizes."""
            if "weight" in values and self._is_routed(values["weight"]):
                negative = self.receptor_type == "inhibitory" and not self.post.conductance_based
                values = {**values, "weight": abs(values["weight"]) * (-1 if negative else 1)}
            super()._check(values)

        def routes(self) -> Iterator[tuple[str, int, Any]]:
            """Yield the receptors, of weights of both signs as in NEST: those below 0 inhibit."""
            if not self._is_routed(self.values.extremes("weight")):
                yield from super().routes()
                return
            weight = self.values["weight"]
            yield "excitatory", 1, weight >= 0
            yield "inhibitory", -1 if self.post.conductance_based else 1, weight < 0

        def _is_routed(self, weight: FloatArray) -> bool:
            """Return whether the signs of weights choose the receptor, because one does not suit it."""
            known = self.receptor_type in ("excitatory", "inhibitory") and not self._all_inhibit
            takes_currents = self.receptor_type == "excitatory" and not self.post.conductance_based
            least, most = (np.min(weight), np.max(weight)) if np.size(weight) else (0.0, 0.0)
            return known and bool(least < 0 and (takes_currents or most > 0))

        @property
        def nest_synapse_model(self) -> str:
            return synapse_model_of(self, sim)

    Projection.__name__ = Projection.__qualname__ = today.__name__
    return Projection
