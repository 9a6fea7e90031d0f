"""A network on a real machine, as data."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_brain_spinnaker.mapping.partition import Core


@dataclass(frozen=True, slots=True)
class VertexMap:
    """One population, or a delay extension, on the machine.

    Args:
        label, cell_type, size: as in the network.
        cores: where it sits.
        sdram_bytes: of each core, estimated.
        packets_per_s: sent by all its cores.
        left_shifts: excitatory and inhibitory; empty for sources.
        delay_slots: available on a core and used; empty for sources.
        dtcm_bytes: of each core, 0 for sources.
        utilisation: of a time step by the fullest core, estimated; 0 for sources.
        spikes_per_step: that reach the fullest core, with the rates assumed; 0 for sources.
        longest_row: most synapses from one neuron into one core.
        synapse_cores: of each slice, beside the core of its neurons.
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
        """Share of the fullest core's work of a step that would come after its end: late spikes."""
        return max(0.0, 1.0 - 1.0 / self.utilisation) if self.utilisation else 0.0


@dataclass(frozen=True, slots=True)
class MachineMap:
    """A network on the machine.

    Args:
        vertices: populations in definition order, then delay extensions.
        chips, boards: used.
        application_cores, system_cores: used.
        router_entries: of the fullest chip, one for each sender that reaches it.
        packets_per_s: of the whole network.
        power_w: estimated.
        slowdown: how many times slower than real time it has to run so that no core comes late.
        advice: advice on the parts that would not fit or not keep up.
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
