"""Monitors: functions that publish the value of a device, on a topic shared by all monitors of its kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from nrp_core.dsl.calls import ONCE, Call
from nrp_core.dsl.device_kinds import (
    DeviceKind,
    leaky_integrator_alpha,
    leaky_integrator_exp,
    population_rate,
    spike_recorder,
)
from nrp_core.dsl.devices import Device, DeviceGroup, SpikeRecorderDevice
from nrp_core.dsl.functions import Neuron2Robot, TransferFunction
from nrp_core.dsl.mappings import MapSpikeSink
from nrp_core.dsl.parameters import Adapter, Binding, PublishedTopic, Topic
from nrp_core.errors import did_you_mean
from nrp_core.messages.cle_ros_msgs import SpikeData, SpikeEvent, SpikeRate

DEVICE = "device"
_KINDS = {
    kind.name: kind
    for kind in (spike_recorder, leaky_integrator_alpha, leaky_integrator_exp, population_rate)
}


class NeuronMonitor(Neuron2Robot):
    """Marks a function that decides whether its device is shown: it is, unless the function returns None.

    Args:
        neurons: a selector; if it gives a list of selections, each is shown by its own message.
        monitor_type: ``nrp.spike_recorder``, ``nrp.leaky_integrator_alpha``, ``nrp.leaky_integrator_exp`` or
            ``nrp.population_rate``; the topic is ``/monitor/`` and the name of the kind.

    Raises:
        TransferFunctionError: no monitor of this kind exists.
    """

    def __init__(self, neurons: Any, monitor_type: DeviceKind) -> None:
        super().__init__()
        name = str(monitor_type)
        if not isinstance(monitor_type, DeviceKind) or name not in _KINDS:
            raise self.place.error(f"there is no monitor of kind {name:.60}{did_you_mean(name, _KINDS)}")
        settings = {"use_ids": False} if monitor_type is spike_recorder else {}
        self._sink = MapSpikeSink(DEVICE, neurons, monitor_type, **settings)
        self._monitored = Topic(
            f"/monitor/{name}", SpikeEvent if monitor_type is spike_recorder else SpikeRate
        )

    def _make(self, function: Callable[..., Any]) -> TransferFunction:
        return MonitoringFunction(function, self._sink, self._monitored)


class MonitoringFunction(TransferFunction):
    """A transfer function that publishes the state of its own device on a topic.

    Args:
        function: returns whether the device is shown.
        sink: the device.
        monitored: the topic.

    Attributes:
        sink: the device.
    """

    def __init__(self, function: Callable[..., Any], sink: MapSpikeSink, monitored: Topic) -> None:
        super().__init__(function, flow=NeuronMonitor.flow)
        self.sink, self._monitored = sink, monitored

    @property
    def published(self) -> list[Topic]:
        return [*super().published, self._monitored]

    def _connect(self, binding: Binding) -> None:
        if self._monitored.name not in binding.world.topics:
            binding.world.declare(self._monitored.name, self._monitored.topic_type)
        super()._connect(binding)
        device = self.sink.bind(binding)
        self._adapters[DEVICE] = device
        self._refreshed.append(device)
        self._shown_on = PublishedTopic(binding.world, self._monitored)

    def run(self, now_ns: int, t: float | None = None, call: Call = ONCE[0]) -> Any:
        result = super().run(now_ns, t, call)
        if result is not None:
            for message in self._messages(self._adapters[DEVICE], now_ns * 1e-9 if t is None else t):
                self._shown_on.send_message(message)
        return result

    def _messages(self, shown: Adapter, t: float) -> Iterator[SpikeEvent | SpikeRate]:
        devices = shown if isinstance(shown, DeviceGroup) else [shown]
        for device in devices:
            if isinstance(device, SpikeRecorderDevice):
                spikes = [SpikeData(int(neuron), float(time)) for neuron, time in device.times]
                yield SpikeEvent(t, device.neurons_count, spikes, self.name, device.population_name)
            elif isinstance(device, Device):
                value = device.rate if self.sink.kind is population_rate else device.voltage
                yield SpikeRate(t, float(value), self.name)
