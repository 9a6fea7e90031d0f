"""A network on a real machine, as data."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_brain_spinnaker.mapping.partition import Core


@dataclass(frozen=True, slots=True)
class VertexMap:
    """One population, or a delay extension, on the machine.

    Args:
        label, cell_type, size: as in the network.
        cores: its cores.
        sdram_bytes: SDRAM of each core, estimated.
        packets_per_s: packets sent by all its cores, 1/s.
        left_shifts: excitatory and inhibitory left shift; empty for sources.
        delay_slots: slots available on a core and used; empty for sources.
        dtcm_bytes: DTCM of each core, 0 for sources.
        utilisation: used fraction of a time step on the fullest core, estimated; 0 for sources.
        spikes_per_step: spikes that reach the fullest core at the assumed rates; 0 for sources.
        longest_row: largest number of synapses from one neuron into one core.
        synapse_cores: synapse-only cores of each slice.
    """

    label: str
    cell_type: str
    size: int
    cores: tuple[Core, ...]
    sdram_bytes: int
    packets_per_s: float
    left_shifts: tuple[int, ...] = ()
    delay_slots: tuple[int, ...] = ()
    dtcm_bytes: int = 0
    utilisation: float = 0.0
    spikes_per_step: float = 0.0
    longest_row: int = 0
    synapse_cores: int = 0

    @property
    def late(self) -> float:
        """Share of the fullest core's work in a step that would be late."""
        return max(0.0, 1.0 - 1.0 / self.utilisation) if self.utilisation else 0.0


@dataclass(frozen=True, slots=True)
class MachineMap:
    """A network on the machine.

    Args:
        vertices: populations in definition order, then delay extensions.
        chips, boards: numbers of used ones.
        application_cores, system_cores: numbers of used ones.
        router_entries: routing entries of the fullest chip, one for each sender that reaches it.
        packets_per_s: packets of the whole network, 1/s.
        power_w: estimated power, W.
        slowdown: factor relative to real time at which no core is late.
        advice: advice on parts that would not fit or be late.
    """

    vertices: tuple[VertexMap, ...]
    chips: int
    boards: int
    application_cores: int
    system_cores: int
    router_entries: int
    packets_per_s: float
    power_w: float
    slowdown: int
    advice: tuple[str, ...]

    @property
    def joules_per_simulated_s(self) -> float:
        """Energy of one simulated second, estimated."""
        return self.power_w * self.slowdown
