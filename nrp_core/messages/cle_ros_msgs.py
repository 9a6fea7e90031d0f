"""Messages of monitors, by their names on the Neurorobotics Platform.

ROS 2 has field names in lower case only. The names in the platform's experiments, such as ``simulationTime``,
read and set the same fields.
"""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import alias, message


@message("cle_ros_msgs/msg/SpikeData")
class SpikeData:
    """One spike; ``neuron`` is the index in the monitored population, ``time`` is in ms."""

    neuron: int = 0
    time: float = 0.0


@message("cle_ros_msgs/msg/SpikeEvent")
class SpikeEvent:
    """The spikes of a population in one step; ``simulation_time`` is in seconds."""

    simulation_time: float = 0.0
    neuron_count: int = 0
    spikes: list[SpikeData] = field(default_factory=list)
    monitor_name: str = ""
    population_label: str = ""

    simulationTime = alias("simulation_time")
    neuronCount = alias("neuron_count")
    monitorName = alias("monitor_name")
    populationLabel = alias("population_label")


@message("cle_ros_msgs/msg/SpikeRate")
class SpikeRate:
    """A rate in Hz, or the voltage of an integrator in mV; ``simulation_time`` is in seconds."""

    simulation_time: float = 0.0
    rate: float = 0.0
    monitor_name: str = ""

    simulationTime = alias("simulation_time")
    monitorName = alias("monitor_name")
