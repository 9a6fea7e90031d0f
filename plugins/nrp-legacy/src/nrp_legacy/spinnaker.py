"""Extensions of PyNN for SpiNNaker in brain files: settings of the machine, live devices."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_legacy.shims.modules import module

EXTERNAL_DEVICES = (
    "spynnaker_external_devices_plugin.pyNN", "spynnaker8.external_devices",
    "spynnaker.pyNN.external_devices", "pyNN.spiNNaker.external_devices",
)  # fmt: skip
"""Modules of the devices."""
_SETTINGS = ("set_number_of_neurons_per_core", "add_machine_constraint", "set_allow_delay_extensions")


def external_devices(sim: ModuleType) -> ModuleType:
    """Return the live devices for spikes to and from the machine, which the experiment replaces."""

    class LiveSpikesConnection:
        def __init__(self, *_values: Any, **_options: Any) -> None:
            """Connect nothing."""

        def _nothing(self, *_values: Any, **_options: Any) -> None:
            """Do nothing."""

        add_receive_callback = add_start_callback = add_start_resume_callback = add_init_callback = _nothing
        send_spike = send_spikes = add_pause_stop_callback = start = join = close = _nothing

    return module(
        "external_devices",
        activate_live_output_for=_set_nothing, activate_live_output_to=_set_nothing,
        SpikeInjector=lambda *_values, **_options: sim.SpikeSourceArray(spike_times=[]),
        SpynnakerLiveSpikesConnection=LiveSpikesConnection,
        SpynnakerPoissonControlConnection=LiveSpikesConnection,
    )  # fmt: skip


def add_spinnaker(sim: ModuleType) -> None:
    """Add the functions of simulators for SpiNNaker to a simulator."""
    vars(sim).update(dict.fromkeys(_SETTINGS, _set_nothing), external_devices=external_devices(sim))


def _set_nothing(*_values: Any, **_options: Any) -> None:
    """Do nothing, because there is no machine."""
