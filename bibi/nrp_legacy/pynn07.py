"""Spellings of PyNN 0.7, in which brains of 2014 and 2015 are written, for a simulator of today."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from nrp_legacy.nest.native import native_cell

_CONNECTORS = (
    "AllToAllConnector",
    "FixedNumberPostConnector",
    "FixedNumberPreConnector",
    "FixedProbabilityConnector",
    "OneToOneConnector",
)
_AT_ONCE_MS = 1e-3
"""What a time constant of 0 means: synapses that recover at once."""


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
    """What makes a synapse change; of the two only ``fast`` was used by the platform."""

    fast: TsodyksMarkramMechanism | None = None
    slow: Any = None


def add_spellings(sim: ModuleType) -> None:
    """Let a simulator take connectors with weights and delays, ``target`` and ``synapse_dynamics`` too."""
    names = vars(sim)
    names.update(
        SynapseDynamics=SynapseDynamics,
        TsodyksMarkramMechanism=TsodyksMarkramMechanism,
        Projection=_projection(sim, names["Projection"]),
        TsodyksMarkramSynapse=_recovering(names["TsodyksMarkramSynapse"]),
        native_cell_type=lambda name: native_cell(sim, name),
        **{name: _connector(names[name]) for name in _CONNECTORS},
    )


def _recovering(today: type) -> type:
    class TsodyksMarkramSynapse(today):  # type: ignore[misc]
        def __init__(self, *values: Any, tau_rec: Any = 100.0, **more: Any) -> None:
            at_once = isinstance(tau_rec, (int, float)) and tau_rec <= 0
            super().__init__(*values, tau_rec=_AT_ONCE_MS if at_once else tau_rec, **more)

    return TsodyksMarkramSynapse


def _connector(today: type) -> type:
    class Connector(today):  # type: ignore[misc]
        def __init__(self, *values: Any, weights: Any = None, delays: Any = None, **more: Any) -> None:
            super().__init__(*values, **more)
            self.of_synapses = {
                name: value for name, value in (("weight", weights), ("delay", delays)) if value is not None
            }

    Connector.__name__ = Connector.__qualname__ = today.__name__
    return Connector


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
            **more: Any,
        ) -> None:
            connector = method if connector is None else connector
            given = getattr(connector, "of_synapses", {})
            if synapse_type is None and (given or synapse_dynamics is not None):
                synapse_type = _synapse(sim, given, synapse_dynamics)
            if target is not None:
                more["receptor_type"] = target
            super().__init__(
                presynaptic_population, postsynaptic_population, connector, synapse_type, *values, **more
            )

    Projection.__name__ = Projection.__qualname__ = today.__name__
    return Projection


def _synapse(sim: Any, given: dict[str, Any], dynamics: SynapseDynamics | None) -> Any:
    if dynamics is None or dynamics.fast is None:
        return sim.StaticSynapse(**given)
    fast = dynamics.fast
    return sim.TsodyksMarkramSynapse(U=fast.U, tau_rec=fast.tau_rec, tau_facil=fast.tau_facil, **given)
