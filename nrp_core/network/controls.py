"""Controls: networks that share some statistics with another network and are random otherwise.

A finding that also appears in a rewired network does not depend on the wiring. Every projection and every
shuffle has its own named random stream. Projections that a control does not change stay the same objects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.data import LISTED, Network, Projection
from nrp_core.network.interventions import Intervention
from nrp_core.seeds import Seeds

Control = Callable[[Network, Seeds], Network]
_ROUNDS: Final = 200
_OTHER: Final = {"excitatory": "inhibitory", "inhibitory": "excitatory"}


def rewired(network: Network, seeds: Seeds) -> Network:
    """Return the network with the targets of each projection permuted among its synapses.

    Every cell keeps its number of synapses from and to each population; weight and delay stay with the
    source. Synapses of a cell with itself and several synapses between one pair of cells appear only if
    the projection already has some. A projection that is too small or dense for another wiring is
    unchanged, with a remark.
    """
    found = _each(network, seeds, "rewire", _rewire)
    pairs = zip(network.projections, found.projections, strict=True)
    same = [one.label for one, other in pairs if one.size and other is one]
    remarks = tuple(
        f"projection '{label}' is not rewired: no other wiring with the same degrees was found"
        for label in same
    )
    return replace(found, remarks=network.remarks + remarks)


def with_shuffled_weights(network: Network, seeds: Seeds) -> Network:
    """Return the network with the weights of each projection permuted among its synapses.

    The order differs from the original; a projection whose weights are all equal is unchanged.
    """

    def shuffled(projection: Projection, rng: np.random.Generator) -> Projection:
        if (projection.weight == projection.weight[0]).all():
            return projection
        return replace(projection, weight=_permuted(projection.weight, rng), origin=LISTED)

    return _each(network, seeds, "weights", shuffled)


def with_shuffled_signs(network: Network, seeds: Seeds) -> Network:
    """Return the network with the signs of its cells permuted; as many cells excite and inhibit as before.

    The synapses of a cell with a new sign act on the other receptor, with equal magnitude. Cells with
    synapses of both signs and spike sources keep their signs. Rewards, punishments and gap junctions have
    none.
    """
    excites, inhibits = (np.zeros(network.size, bool) for _ in range(2))
    for projection in filter(_has_sign, network.projections):
        ids = network.offsets[projection.pre] + projection.pre_index
        (excites if projection.is_excitatory else inhibits)[ids] = True
    for label, population in network.populations.items():
        if population.is_source:
            excites[network.ids_of(label)] = inhibits[network.ids_of(label)] = False
    signed = np.flatnonzero(excites != inhibits)
    changes = np.zeros(network.size, bool)
    signs = excites[signed]
    if signs.any() and not signs.all():
        changes[signed] = signs != _permuted(signs, seeds.stream("signs"))
    projections: list[Projection] = []
    for projection in network.projections:
        moved = changes[network.offsets[projection.pre] + projection.pre_index]
        if not _has_sign(projection):
            moved[:] = False
        if (~moved).any() or not len(moved):
            projections.append(projection.only(~moved) if moved.any() else projection)
        if moved.any():
            projections.append(_on_other_receptor(network, projection.only(moved)))
    return replace(network, projections=tuple(projections))


_QUARTERS: Final = (0.25, 0.5, 0.75)


def with_matched_cells_silenced(network: Network, cells: str, seeds: Seeds) -> Network:
    """Return the network with as many other cells silenced as a population or group has.

    Each is drawn from the same population and quarter of the numbers of outgoing synapses, as far as that
    has enough other cells; the rest from the whole population.

    Raises:
        NetworkError: a population has too few other cells with outgoing synapses.
        NeuronSelectionError: the cells do not exist.
    """
    named, rng = network.neurons(cells), seeds.stream("matched")
    degrees = np.zeros(network.size, np.int64)
    for projection in network.projections:
        degrees += np.bincount(network.offsets[projection.pre] + projection.pre_index, minlength=network.size)
    drawn = [np.empty(0, np.int64)]
    for label in network.populations:
        ids = network.ids_of(label)
        quarter = np.searchsorted(np.quantile(degrees[ids], _QUARTERS), degrees[ids]) if len(ids) else ids
        mine, others = np.isin(ids, named), (degrees[ids] > 0) & ~np.isin(ids, named)
        for number in np.unique(quarter[mine]):
            alike = ids[others & (quarter == number)]
            drawn.append(rng.choice(alike, min(len(alike), int((mine & (quarter == number)).sum())), False))
        rest = np.setdiff1d(ids[others], np.concatenate(drawn))
        lacking = int(mine.sum()) - int(np.isin(ids, np.concatenate(drawn)).sum())
        if lacking > len(rest):
            raise NetworkError(
                f"'{cells}' has {mine.sum()} cells of '{label}', but only {others.sum()} other cells of "
                f"'{label}' have outgoing synapses and can be silenced instead"
            )
        drawn.append(rng.choice(rest, lacking, False))
    matched = np.sort(np.concatenate(drawn))
    changed = Intervention.silence("matched").of(
        replace(network, views={**network.views, "matched": matched})
    )
    return replace(changed, views=network.views)


def _has_sign(projection: Projection) -> bool:
    return projection.neuromodulation is None and not projection.is_electrical


CONTROLS: Final[Mapping[tuple[str, str], Control]] = MappingProxyType(
    {
        ("rewire", "degree_preserving"): rewired,
        ("shuffle", "signs"): with_shuffled_signs,
        ("shuffle", "weights"): with_shuffled_weights,
    }
)
"""The controls by the key and value that select them in an experiment file."""


def _each(
    network: Network, seeds: Seeds, name: str, change: Callable[[Projection, np.random.Generator], Projection]
) -> Network:
    streams = seeds.child(name)
    changed = (
        change(projection, streams.stream(projection.label)) if projection.size else projection
        for projection in network.projections
    )
    return replace(network, projections=tuple(changed))


def _permuted(values: npt.NDArray[Any], rng: np.random.Generator) -> npt.NDArray[Any]:
    """Return values, which must not all be equal, in a random order that differs from theirs."""
    while np.array_equal(drawn := rng.permutation(values), values):
        pass
    return drawn


def _rewire(projection: Projection, rng: np.random.Generator) -> Projection:
    pre, post = projection.pre_index.astype(np.int64), projection.post_index.astype(np.int64)
    span = int(post.max()) + 1
    loops = projection.pre != projection.post or bool((pre == post).any())
    doubles = len(np.unique(pre * span + post)) < len(pre)
    new = rng.permutation(post)
    for _ in range(_ROUNDS):
        bad = _forbidden_synapses(pre, new, span, loops=loops, doubles=doubles)
        if not len(bad):
            if (np.sort(pre * span + new) == np.sort(pre * span + post)).all():
                break
            return replace(projection, post_index=new.astype(np.int32), origin=LISTED)
        for synapse, other in zip(bad, rng.integers(len(new), size=len(bad)), strict=True):
            new[synapse], new[other] = new[other], new[synapse]
    return projection


def _forbidden_synapses(pre: IntArray, post: IntArray, span: int, *, loops: bool, doubles: bool) -> IntArray:
    """Return the indices of forbidden synapses: self-connections and duplicates, except the first of each."""
    wrong = np.zeros(len(pre), bool)
    if not loops:
        wrong |= pre == post
    if not doubles:
        _, first = np.unique(pre * span + post, return_index=True)
        again = np.ones(len(pre), bool)
        again[first] = False
        wrong |= again
    return np.flatnonzero(wrong)


def _on_other_receptor(network: Network, projection: Projection) -> Projection:
    if projection.receptor not in _OTHER:
        raise NetworkError(
            f"shuffle: signs: projection '{projection.label}' ends on the receptor '{projection.receptor}', "
            "which has no opposite; signs are exchanged between excitatory and inhibitory receptors"
        )
    receptor = _OTHER[projection.receptor]
    taken = {one.label for one in network.projections}
    label = f"{projection.label} ({receptor})"
    while label in taken:
        label += "'"
    sign = 1.0 if network.populations[projection.post].is_conductance_based else -1.0
    return replace(projection, label=label, receptor=receptor, weight=sign * projection.weight)
