"""What monitors publish, under the names that users of the Neurorobotics Platform know."""

from __future__ import annotations

from dataclasses import dataclass, field

from nrp_core.world.messages.base import message


@message("cle_ros_msgs/msg/SpikeData")
@dataclass(slots=True)
class SpikeData:
    """One spike; ``neuron`` counts from 0 within what is monitored, ``time`` is in ms."""

    neuron: int = 0
    time: float = 0.0


@message("cle_ros_msgs/msg/SpikeEvent")
@dataclass(slots=True)
class SpikeEvent:
    """The spikes of a population in one step; ``simulationTime`` is in seconds."""

    simulationTime: float = 0.0
    neuronCount: int = 0
    spikes: list[SpikeData] = field(default_factory=list)
    monitorName: str = ""
    populationLabel: str = ""


@message("cle_ros_msgs/msg/SpikeRate")
@dataclass(slots=True)
class SpikeRate:
    """A rate in Hz, or the voltage of an integrator in mV; ``simulationTime`` is in seconds."""

    simulationTime: float = 0.0
    rate: float = 0.0
    monitorName: str = ""
