"""The names of sPyNNaker 7.4.1 that are refused, each with its reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NoReturn

from nrp_core.errors import CapabilityError, did_you_mean

_CALCIUM, _STOCHASTIC = "a threshold that adapts with calcium", "a random threshold"
_POOLED: Final = (
    "how the machine numbers its weights is not known; FromListConnector takes synapses one by one"
)
_RULE: Final = (
    "the rules here are SpikePairRule, SpikeNearestPairRule, Vogels2011Rule and PfisterSpikeTriplet"
)
_CHANGES: Final = "Projection.set(weight=...) changes weights while a network runs"
_DEVICE: Final = "it is a device of its own, connected to a real machine; an experiment has robots"
_SPLITS: Final = "it divides a population on a real machine; neurons_per_core and n_synapse_cores do so here"

CELLS: Final = {
    "IFCurrExpCa2Adaptive": f"it has {_CALCIUM}; EIF_cond_exp_isfa_ista adapts too",
    "IFCurrDeltaCa2Adaptive": f"it has {_CALCIUM}; EIF_cond_exp_isfa_ista adapts too",
    "IFCondExpStoc": f"it has {_STOCHASTIC}",
    "StocExp": f"it has {_STOCHASTIC}",
    "StocExpStable": f"it has {_STOCHASTIC}",
    "StocSigma": f"it has {_STOCHASTIC}",
    "IFCurrDeltaFixedProb": f"it has {_STOCHASTIC}",
    "IFTruncDelta": "its voltage is cut off at rest",
    "IFCondExpCerebellum": "its reversal potentials are set by a cerebellum model of the iCub",
    "IF_cond_exp_stoc": f"it has {_STOCHASTIC}",
    "IF_curr_exp_ca2_adaptive": f"it has {_CALCIUM}; EIF_cond_exp_isfa_ista adapts too",
}
_MACHINE: Final = "there is no machine; `nrp map` shows the one that a network needs"
SIMULATOR: Final = {
    "PoolDenseConnector": _POOLED,
    "PoolDense": _POOLED,
    **dict.fromkeys(("get_machine", "get_spynnaker", "globals_variables"), _MACHINE),
}
EXTRA_MODELS: Final = {
    **CELLS,
    **dict.fromkeys(
        (
            "RecurrentRule", "TimingDependencePFPC", "WeightDependencePFPC", "TimingDependenceMFVN",
            "WeightDependenceMFVN",
        ),
        _RULE,
    ),
    "WeightChangeable": _CHANGES,
    "WeightChanger": _CHANGES,
}  # fmt: skip
_PUSHBOT: Final = (
    "EthernetLEDDevice", "EthernetLaserDevice", "EthernetMotorDevice", "EthernetRetinaDevice",
    "EthernetSpeakerDevice", "LED", "Laser", "LifEthernet", "LifSpinnakerLink", "Motor", "RetinaResolution",
    "RetinaViewer", "Speaker", "SpiNNakerLinkLEDDevice", "SpiNNakerLinkLaserDevice",
    "SpiNNakerLinkMotorDevice", "SpiNNakerLinkRetinaDevice", "SpiNNakerLinkSpeakerDevice",
)  # fmt: skip
DEVICES: Final = dict.fromkeys(
    (
        "ArbitraryFPGADevice", "ExternalDeviceLifControl", "ExternalFPGARetinaDevice", "ICUBRetinaDevice",
        "MunichIoEthernetProtocol", "MunichIoSpiNNakerLinkProtocol", "MunichMotorDevice",
        "MunichRetinaDevice", "MUNICH_MODES", *(f"PushBot{part}" for part in _PUSHBOT), "RetinaKey",
        "RetinaPayload", "SPIFInputDevice", "SPIFLiveSpikesConnection", "SPIFOutputDevice",
        "SPIFRetinaDevice", "EthernetCommandConnection", "EthernetControlConnection",
        "activate_live_output_to",
    ),
    _DEVICE,
)  # fmt: skip
PROTOCOLS: Final = (
    "MUNICH_MODES", "MunichIoEthernetProtocol", "MunichIoSpiNNakerLinkProtocol", "RetinaKey", "RetinaPayload",
)  # fmt: skip
SPLITTERS: Final = dict.fromkeys(
    (
        "AbstractSpynnakerSplitterDelay", "AbstractSupportsOneToOneSDRAMInput", "spynnaker_splitter_selector",
    ),
    _SPLITS,
)  # fmt: skip
POPULATIONS: Final = {
    **dict.fromkeys(("_vertex", "_get_vertex", "_spinnaker_control", "_mapped_vertices"), _MACHINE),
    "set_state": "initialize() sets the state at the beginning of a run",
    "current_values": "record() and get_data() give the state at any time",
}
_PACKETS: Final = "a connection of this process has no socket; an injector with a port has one"
CONNECTIONS: Final = {
    **dict.fromkeys(
        ("send_event", "send_event_with_payload", "send_events", "send_events_with_payloads"),
        "keys belong to a real machine; send_spike and set_rate take a label and cells",
    ),
    "add_database_callback": "there is no database of keys in this process; callbacks name labels and cells",
    **dict.fromkeys(
        (
            "get_receive_method", "is_connected", "is_ready_to_receive", "receive",
            "receive_with_address", "remote_ip_address", "remote_port", "send",
            "send_eieio_message", "send_to",
        ),
        _PACKETS,
    ),
}  # fmt: skip


class UnknownNameError(CapabilityError, AttributeError):
    """A name that sPyNNaker 7.4.1 does not have, or that has no equivalent."""


def unknown_name(owner: str, names: Mapping[str, Any]) -> Callable[[str], NoReturn]:
    """Return the ``__getattr__`` of a module with these names."""

    def attribute(name: str) -> NoReturn:
        if name.startswith("__"):
            raise AttributeError(name)
        raise UnknownNameError(
            f"{owner} has no '{name}'{did_you_mean(name, names)}; cells and rules of other versions, or "
            "compiled for a machine, are not emulated"
        )

    return attribute


class _Refused(type):
    """The type of stand-ins; their constants and methods are refused like them."""

    def __getattr__(cls, name: str) -> NoReturn:
        if not name.startswith("_"):
            raise UnknownNameError(vars(cls)["refusal"])
        raise AttributeError(f"{cls.__name__} has no '{name}'")


def refused(name: str, reason: str) -> type:
    """Return a stand-in for a name without an equivalent; it raises when it is called."""
    refusal = f"{name} is not supported: {reason}"

    def refuse(*_: object, **__: object) -> NoReturn:
        raise CapabilityError(refusal)

    body = {"__init__": refuse, "__doc__": f"Not supported: {reason}.", "refusal": refusal}
    return _Refused(name, (), body)


def refuse_attribute(owner: type, name: str, reasons: dict[str, str]) -> NoReturn:
    """Refuse an attribute of objects of a class.

    Raises:
        CapabilityError: sPyNNaker has it.
        AttributeError: it does not.
    """
    if name in reasons:
        raise CapabilityError(f"{owner.__name__}.{name} is not supported: {reasons[name]}")
    hint = did_you_mean(name, [one for one in dir(owner) if not one.startswith("_")])
    raise AttributeError(f"{owner.__name__} has no '{name}'{hint if hint.instead else ''}")


def stand_ins(reasons: dict[str, str]) -> dict[str, Any]:
    """Return a stand-in for each name."""
    return {name: refused(name, reason) for name, reason in reasons.items()}
