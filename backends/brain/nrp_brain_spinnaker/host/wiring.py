"""Projections on the machine: raw weights, delays in ticks, and the shift of their receptor.

Delays in ticks, and the limits of the machine's slots and delay extensions.

Convert projections to synapses ordered by source neuron.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.weights import (
    Expectation,
    Incoming,
    host_raw,
    incoming_of,
    is_machine_generated,
    largest_input,
    left_shift,
    machine_raw,
    parse_distribution,
    sizes_of,
    weight_factors,
    weight_scale,
)
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.synaptic_inputs import Rows, WeightArray
from nrp_brain_spinnaker.models import CellModel, cell_models
from nrp_brain_spinnaker.options import SpinnakerOptions, hints_of
from nrp_core._support.arrays import FloatArray, IndexArray, IntArray
from nrp_core.errors import NetworkError
from nrp_core.findings import Code, Findings
from nrp_core.network.data import RECEPTORS, Network, Population, Projection
from nrp_core.network.limits import check_synapses, distinct

RING_BITS = 14
"""Bits of the index into a core's ring buffer: 16384 entries of 16 bits."""
MOST_STAGES = 8
"""Stages of a delay extension, each as long as the ring."""
N_RECEPTORS = 2


def bits_for(n: int) -> int:
    """Return the number of bits of an index over ``n`` items, at least 1."""
    return max(1, (n - 1).bit_length())


def slots_available(neurons_on_core: int) -> int:
    """Return the maximum delay in the ring buffer of a core, in ticks."""
    return 1 << (RING_BITS - bits_for(neurons_on_core) - bits_for(N_RECEPTORS))


def slots_used(neurons_on_core: int, longest: int) -> int:
    """Return the number of slots for a longest delay in ticks, 0 without any synapse."""
    if not longest:
        return 1
    return min(slots_available(neurons_on_core), 1 << bits_for(longest))


def longest_delay(neurons_on_core: int) -> int:
    """Return the longest delay in ticks with all stages of a delay extension."""
    return slots_available(neurons_on_core) * (MOST_STAGES + 1)


def stages(neurons_on_core: int, longest: int) -> int:
    """Return the number of stages of the delay extension for a longest delay in ticks."""
    return -(-longest // slots_available(neurons_on_core)) - 1


def to_ticks(delays_ms: FloatArray, step_us: int, *, drawn_on_machine: bool) -> IntArray:
    """Convert delays to ticks, possibly 0: to the nearest, or truncated if a core draws them."""
    ticks = delays_ms * 1000 / step_us
    return (np.floor(ticks) if drawn_on_machine else np.rint(ticks)).astype(np.int64)


@dataclass
class Wires:
    """The synapses of one projection.

    Args:
        projection: the projection; only one whose synapses form and vanish may have none.
        model: cell type of the target.
        population: index of the target among the simulated populations.
        pre_first, n_pre: the first global id and the size of the source population.
        post_first, post_last: the neurons of the target population.
        factor: factor of weights for each cell of the target, or None for 1.
        ticks: delays, shape ``(n_synapses,)``, or ``(1,)`` if all are equal.
        incoming: their properties for the choice of the shift.
        on_machine: whether the machine would expand the connector itself.
        step_us: length of a tick, us.
        shift: the left shift of their receptor.
    """

    projection: Projection
    model: CellModel
    population: int
    pre_first: int
    n_pre: int
    post_first: int
    post_last: int
    factor: FloatArray | None
    ticks: IntArray
    incoming: Incoming
    on_machine: bool
    step_us: int
    shift: int = 0

    @property
    def receptor(self) -> int:
        """0 excitatory, 1 inhibitory."""
        return RECEPTORS.index(self.projection.receptor)

    @property
    def new_ticks(self) -> tuple[int, int]:
        """The shortest and longest delay of synapses that form, 1 if none do."""
        rewiring = self.projection.rewiring
        if rewiring is None:
            return 1, 1
        low, high = (
            int(delay_ms * (1000 / self.step_us))
            for delay_ms in (rewiring.initial_delay_low, rewiring.initial_delay_high)
        )
        return low, high

    @property
    def sizes(self) -> FloatArray:
        """Absolute weights in the units of the target's synapses, shape ``(1,)`` if all are equal."""
        return distinct(sizes_of(self.projection, self.factor))

    @property
    def scale(self) -> float:
        """Raw units per unit of weight."""
        return weight_scale(self.shift, self.model.weight_scale)

    @property
    def raw(self) -> WeightArray:
        """Raw weights with the shift; equal ones are broadcast."""
        return np.broadcast_to(self.converted(self.sizes), self.projection.weight.shape)

    def converted(self, sizes: FloatArray) -> WeightArray:
        """Convert absolute weights in the units of the target's synapses.

        Raises:
            NetworkError: one does not fit the machine's arithmetic.
        """
        convert = machine_raw if self.on_machine else host_raw
        try:
            return convert(sizes, self.shift, self.model.weight_scale)
        except ValueError as error:
            raise NetworkError(f"projection '{self.projection.label}': {error}") from None


def wire(
    network: Network, labels: Sequence[str], cells: Cells, options: SpinnakerOptions
) -> tuple[list[Wires], Findings]:
    """Convert all projections that transmit spikes and choose the shifts; also return warnings.

    Args:
        network: the network.
        labels: the simulated populations in the order of ``cells``.
        cells: their neurons.
        options: the options of the user.

    Raises:
        NetworkError: a weight has the wrong sign or a delay is too long.
    """
    projections = [one for one in sending(network) if one.neuromodulation is None]
    wires = [_wire(network, p, labels.index(p.post), cells, options) for p in projections]
    groups = defaultdict(list)
    for part in wires:
        groups[part.population, part.receptor].append(part)
    for fellows in groups.values():
        shift = _shift(network.populations[fellows[0].projection.post], fellows, options)
        for part in fellows:
            part.shift = shift
    return wires, _lengthen(wires, options)


def sending(network: Network) -> list[Projection]:
    """Return the projections that have synapses, or may have."""
    return [one for one in network.projections if one.size or one.rewiring is not None]


def longest_ticks(wires: Sequence[Wires]) -> int:
    """Return the longest delay in ticks, at least 1."""
    return max((max(int(part.ticks.max()), *part.new_ticks) for part in wires), default=1)


def _wire(
    network: Network, projection: Projection, population: int, cells: Cells, options: SpinnakerOptions
) -> Wires:
    target = network.populations[projection.post]
    options = hints_of(target, options).options
    model = cell_models(options.semantics)[target.cell_type]
    check_synapses(
        f"projection '{projection.label}'", projection.ends, {"weight": projection.weight},
        receptor=projection.receptor, conductance_based=target.is_conductance_based, signed=True,
    )  # fmt: skip
    own = cells.neurons(population)
    factor = weight_factors(cells, own, model)
    on_machine = (
        options.weights == "machine"
        and projection.rewiring is None
        and is_machine_generated(projection, model)
    )
    n_pre = network.populations[projection.pre].size
    return Wires(
        projection=projection, model=model, population=population,
        pre_first=network.offsets[projection.pre], n_pre=n_pre, post_first=own.start, post_last=own.stop,
        factor=factor,
        ticks=_ticks(projection, target.size, on_machine, options),
        incoming=incoming_of(projection, factor, n_pre, target.size),
        on_machine=on_machine, step_us=options.step_us,
    )  # fmt: skip


def _shift(target: Population, fellows: Sequence[Wires], options: SpinnakerOptions) -> int:
    """Return the left shift of a receptor; extensions do not repeat the software's error in the sum."""
    model, hints = fellows[0].model, hints_of(target, options)
    given = hints.summed_weights[fellows[0].receptor]
    if given is not None:
        return left_shift(given * model.weight_scale)
    own = hints.options
    expected = Expectation(own.step_us / 1000, own.spikes_per_second, own.ring_buffer_sigma)
    total_scale = model.weight_scale if model.extension else 1
    incoming = [part.incoming for part in fellows]
    return left_shift(largest_input(incoming, model.weight_scale, expected, total_scale=total_scale))


def _ticks(projection: Projection, n_post: int, on_machine: bool, options: SpinnakerOptions) -> IntArray:
    drawn = on_machine and parse_distribution(projection.origin.delay) is not None
    ticks = to_ticks(distinct(projection.delay_ms), options.step_us, drawn_on_machine=drawn)
    if not projection.size:
        return np.ones(1, np.int64)
    most = longest_delay(min(n_post, options.neurons_per_core))
    if ticks.max() > most:
        synapse, step_ms = int(np.argmax(ticks)), options.step_us / 1000
        raise NetworkError(
            f"projection '{projection.label}': the delay of synapse {synapse} is "
            f"{projection.delay_ms[synapse]:g} ms; with a time step of {step_ms:g} ms the machine reaches "
            f"{most * step_ms:g} ms (fewer neurons_per_core reach further)"
        )
    return ticks


def _lengthen(wires: Sequence[Wires], options: SpinnakerOptions) -> Findings:
    """Set delays of less than a step to one step; warn once each about these and other rounded ones."""
    step_ms = options.step_us / 1000
    below = [p for p in wires if distinct(p.projection.delay_ms).min(initial=step_ms) < step_ms]
    rounded = [part for part in wires if part not in below and _is_rounded(part, step_ms)]
    for part in wires:
        part.ticks = np.maximum(part.ticks, 1)
    warnings = Findings()
    if below:
        message = f"delays shorter than the time step of {step_ms:g} ms become one step: {_names(below)}"
        warnings.add(Code.NRP217, message)
    if rounded:
        warnings.add(Code.NRP217, f"delays become whole time steps of {step_ms:g} ms: {_names(rounded)}")
    return warnings


def _is_rounded(part: Wires, step_ms: float) -> bool:
    exact_ms = distinct(part.projection.delay_ms)
    return exact_ms.size > 0 and not np.allclose(part.ticks * step_ms, exact_ms, atol=1e-9)


def _names(wires: Sequence[Wires]) -> str:
    return ", ".join(f"'{part.projection.label}'" for part in wires)


@dataclass(frozen=True, slots=True)
class Synapses:
    """The synapses of several projections, ordered by source neuron.

    Args:
        order: index of each synapse in the concatenated projections.
        pre: global ids, ascending.
        line, weight, delay: as in :class:`~nrp_brain_spinnaker.machine.synaptic_inputs.Rows`.
    """

    order: IntArray
    pre: IndexArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray

    def rows(self, n_sources: int) -> Rows:
        """Return them with the index of the first synapse of each of ``n_sources`` global ids."""
        start = np.zeros(n_sources + 1, np.int64)
        np.cumsum(np.bincount(self.pre, minlength=n_sources), out=start[1:])
        return Rows(start, self.line, self.weight, self.delay)


def collect(wires: Sequence[Wires], n: int) -> Synapses:
    """Order the synapses of projections onto the lines of ``n`` neurons; a stable order."""
    no_index, no_weight = np.empty(0, np.int32), np.empty(0, np.uint16)
    pre = np.concatenate([no_index, *(part.projection.pre_index + part.pre_first for part in wires)])
    line = np.concatenate([no_index, *(_lines(part, n) for part in wires)])
    weight = np.concatenate([no_weight, *(part.raw for part in wires)])
    delay = np.concatenate([no_weight, *(_delays(part) for part in wires)])
    order = np.argsort(pre, kind="stable")
    return Synapses(
        order, pre[order].astype(np.int32), line[order].astype(np.int32), weight[order], delay[order]
    )


def _delays(part: Wires) -> WeightArray:
    return np.broadcast_to(part.ticks.astype(np.uint16), part.projection.pre_index.shape)


def _lines(part: Wires, n: int) -> IndexArray:
    return part.projection.post_index + np.int32(part.receptor * n + part.post_first)
