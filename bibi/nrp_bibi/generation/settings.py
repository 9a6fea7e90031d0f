"""Keyword arguments of a device, and of the decorator of a function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from nrp_bibi.generation.expressions import literal
from nrp_bibi.model.channels import AnyDevice
from nrp_bibi.model.functions import Bibi, Calls, ChannelTransferFunction
from nrp_bibi.model.synapses import (
    AllToAllConnector,
    FixedNumberPreConnector,
    NeuronConnector,
    OneToOneConnector,
    Reference,
    SynapseDynamics,
    TsodyksMarkramMechanism,
)
from nrp_core.errors import ExperimentError, did_you_mean

N = TypeVar("N", NeuronConnector, SynapseDynamics)
Refuse = Callable[[Any, str], ExperimentError]


def settings(device: AnyDevice, model: Bibi, refuse: Refuse) -> str:
    """Return the keyword arguments of a device, each after a comma.

    Args:
        device: the channel.
        model: the model with the connectors and synapse dynamics that the channel refers to.
        refuse: makes the error for a reference that does not exist.
    """
    connector = _referred(device.connector, device.connector_ref, model.connectors, refuse)
    dynamics = _referred(device.synapse_dynamics, device.synapse_dynamics_ref, model.synapse_dynamics, refuse)
    given = {**_of_connector(connector), **_of_dynamics(dynamics)}
    if device.target is not None:
        given["receptor_type"] = device.target.value.lower()
    return "".join(f", {name}={literal(value)}" for name, value in given.items())


def timing(function: ChannelTransferFunction) -> list[str]:
    """Return the keyword arguments that say when a function runs."""
    given = {
        "triggers": list(function.trigger) or None,
        "throttling_rate": function.throttling_rate,
        "priority": function.priority or None,
        "calls": None if function.calls is Calls.ONCE else "each",
    }
    return [f"{name}={literal(value)}" for name, value in given.items() if value is not None]


def _referred(own: N | None, reference: Reference | None, shared: Sequence[N], refuse: Refuse) -> N | None:
    if own is not None or reference is None:
        return own
    by_name = {one.name: one for one in shared}
    if reference.ref not in by_name:
        hint = did_you_mean(reference.ref, by_name)
        raise refuse(reference, f"the model does not define '{reference.ref}'{hint}")
    return by_name[reference.ref]


def _of_connector(connector: NeuronConnector | None) -> dict[str, Any]:
    if connector is None:
        return {}
    given = {"weight": connector.weights, "delay": connector.delays}
    given = {name: value for name, value in given.items() if value is not None}
    match connector:
        case FixedNumberPreConnector(count=count):
            return {"connector": {"mode": "Fixed", "n": count}, **given}
        case OneToOneConnector() | AllToAllConnector():
            return given  # both connect a device to each of its neurons once
        case _:
            raise TypeError(f"no keyword arguments for {connector!r}")


def _of_dynamics(dynamics: SynapseDynamics | None) -> dict[str, Any]:
    match dynamics:
        case None:
            return {}
        case TsodyksMarkramMechanism(u=u, tau_rec=tau_rec, tau_facil=tau_facil):
            constants = {"U": u, "tau_rec": tau_rec, "tau_facil": tau_facil}
            return {"synapse_type": {"type": "TsodyksMarkram", **constants}}
        case _:
            raise TypeError(f"no keyword arguments for {dynamics!r}")
