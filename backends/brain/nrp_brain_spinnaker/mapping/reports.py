"""Reports on the machine map and on the losses of a network."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.loader import lay_out
from nrp_brain_spinnaker.mapping.fidelity import Fidelity, weigh
from nrp_brain_spinnaker.mapping.plan import MachineMap, map_network
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.capabilities import Fact, Quantity, Report, Table, Value
from nrp_core.network.data import Network

_KIB = 1024

_VERTEX = (
    Quantity("population", "population"),
    Quantity("cell_type", "cells"),
    Quantity("size", "size"),
    Quantity("cores", "cores"),
    Quantity(
        "synapse_cores",
        "for synapses",
        meaning="synapse-only cores for each core with neurons",
        is_detail=True,
    ),
    Quantity("left_shift_excitatory", "shift exc.", meaning="left shift of the ring buffers"),
    Quantity("left_shift_inhibitory", "inh.", meaning="left shift of the ring buffers"),
    Quantity("delay_slots", "delay slots", meaning="delay slots available on a core", is_detail=True),
    Quantity("delay_slots_used", "used", meaning="delay slots used", is_detail=True),
    Quantity("sdram_kib", "SDRAM", ".0f", "KiB", "per core, estimated"),
    Quantity("dtcm_kib", "DTCM", ".0f", "KiB", "per core, estimated", is_detail=True),
    Quantity(
        "longest_row",
        "row",
        meaning="largest number of synapses from one neuron onto one core",
        is_detail=True,
    ),
    Quantity(
        "packets_per_s", "packets/s", ",.0f", meaning="packets sent at the assumed rates", is_detail=True
    ),
    Quantity(
        "spikes_per_step",
        "spikes in",
        ".1f",
        meaning="spikes that reach the fullest core in a time step",
        is_detail=True,
    ),
    Quantity(
        "utilisation", "load", ".0%", meaning="fraction of a time step that the fullest core works, estimated"
    ),
    Quantity("late", "late", ".0%", meaning="fraction of the work that is late, estimated"),
)
_CORE = (
    Quantity("chip", "chip"), Quantity("core", "core"), Quantity("population", "population"),
    Quantity("first", "first cell"), Quantity("last", "last cell"), Quantity("has", "has"),
    Quantity("key", "key", "#010x"), Quantity("mask", "mask", "#010x"),
)  # fmt: skip
_PROJECTION = (
    Quantity("projection", "projection"),
    Quantity("synapses", "synapses", ","),
    Quantity("left_shift", "shift"),
    Quantity(
        "quantum", "step", ".3g", meaning="smallest difference between two weights, in the model's units"
    ),
    Quantity(
        "largest_sum",
        "limit",
        ".3g",
        meaning="largest input of a receptor in one time step, in the model's units",
        is_detail=True,
    ),
    Quantity("vanished", "become 0", ",", meaning="weights that are too small and become 0"),
    Quantity("wrapped", "wrap", ",", meaning="weights that are too large and wrap around"),
    Quantity("mean_error", "mean error", ".2%", meaning="relative error of the other weights"),
    Quantity(
        "largest_error", "largest error", ".2%", meaning="relative error of the other weights", is_detail=True
    ),
    Quantity(
        "moved_delays", "moved delays", ",", meaning="delays that are not whole time steps", is_detail=True
    ),
    Quantity("largest_move_ms", "by up to", ".3g", "ms", is_detail=True),
)
_RECEPTOR = (
    Quantity("population", "population"),
    Quantity("receptor", "receptor"),
    Quantity("left_shift", "shift"),
    Quantity("largest_sum", "limit", ".3g", meaning="largest input in one time step", is_detail=True),
    Quantity("mean_sum", "expected", ".3g", meaning="mean input in a time step at the assumed rates"),
    Quantity("deviation", "deviation", ".3g", meaning="standard deviation of the input", is_detail=True),
    Quantity("saturating", "cut off", ".2g", meaning="fraction of time steps in which the limit is exceeded"),
)


def reports_of(network: Network, options: SpinnakerOptions) -> list[Report]:
    """Return reports on the placement of a network on a machine and on its losses there.

    Raises:
        NetworkError: the network does not fit the machine.
    """
    cells, wires, moved = lay_out(network, options)
    seen = weigh(network, wires, options)
    machine = map_network(network, cells, wires, options)
    delays = tuple(one.message for one in moved if one not in seen.losses)
    assumed = f"{options.spikes_per_second:g} Hz for every neuron except Poisson sources"
    return [_map_report(machine, assumed), _fidelity_report(seen, delays, assumed)]


def _map_report(machine: MachineMap, assumed: str) -> Report:
    return Report(
        name="map",
        title="On the SpiNNaker machine",
        facts=tuple(_facts(machine)),
        tables=(
            Table("populations", "Populations", _VERTEX, tuple(_vertex_rows(machine))),
            Table("cores", "Cores", _CORE, tuple(_core_rows(machine)), is_detail=True),
        ),
        advice=machine.advice,
        notes=(
            "Cores, keys, shifts and delay slots are those of sPyNNaker 7.4.1; load, memory and power are "
            f"estimates that assume {assumed}.",
        ),
    )


def _facts(machine: MachineMap) -> Iterator[Fact]:
    yield Fact(Quantity("application_cores", "cores", ","), machine.application_cores)
    yield Fact(Quantity("system_cores", "system cores", ","), machine.system_cores)
    yield Fact(Quantity("chips", "chips", ","), machine.chips)
    yield Fact(Quantity("boards", "boards", ","), machine.boards)
    yield Fact(Quantity("router_entries", "routing entries", ","), machine.router_entries)
    yield Fact(
        Quantity("router_entries_available", "routing entries of a chip", ","), hardware.ROUTER_ENTRIES
    )
    yield Fact(Quantity("packets_per_s", "packets/s", ",.0f"), machine.packets_per_s)
    yield Fact(Quantity("slowdown", "slowdown relative to real time"), machine.slowdown)
    yield Fact(Quantity("power_w", "power", ".1f", "W"), machine.power_w)
    energy = Quantity("joules_per_simulated_s", "energy of a simulated second", ".1f", "J")
    yield Fact(energy, machine.joules_per_simulated_s)


def _vertex_rows(machine: MachineMap) -> Iterator[tuple[Value, ...]]:
    for v in machine.vertices:
        common = (v.label, v.cell_type, v.size, len(v.cores), v.synapse_cores)
        sdram_kib = v.sdram_bytes / _KIB
        if v.left_shifts:
            yield (
                *common, *v.left_shifts, *v.delay_slots, sdram_kib, v.dtcm_bytes / _KIB, v.longest_row,
                v.packets_per_s, v.spikes_per_step, v.utilisation, v.late,
            )  # fmt: skip
        else:  # a source, which receives nothing
            nothing = (None,) * 4
            yield (*common, *nothing, sdram_kib, None, None, v.packets_per_s, None, None, None)


def _core_rows(machine: MachineMap) -> Iterator[tuple[Value, ...]]:
    for vertex in machine.vertices:
        for c in vertex.cores:
            has = "synapses" if c.has_synapses_alone else "cells"
            yield c.chip, c.core, vertex.label, c.first, c.last - 1, has, c.key, c.mask


def _fidelity_report(seen: Fidelity, delays: tuple[str, ...], assumed: str) -> Report:
    projections = (
        (p.label, p.synapses, p.left_shift, p.quantum, p.largest_sum, p.vanished, p.wrapped, p.mean_error,
         p.largest_error, p.moved_delays, p.largest_move_ms)
        for p in seen.projections
    )  # fmt: skip
    receptors = (
        (r.population, r.receptor, r.left_shift, r.largest_sum, r.mean_sum, r.deviation, r.saturating)
        for r in seen.receptors
    )
    return Report(
        name="fidelity",
        title="Precision of the network on the machine",
        tables=(
            Table("projections", "Projections", _PROJECTION, tuple(projections)),
            Table("receptors", "Receptors", _RECEPTOR, tuple(receptors)),
        ),
        warnings=seen.losses,
        advice=(*delays, *seen.advice),
        notes=(f"The expected input of receptors assumes {assumed}.",),
    )
