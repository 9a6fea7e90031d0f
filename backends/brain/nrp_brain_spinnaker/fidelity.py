"""What a network loses on the machine: weights that are rounded or vanish, delays that move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nrp_brain_spinnaker.loader import load
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.ring import LARGEST_ENTRY
from nrp_brain_spinnaker.weights import weight_scale
from nrp_brain_spinnaker.wiring import Wires
from nrp_core.brain.network import FloatArray, Network

_COARSE = 0.05


@dataclass(frozen=True, slots=True)
class ProjectionFidelity:
    """One projection.

    Args:
        label: of the projection.
        left_shift: of its receptor.
        quantum: the smallest difference between two weights, in the units of the model.
        largest_sum: what a receptor can take in one tick, likewise.
        synapses: how many there are.
        vanished: how many have a weight that became 0.
        mean_error, largest_error: of the other weights, relative.
        moved_delays: how many delays are not whole time steps.
        largest_move_ms: by how much one of them moved.
    """

    label: str
    left_shift: int
    quantum: float
    largest_sum: float
    synapses: int
    vanished: int
    mean_error: float
    largest_error: float
    moved_delays: int
    largest_move_ms: float


@dataclass(frozen=True, slots=True)
class Fidelity:
    """All projections, and what to do about the worst.

    Args:
        projections: in definition order, those with synapses.
        advice: what is lost and why.
    """

    projections: tuple[ProjectionFidelity, ...]
    advice: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, for JSON."""
        return asdict(self)

    def as_text(self) -> str:
        """Return a table and the advice."""
        head = f"{'projection':28s} {'shift':>5s} {'quantum':>10s} {'vanished':>10s} {'mean error':>10s}"
        rows = [
            f"{p.label[:28]:28s} {p.left_shift:5d} {p.quantum:10.3g} {p.vanished / p.synapses:10.1%} "
            f"{p.mean_error:10.2%}"
            for p in self.projections
        ]
        return "\n".join([head, *rows, *self.advice])


def weigh(network: Network, options: SpinnakerOptions) -> Fidelity:
    """Return what a network loses on the machine."""
    wires = load(network, options).wires
    seen = [_of_projection(part, options) for part in wires]
    advice = [_advice(part, projection, wires) for part, projection in zip(wires, seen, strict=True)]
    return Fidelity(tuple(seen), tuple(line for lines in advice for line in lines))


def _of_projection(part: Wires, options: SpinnakerOptions) -> ProjectionFidelity:
    given = np.abs(part.projection.weight)
    factor = np.ones(1) if part.factor is None else part.factor[part.projection.post_index]
    quanta = 1 / (weight_scale(part.shift, part.model.weight_scale) * factor)
    kept = part.raw * quanta
    vanished = (kept == 0) & (given > 0)
    errors = _relative(kept, given)[~vanished & (given > 0)]
    moves = np.abs(part.ticks * options.step_us / 1000 - part.projection.delay_ms)
    return ProjectionFidelity(
        label=part.projection.label, left_shift=part.shift,
        quantum=float(quanta.max()), largest_sum=float(quanta.max() * LARGEST_ENTRY),
        synapses=part.projection.size, vanished=int(vanished.sum()),
        mean_error=float(errors.mean()) if errors.size else 0.0,
        largest_error=float(errors.max()) if errors.size else 0.0,
        moved_delays=int((moves > 1e-9).sum()), largest_move_ms=float(moves.max()),
    )  # fmt: skip


def _relative(kept: FloatArray, given: FloatArray) -> FloatArray:
    return np.abs(kept - given) / np.where(given > 0, given, 1.0)


def _advice(part: Wires, seen: ProjectionFidelity, wires: Sequence[Wires]) -> list[str]:
    """Return what happens to the weights of a projection and why, if it matters."""
    if seen.vanished:
        lost = f"{seen.vanished} of {seen.synapses} weights become 0"
    elif seen.mean_error > _COARSE:
        lost = f"weights change by {seen.mean_error:.0%} on average"
    else:
        return []
    return [f"projection '{seen.label}': {lost} (in steps of {seen.quantum:.3g}); {_remedy(part, wires)}"]


def _remedy(part: Wires, wires: Sequence[Wires]) -> str:
    if part.on_machine and part.model.is_conductance_based:
        return "give weights as a list, or use the option weights: host, to keep more of them"
    fellows = [w for w in wires if (w.population, w.receptor) == (part.population, part.receptor)]
    strongest = max(fellows, key=lambda fellow: fellow.incoming.largest * fellow.incoming.connections)
    weight, n = strongest.incoming.largest, strongest.incoming.connections
    return (
        f"'{strongest.projection.label}' sets the scale, with weights up to {weight:.3g} and {n} synapses "
        "on a neuron; make the two more alike, or let its delays differ so that less is expected at once"
    )
