"""Spellings of PyNN 0.7, in which brains of 2014 and 2015 are written, for a simulator of today."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_legacy.nest.kernel import Kernel
from nrp_legacy.nest.models import recovering
from nrp_legacy.nest.native import native_cell, native_synapse
from nrp_legacy.nest.projections import synapse_model_of
from nrp_legacy.pynn07_methods import add_methods_to_cells, let_label_follow, with_methods_for_weights

_CONNECTORS = (
    "AllToAllConnector",
    "DistanceDependentProbabilityConnector",
    "FixedTotalNumberConnector",
    "SmallWorldConnector",
    "FixedNumberPostConnector",
    "FixedNumberPreConnector",
    "FixedProbabilityConnector",
    "OneToOneConnector",
)


@dataclass(frozen=True, slots=True)
class TsodyksMarkramMechanism:
    """Short-term plasticity, without weight and delay, which belonged to the connector."""

    U: float = 0.5
    tau_rec: float = 100.0
    tau_facil: float = 0.0
    u0: float = 0.0
    x0: float = 1.0
    y0: float = 0.0


@dataclass(frozen=True, slots=True)
class SynapseDynamics:
    """The dynamics of a synapse; if both are given, the slow one is used."""

    fast: TsodyksMarkramMechanism | None = None
    slow: Any = None


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
        SynapseDynamics=SynapseDynamics,
        TsodyksMarkramMechanism=TsodyksMarkramMechanism,
        Projection=_projection(sim, with_methods_for_weights(names["Projection"])),
        TsodyksMarkramSynapse=_recovering(names["TsodyksMarkramSynapse"]),
        native_cell_type=lambda name: native_cell(sim, name, kernel),
        native_synapse_type=lambda name: native_synapse(sim, name, kernel),
        STDPMechanism=_mechanism(names["STDPMechanism"]),
        AdditiveWeightDependence=_dependence(names["AdditiveWeightDependence"]),
        MultiplicativeWeightDependence=_dependence(names["MultiplicativeWeightDependence"]),
        RandomDistribution=_distribution(names["RandomDistribution"]),
        initialize=lambda cells, *old, **values: cells.initialize(*old, **values),
        **{name: _connector(names[name]) for name in _CONNECTORS},
    )
    vars(names["random"])["RandomDistribution"] = names["RandomDistribution"]


def _distribution(today: type) -> type:
    """Return distributions whose limits may come in any order, as NumPy takes them."""

    class RandomDistribution(today):  # type: ignore[misc]
        def __init__(self, distribution: str, parameters_pos: Any = None, rng: Any = None, **named: Any):
            if distribution == "uniform":
                if parameters_pos is not None and len(parameters_pos) == len(_LIMITS):
                    parameters_pos = sorted(parameters_pos)
                if named.keys() >= set(_LIMITS):
                    named |= zip(_LIMITS, sorted(named[limit] for limit in _LIMITS), strict=True)
            super().__init__(distribution, parameters_pos, rng, **named)

    return RandomDistribution


_LIMITS = ("low", "high")


def _recovering(today: type) -> type:
    class TsodyksMarkramSynapse(today):  # type: ignore[misc]
        def __init__(self, *values: Any, tau_rec: Any = 100.0, **more: Any) -> None:
            numbers = isinstance(tau_rec, (int, float, list, np.ndarray))
            super().__init__(*values, tau_rec=recovering(tau_rec) if numbers else tau_rec, **more)

    return TsodyksMarkramSynapse


def _mechanism(today: type) -> type:
    class STDPMechanism(today):  # type: ignore[misc]
        def __init__(
            self, timing_dependence: Any = None, weight_dependence: Any = None, *values: Any, **more: Any
        ) -> None:
            amplitudes = getattr(weight_dependence, "of_timing", {})
            for name, value in amplitudes.items():
                timing_dependence.parameter_space[name] = value
            self.of_mechanism = {
                "timing_dependence": timing_dependence, "weight_dependence": weight_dependence, **more
            }  # fmt: skip
            super().__init__(timing_dependence, weight_dependence, *values, **more)

    return STDPMechanism


def _dependence(today: type) -> type:
    """Return a weight dependence with the amplitudes, which now belong to the timing."""

    class Dependence(today):  # type: ignore[misc]
        def __init__(self, *values: Any, A_plus: Any = None, A_minus: Any = None, **more: Any) -> None:  # noqa: N803
            given = {"A_plus": A_plus, "A_minus": A_minus}
            self.of_timing = {name: value for name, value in given.items() if value is not None}
            super().__init__(*values, **more)

    Dependence.__name__ = Dependence.__qualname__ = today.__name__
    return Dependence


def _connector(today: type) -> type:
    class Connector(today):  # type: ignore[misc]
        def __init__(self, *values: Any, weights: Any = None, delays: Any = None, **more: Any) -> None:
            super().__init__(*values, **more)
            given = (("weight", weights), ("delay", delays))
            self.of_synapses = {name: _of_distance(value) for name, value in given if value is not None}

    Connector.__name__ = Connector.__qualname__ = today.__name__
    return Connector


def _of_distance(value: Any) -> Any:
    """Return a weight or delay; an expression of the distance ``d`` becomes a function with NumPy's names."""
    return eval(f"lambda d: {value}", dict(vars(np))) if isinstance(value, str) else value


def _projection(sim: ModuleType, today: type) -> type:
    class Projection(today):  # type: ignore[misc]
        def __init__(
            self,
            presynaptic_population: Any,
            postsynaptic_population: Any,
            connector: Any = None,
            synapse_type: Any = None,
            *values: Any,
            method: Any = None,
            target: str | None = None,
            synapse_dynamics: SynapseDynamics | None = None,
            rng: Any = None,
            **more: Any,
        ) -> None:
            connector = method if connector is None else connector
            if rng is not None and hasattr(connector, "rng"):
                connector.rng = rng
            _complete(connector)
            given = getattr(connector, "of_synapses", {})
            if synapse_type is None and (given or synapse_dynamics is not None):
                synapse_type = _synapse(sim, given, synapse_dynamics)
            if target is not None:
                more["receptor_type"] = target
            super().__init__(
                presynaptic_population, postsynaptic_population, connector, synapse_type, *values, **more
            )

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


def _synapse(sim: Any, given: dict[str, Any], dynamics: SynapseDynamics | None) -> Any:
    if dynamics is not None and dynamics.slow is not None:
        return sim.STDPMechanism(**{**dynamics.slow.of_mechanism, **given})
    if dynamics is None or dynamics.fast is None:
        return sim.StaticSynapse(**given)
    fast = dynamics.fast
    return sim.TsodyksMarkramSynapse(U=fast.U, tau_rec=fast.tau_rec, tau_facil=fast.tau_facil, **given)
