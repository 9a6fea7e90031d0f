"""A network on a real machine, as data and as text."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from nrp_brain_spinnaker.partition import Core


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
        advice: what would not fit or not keep up, and what to do about it.
    """

    vertices: tuple[VertexMap, ...]
    chips: int
    boards: int
    application_cores: int
    system_cores: int
    router_entries: int
    packets_per_s: float
    power_w: float
    advice: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, for JSON."""
        return asdict(self)

    def as_text(self) -> str:
        """Return a table and the advice."""
        lines = [
            f"{self.application_cores} cores on {self.chips} chips of {self.boards} boards, "
            f"{self.packets_per_s:.3g} packets/s, about {self.power_w:.1f} W",
            f"{'population':24s} {'cells':>7s} {'cores':>6s} {'shifts':>8s} {'SDRAM':>9s} {'load':>6s}",
        ]
        for vertex in self.vertices:
            shifts = ", ".join(map(str, vertex.left_shifts)) or "-"
            load_text = f"{vertex.utilisation:.0%}" if vertex.left_shifts else "-"
            lines.append(
                f"{vertex.label[:24]:24s} {vertex.size:7d} {len(vertex.cores):6d} {shifts:>8s} "
                f"{vertex.sdram_bytes / 1024:6.0f} KB {load_text:>6s}"
            )
        return "\n".join([*lines, *self.advice])
