"""States of ``hbp_nrp_excontrol.nrp_states`` that wait for what monitors of neurons show."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nrp_core.world.messages.cle_ros_msgs import SpikeEvent, SpikeRate
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import bound
from nrp_legacy.shims.monitor_states import MonitorState

_RATES = {
    "MonitorSpikeRateState": "population_rate",
    "MonitorLeakyIntegratorAlphaState": "leaky_integrator_alpha",
    "MonitorLeakyIntegratorExpState": "leaky_integrator_exp",
}
"""The states for values, and the kinds of monitors that they listen to."""


class ActivityMonitorState(MonitorState):
    """Waits while a condition holds for the messages of one monitor.

    Args:
        topic: the topic of its kind.
        shown: the type of its messages.
        value: the field that the condition gets.
        monitor_name: the name of the monitor, that of its function.
        callback: called with the user data, the time in s, and the value; True: keep waiting.
    """

    def __init__(
        self,
        graph: Graph,
        topic: str,
        shown: type,
        value: str,
        monitor_name: str,
        callback: Callable[[Any, float, Any], bool],
        *_keys: Any,
        **_more: Any,
    ) -> None:
        def holds(userdata: Any, message: Any) -> bool:
            if message.monitor_name != monitor_name:
                return True
            return callback(userdata, message.simulation_time, getattr(message, value))

        super().__init__(graph, topic, shown, holds)


def activity_states(graph: Graph) -> dict[str, type]:
    """Return the states by their names."""
    made = partial(bound, ActivityMonitorState, graph)
    rates = {name: made(f"/monitor/{kind}", SpikeRate, "rate") for name, kind in _RATES.items()}
    return {**rates, "MonitorSpikeRecorderState": made("/monitor/spike_recorder", SpikeEvent, "spikes")}
