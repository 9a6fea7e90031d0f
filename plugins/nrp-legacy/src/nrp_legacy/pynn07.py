"""Spellings of PyNN 0.7, in which brains of 2014 and 2015 are written, for a simulator of today."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.pynn import former
from nrp_legacy.nest.kernel import Kernel
from nrp_legacy.nest.models import recovering
from nrp_legacy.nest.native import native_cell, native_synapse
from nrp_legacy.nest.projections import synapse_model_of
from nrp_legacy.pynn07_methods import add_methods_to_cells, let_label_follow, with_methods_for_weights


def add_spellings(sim: ModuleType, kernel: Kernel) -> None:
    """Extend a simulator by connectors with weights and delays, ``target`` and ``synapse_dynamics``.

    Args:
        sim: the simulator.
        kernel: the models that a script copies in NEST beside it.
    """
    names = vars(sim)
    for kind in ("Population", "PopulationView", "Assembly"):
        add_methods_to_cells(names[kind])
    let_label_follow(names["Population"])
    names.update(
        SynapseDynamics=former.SynapseDynamics,
        TsodyksMarkramMechanism=former.TsodyksMarkramMechanism,
        Projection=_projection(sim, with_methods_for_weights(names["Projection"])),
        TsodyksMarkramSynapse=_recovering(names["TsodyksMarkramSynapse"]),
        native_cell_type=lambda name: native_cell(sim, name, kernel),
        native_synapse_type=lambda name: native_synapse(sim, name, kernel),
        STDPMechanism=former.mechanism(names["STDPMechanism"]),
        AdditiveWeightDependence=former.dependence(names["AdditiveWeightDependence"]),
        MultiplicativeWeightDependence=former.dependence(names["MultiplicativeWeightDependence"]),
        RandomDistribution=former.distribution(names["RandomDistribution"]),
        initialize=lambda cells, *old, **values: cells.initialize(*old, **values),
        **{name: former.connector(names[name]) for name in former.CONNECTORS},
    )
    vars(names["random"])["RandomDistribution"] = names["RandomDistribution"]


def _recovering(today: type) -> type:
    class TsodyksMarkramSynapse(today):  # type: ignore[misc]
        def __init__(self, *values: Any, tau_rec: Any = 100.0, **more: Any) -> None:
            numbers = isinstance(tau_rec, (int, float, list, np.ndarray))
            super().__init__(*values, tau_rec=recovering(tau_rec) if numbers else tau_rec, **more)

    return TsodyksMarkramSynapse


def _projection(sim: ModuleType, today: type) -> type:
    class Projection(former.projection(today, vars(sim))):  # type: ignore[misc]
        def __init__(
            self, presynaptic_population: Any, postsynaptic_population: Any, connector: Any = None,
            *values: Any, method: Any = None, **more: Any,
        ) -> None:  # fmt: skip
            connector = method if connector is None else connector
            _complete(connector)
            super().__init__(presynaptic_population, postsynaptic_population, connector, *values, **more)

        def _meant(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
            """Return the sizes of negative weights of conductances that inhibit, as NEST takes them."""
            meant: Mapping[str, FloatArray] = super()._meant(values)
            inhibits = self.receptor_type == "inhibitory" and self.post.conductance_based
            return {**meant, "weight": abs(meant["weight"])} if inhibits and "weight" in meant else meant

        @property
        def nest_synapse_model(self) -> str:
            return synapse_model_of(self, sim)

    Projection.__name__ = Projection.__qualname__ = today.__name__
    return Projection


def _complete(connector: Any) -> None:
    """Give a connector of a user, which may not call the constructor of its base, the attributes of it."""
    for name, value in (("safe", True), ("callback", None), ("parameter_names", ())):
        if connector is not None and not hasattr(connector, name):
            setattr(connector, name, value)
