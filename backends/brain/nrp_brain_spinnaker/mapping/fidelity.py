"""The losses of a network on the machine: rounded, vanished or wrapped weights and saturated input."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.ring import LARGEST_ENTRY
from nrp_brain_spinnaker.mapping.activity import share_above, spikes_per_tick
from nrp_brain_spinnaker.mapping.learning import lost_changes
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import RECEPTORS, Network
from nrp_core.findings import Code, Finding, Findings

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
    learning = [lost_changes(part, options) for part in wires]
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
