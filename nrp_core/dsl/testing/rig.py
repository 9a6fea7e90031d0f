"""A test rig: one transfer function between a mock brain and a mock world.

::

    rig = Rig(linear_twist)
    rig.set(left_wheel_neuron=0.5, right_wheel_neuron=0.4)
    rig.run()
    assert rig.sent("/husky/cmd_vel")[-1].linear.x == 8.0
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.brain.devices.sinks import SpikeRecorderPort
from nrp_core.brain.devices.sources import SourcePort
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import NS_PER_MS, from_seconds, milliseconds
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.functions.monitors import MonitoringFunction
from nrp_core.dsl.functions.variables import Variable
from nrp_core.dsl.parameters.topics import SubscribedTopic
from nrp_core.dsl.selection.selection import GROUP, Groups, Selection
from nrp_core.dsl.selection.selectors import select
from nrp_core.dsl.testing.mocks import MockBrain, MockWorld
from nrp_core.errors import TransferFunctionError, did_you_mean

_POPULATION_SIZE = 1000


class Rig:
    """A transfer function between a mock brain and a mock world with all its populations and topics.

    Args:
        function: the transfer function; it is bound to the mocks.
        brain: by default one with every population that the function names, of 1000 neurons each.
        world: by default one with every topic of the function; the topics must then state their type.
    """

    def __init__(
        self, function: TransferFunction, brain: MockBrain | None = None, world: MockWorld | None = None
    ) -> None:
        self.function = function
        self.brain = MockBrain(_populations_of(function)) if brain is None else brain
        self.world = MockWorld(_topics_of(function)) if world is None else world
        self._t_ns = 0
        function.unbind()
        function.reset()
        function.bind(self.brain, self.world)

    def set(self, **inputs: Any) -> None:
        """Set the inputs of the function.

        Args:
            inputs: by parameter: the message of a topic, the value of a variable, the voltage or
                rate of a device (a list for a device group), the spike times in ms of a recorder.

        Raises:
            TransferFunctionError: the function has no such input.
        """
        for parameter, value in inputs.items():
            self._set(parameter, self.function.adapters.get(parameter), value)

    def _set(self, parameter: str, adapter: object, value: Any) -> None:
        if isinstance(adapter, SubscribedTopic):
            self.world.put(adapter.name, value)
        elif isinstance(adapter, Variable):
            adapter.value = value
        elif isinstance(adapter, Device) and _is_read(adapter):
            _set_input(adapter, value)
        elif isinstance(adapter, DeviceGroup) and all(map(_is_read, adapter)):
            for device, one in zip(adapter, value, strict=True):
                _set_input(device, one)
        else:
            inputs = [name for name in self.function.parameters if name != parameter]
            hint = did_you_mean(parameter, inputs)
            raise TransferFunctionError(f"'{self.function.name}' has no input '{parameter}'{hint}")

    def run(self, t: float | None = None) -> Any:
        """Run the function, even if it is not due, and return its result.

        Args:
            t: the time in seconds; by default 20 ms after the last run.
        """
        self._t_ns = self._t_ns + 20 * NS_PER_MS if t is None else from_seconds(t)
        return self.function.run(self._t_ns)

    def sent(self, topic: str) -> list[Any]:
        """Return every message on a topic, oldest first."""
        return self.world.sent(topic)


class _PortWithValues:
    """A port with values of a test."""

    def __init__(self, port: Any, **values: Any) -> None:
        self._port = port
        vars(self).update(values)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._port, name)


def _is_read(device: Device) -> bool:
    return not isinstance(device.port, SourcePort)


def _set_input(device: Device, value: Any) -> None:
    if isinstance(device.port, SpikeRecorderPort):
        times = np.sort(np.asarray(value, dtype=float))
        device.port.receive(Spikes(np.full(len(times), device.selection.ids[0]), times), milliseconds(0))
    else:
        device.port = _PortWithValues(device.port, **{device.port.quantity: value})


class _AnyBrain:
    """The root of a brain that has every population."""

    def __init__(self) -> None:
        self.sizes: dict[str, int] = {}

    def __getattr__(self, name: str) -> Any:
        return Groups(self._named) if name == GROUP else self._named(name)

    def _named(self, name: str) -> Selection:
        self.sizes[name] = _POPULATION_SIZE
        return Selection(np.arange(_POPULATION_SIZE), name)


def _populations_of(function: TransferFunction) -> dict[str, int]:
    root = _AnyBrain()
    shown = [function.sink] if isinstance(function, MonitoringFunction) else []
    for mapping in (*function.mappings.values(), *shown):
        if isinstance(mapping, (MapSpikeSink, MapSpikeSource)):
            select(mapping.selector, root)
    return root.sizes


def _topics_of(function: TransferFunction) -> dict[str, type]:
    topics = [*function.subscribed, *function.published]
    return {topic.name: topic.topic_type for topic in topics if topic.topic_type is not None}
