"""The losses of a network on the machine: rounded, vanished or wrapped weights and saturated input.

The assumed activity of a network before a run.

Weight changes that plastic synapses lose, because the machine stores weights in steps.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.weights import poisson_share_below
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.synaptic_inputs import LARGEST_ENTRY
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core._support.arrays import FloatArray
from nrp_core.findings import Code, Finding, Findings
from nrp_core.network.data import RECEPTORS, Network, Population
from nrp_core.network.limits import distinct
from nrp_core.network.synapses import STDP


def spikes_per_tick(population: Population, options: SpinnakerOptions) -> float:
    """Return the assumed spikes of each cell per tick: a Poisson source's own, else the options'."""
    return rate_hz(population, options) * options.step_us * 1e-6


def rate_hz(population: Population, options: SpinnakerOptions) -> float:
    """Return the assumed rate of each cell: that of a Poisson source, else the option's."""
    rates = population.parameters.get("rate")
    if population.is_source and rates is not None:
        return float(rates.mean())
    return options.spikes_per_second


def share_above(limit: float, mean: float, variance: float) -> float:
    """Return the probability that the weights of a Poisson number of spikes add up to more than a limit.

    Exact for equal weights; others are replaced by equal ones that give the same mean and variance.

    Args:
        limit: the limit, in the units of the weights, as are the moments.
        mean: mean of the sum.
        variance: variance of the sum.
    """
    if mean <= 0 or variance <= 0:
        return 0.0
    weight = variance / mean
    return max(0.0, 1.0 - poisson_share_below(int(limit / weight) + 1, mean / weight))


def lost_changes(part: Wires) -> str | None:
    """Return the changes of weights by a pair of spikes that are at most smaller than a step.

    A changed weight is rounded down to a step: an increase by less than a step is lost, a decrease by less
    than a step becomes a whole step.

    Args:
        part: a projection on the machine.
    """
    projection = part.projection
    if (
        projection.synapse_type != STDP
        or not projection.size
        or "A_plus" not in projection.synapse_parameters
    ):
        return None  # only the rule of pairs loses as much each time
    step = 1.0 / part.scale
    given = {name: float(distinct(values)[0]) for name, values in projection.synapse_parameters.items()}
    factor = 1.0 if part.factor is None else float(np.min(part.factor))
    low, high = abs(given["w_min"]) * factor, abs(given["w_max"]) * factor
    if projection.plasticity["weight_dependence"] == "MultiplicativeWeightDependence":
        most = high - low
    else:
        most = high
    up, down = given["A_plus"] * most, given["A_minus"] * most
    lines = []
    if 0 < up < step:
        lines.append(f"a pair of spikes adds at most {up:.3g}, which is rounded to 0")
    if 0 < down < step:
        lines.append(f"a pair of spikes should subtract at most {down:.3g}, but subtracts a whole step")
    if not lines:
        return None
    return (
        f"projection '{projection.label}': its weights are stored in steps of {step:.3g}: "
        f"{'; '.join(lines)}; "
        "increase A_plus and A_minus, or the range of the weights"
    )


_COARSE = 0.05
_RARE = 1e-4
"""Share of saturated ticks below which no advice is given."""


@dataclass(frozen=True, slots=True)
class ProjectionFidelity:
    """One projection.

    Args:
        label: the projection's label.
        left_shift: the left shift of its receptor.
        quantum: the smallest difference between two weights, in the units of the model.
        largest_sum: the largest input of a receptor in one tick, in the same units.
        synapses: the number of synapses.
        vanished: the number of weights that became 0.
        wrapped: the number of weights beyond 16 bits, of which only the low bits stay.
        mean_error, largest_error: relative errors of the other weights.
        moved_delays: the number of delays that are not whole time steps.
        largest_move_ms: the largest change of such a delay.
    """

    label: str
    left_shift: int
    quantum: float
    largest_sum: float
    synapses: int
    vanished: int
    wrapped: int
    mean_error: float
    largest_error: float
    moved_delays: int
    largest_move_ms: float


@dataclass(frozen=True, slots=True)
class ReceptorFidelity:
    """The expected input of one receptor of a population at the assumed rates.

    Args:
        population: its label.
        receptor: its name.
        left_shift: left shift of its ring buffers.
        largest_sum: its largest input in one tick, in the units of the target's synapses.
        mean_sum, deviation: mean and standard deviation of a neuron's input in a tick, in the same units.
        saturating: fraction of ticks in which the input exceeds ``largest_sum``.
    """

    population: str
    receptor: str
    left_shift: int
    largest_sum: float
    mean_sum: float
    deviation: float
    saturating: float


@dataclass(frozen=True, slots=True)
class Fidelity:
    """All projections and receptors, with advice on the worst.

    Args:
        projections: projections with synapses, in definition order.
        receptors: receptors with projections.
        losses: the weights that are destroyed, with reasons.
        advice: other losses.
    """

    projections: tuple[ProjectionFidelity, ...]
    receptors: tuple[ReceptorFidelity, ...]
    losses: tuple[Finding, ...]
    advice: tuple[str, ...]


def weigh(network: Network, wires: Sequence[Wires], options: SpinnakerOptions) -> Fidelity:
    """Return the losses of a network on the machine.

    Args:
        network: the network.
        wires: its projections on the machine.
        options: the options of the user.
    """
    wires = [part for part in wires if part.projection.size]
    seen = [_of_projection(part, options) for part in wires]
    receptors = _receptors(network, wires, options)
    coarse = [_coarse(part, projection, wires) for part, projection in zip(wires, seen, strict=True)]
    learning = [lost_changes(part) for part in wires]
    advice = [*filter(None, (*coarse, *learning, *map(_saturation, receptors)))]
    return Fidelity(tuple(seen), tuple(receptors), tuple(losses(wires, options)), tuple(advice))


def losses(wires: Sequence[Wires], options: SpinnakerOptions) -> Findings:
    """Return the weights that do not fit the machine's 16 bits, with reasons."""
    found = Findings()
    for part in wires:
        if _is_distorted(part):
            _add_losses(found, part, wires, options)
    return found


def _is_distorted(part: Wires) -> bool:
    """Return whether a weight wraps or vanishes, by the extremes only."""
    present = part.sizes[part.sizes > 0]
    if not present.size:
        return False
    wraps = float(present.max()) * part.scale >= LARGEST_ENTRY + 0.5
    return wraps or not part.converted(present.min(keepdims=True)).any()


def _add_losses(found: Findings, part: Wires, wires: Sequence[Wires], options: SpinnakerOptions) -> None:
    seen = _of_projection(part, options)
    where = f"projection '{seen.label}'"
    if seen.wrapped:
        found.add(
            Code.NRP217,
            f"{where}: {seen.wrapped} of {seen.synapses} weights wrap around: they are larger than "
            f"{seen.largest_sum:.3g}, the limit of 16 bits; give them as a list, so that the scale fits them",
            subject=seen.label,
        )
    if seen.vanished:
        lost = f"{seen.vanished} of {seen.synapses} weights become 0 (in steps of {seen.quantum:.3g})"
        found.add(Code.NRP217, f"{where}: {lost}; {_remedy(part, wires)}", subject=seen.label)


def _of_projection(part: Wires, options: SpinnakerOptions) -> ProjectionFidelity:
    sizes = part.sizes
    kept = part.converted(sizes) / part.scale
    wrapped = sizes * part.scale >= LARGEST_ENTRY + 0.5
    vanished = (kept == 0) & (sizes > 0) & ~wrapped
    errors = _relative(kept, sizes)[~vanished & ~wrapped & (sizes > 0)]
    moves = np.abs(part.ticks * options.step_us / 1000 - part.projection.delay_ms)
    each = part.projection.size // sizes.size
    quantum = 1 / (part.scale * (1.0 if part.factor is None else float(part.factor.min())))
    return ProjectionFidelity(
        label=part.projection.label, left_shift=part.shift,
        quantum=quantum, largest_sum=quantum * LARGEST_ENTRY,
        synapses=part.projection.size,
        vanished=int(vanished.sum()) * each, wrapped=int(wrapped.sum()) * each,
        mean_error=float(errors.mean()) if errors.size else 0.0,
        largest_error=float(errors.max()) if errors.size else 0.0,
        moved_delays=int((moves > 1e-9).sum()), largest_move_ms=float(moves.max()),
    )  # fmt: skip


def _relative(kept: FloatArray, given: FloatArray) -> FloatArray:
    return np.abs(kept - given) / np.where(given > 0, given, 1.0)


def _receptors(network: Network, wires: Sequence[Wires], options: SpinnakerOptions) -> list[ReceptorFidelity]:
    groups: dict[tuple[str, int], list[Wires]] = defaultdict(list)
    for part in wires:
        groups[part.projection.post, part.receptor].append(part)
    return [_of_receptor(network, parts, options) for parts in groups.values()]


def _of_receptor(network: Network, parts: Sequence[Wires], options: SpinnakerOptions) -> ReceptorFidelity:
    """Return the expected input of a neuron, with Poisson spikes of each weight."""
    first = parts[0]
    n_post = first.post_last - first.post_first
    mean = variance = 0.0
    for part in parts:
        spikes = spikes_per_tick(network.populations[part.projection.pre], options)
        spikes *= part.projection.size / n_post
        mean += spikes * float(part.sizes.mean())
        variance += spikes * float(np.square(part.sizes).mean())
    largest = LARGEST_ENTRY / first.scale
    return ReceptorFidelity(
        first.projection.post, RECEPTORS[first.receptor], first.shift, largest, mean, variance**0.5,
        share_above(largest, mean, variance),
    )  # fmt: skip


def _saturation(seen: ReceptorFidelity) -> str | None:
    if seen.saturating < _RARE:
        return None
    return (
        f"population '{seen.population}': its {seen.receptor} input is cut off in {seen.saturating:.2%} of "
        f"all time steps (at {seen.largest_sum:.3g}; {seen.mean_sum:.3g} is expected); set "
        "spikes_per_second to the network's firing rate, or use a larger ring_buffer_sigma"
    )


def _coarse(part: Wires, seen: ProjectionFidelity, wires: Sequence[Wires]) -> str | None:
    if seen.mean_error <= _COARSE:
        return None
    lost = f"weights change by {seen.mean_error:.0%} on average (in steps of {seen.quantum:.3g})"
    return f"projection '{seen.label}': {lost}; {_remedy(part, wires)}"


def _remedy(part: Wires, wires: Sequence[Wires]) -> str:
    """Return the reason for the scale of a receptor, and how to make it finer."""
    if part.on_machine and part.model.is_conductance_based:
        return "give weights as a list, or use the option weights: host, to keep more of them"
    fellows = [w for w in wires if (w.population, w.receptor) == (part.population, part.receptor)]
    strongest = max(fellows, key=lambda fellow: fellow.incoming.largest * fellow.incoming.connections)
    weight, n = strongest.incoming.largest, strongest.incoming.connections
    return (
        f"'{strongest.projection.label}' sets the scale, with weights up to {weight:.3g} and {n} synapses "
        "on a neuron; make the two more similar, or vary its delays so that less input is expected at once"
    )
