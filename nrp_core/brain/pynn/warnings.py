"""Statements of a brain script that its network cannot represent, as sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from nrp_core.brain.pynn.connectivity_estimate import highest_probability
from nrp_core.brain.pynn.electrodes import DCSource
from nrp_core.brain.pynn.populations import ids_of
from nrp_core.brain.pynn.simulator import State

_BY_A_FUNCTION = ("DistanceDependentProbabilityConnector", "IndexBasedProbabilityConnector")
_ROUNDING_MS = 1e-9
_FEWEST = 3
"""Cells of a group of which a list may leave out the first without a reason."""
_ROUNDING = 1e-9


def remarks_on(state: State, populations: Sequence[str], projections: Sequence[str]) -> tuple[str, ...]:
    """Return the remarks so far, and a sentence for each doubtful label, source, delay and pair of cells.

    Args:
        state: the objects that the script built.
        populations: the labels of its populations in the network, in the order of the script.
        projections: the labels of its projections.
    """
    return (
        *state.remarks,
        *_renamed(state.populations, populations),
        *_repeated(state.projections, projections),
        *_unused(state),
        *_changed_later(state),
        *_set_in_vain(state.projections),
        *_unplaced(state),
        *_beyond(state, projections),
        *_unpaired(state, projections),
        *_from_one(state, projections),
        *_multiple(state, projections),
        *_certain(state, projections),
        *_empty(state, projections),
    )


def _renamed(populations: Sequence[Any], labels: Sequence[str]) -> Iterator[str]:
    for one, label in zip(populations, labels, strict=True):
        if one.label != label:
            yield f"two populations have the label '{one.label}'; the later one is called '{label}'"


def _repeated(projections: Sequence[Any], labels: Sequence[str]) -> Iterator[str]:
    """Yield labels that two projections between the same populations share.

    Projections between different populations may share a label. A projection without one is named after its
    populations.
    """
    counts = Counter(one.label for one in projections if one.has_own_label)
    seen: set[tuple[str, bytes, bytes]] = set()
    for one, label in zip(projections, labels, strict=True):
        if counts[one.label] < 2 or not one.has_own_label:
            continue
        ends = (ids_of(cells).tobytes() for cells in (one.pre, one.post))
        key = (one.label, *ends)
        if key in seen:
            yield (
                f"two projections from '{one.pre.label}' to '{one.post.label}' have the label '{one.label}'; "
                f"the later one is called '{label}'"
            )
        seen.add(key)


def _unused(state: State) -> Iterator[str]:
    injected = set(map(id, state.injected()))
    for number, source in enumerate(state.sources, start=1):
        if id(source) not in injected:
            yield (
                f"a {type(source).__name__} (the current source {number} of {len(state.sources)}) is never "
                f"injected: call its inject_into(cells)"
            )
        elif isinstance(source, DCSource) and not source.amplitude:
            yield f"a {type(source).__name__} has no effect: its amplitude is 0 nA"


def _changed_later(state: State) -> Iterator[str]:
    """Yield the cell types that were changed after the last population was made of them."""
    for one in {id(one.celltype): one for one in state.populations}.values():
        kind, made_of = one.celltype, one.made_of
        changed = [name for name, value in kind.parameter_space.items() if value is not made_of.get(name)]
        for name in sorted({*changed, *(vars(kind).keys() & kind.default_parameters.keys())}):
            yield (
                f"{name} of the cell type {type(kind).__name__} has no effect: it is changed after "
                f"'{one.label}' was made; a population is changed by its set({name}=...)"
            )


def _set_in_vain(projections: Sequence[Any]) -> Iterator[str]:
    """Yield the synapse types of which an attribute was set, which changes no synapse."""
    for one in {id(one.synapse_type): one for one in projections}.values():
        kind = type(one.synapse_type).__name__
        for name in sorted(getattr(one.synapse_type, "set_in_vain", ())):
            yield (
                f"{name} of the synapse type {kind} has no effect: it is set as an attribute; give it to "
                f"{kind}({name}=...), or change '{one.label}' by its set({name}=...)"
            )


def _unplaced(state: State) -> Iterator[str]:
    """Yield the settings of cells on a machine that no population has."""
    for cell, hints in state.hints_by_cell.items():
        if hints and not any(
            type(one.celltype) is cell and hints.keys() <= one.hints.keys() for one in state.populations
        ):
            names = " and ".join(name.replace("_", " ") for name in hints)
            yield (
                f"the setting of {names} for {cell.__name__} has no effect: no population of these cells is "
                "made after it"
            )


def _beyond(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections with a delay below that of ``setup``; one above it is refused."""
    for projection, label in zip(state.projections, labels, strict=True):
        delays_ms = projection.values.extremes("delay")
        if not delays_ms.size:
            continue
        shortest_ms, low_ms = float(delays_ms.min()), state.least_delay_ms
        if shortest_ms < low_ms - _ROUNDING_MS:
            yield (
                f"a delay of the projection '{label}' is {shortest_ms:g} ms, and min_delay of setup is "
                f"{low_ms:g} ms"
            )


def _unpaired(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections between groups of two sizes whose cells are connected in pairs."""
    for one, label in zip(state.projections, labels, strict=True):
        if type(one.connector).__name__ == "OneToOneConnector" and one.pre.size != one.post.size:
            yield (
                f"the projection '{label}' is one to one, but '{one.pre.label}' has {one.pre.size} cells and "
                f"'{one.post.label}' has {one.post.size}: the remaining cells are not connected"
            )


def _from_one(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections of a list with all cells of both groups but the first, which nothing connects."""
    for one, label in zip(state.projections, labels, strict=True):
        ends = (one.pre, one.post)
        if type(one.connector).__name__ != "FromListConnector" or not one.connector.conn_list.size:
            continue
        columns = one.connector.conn_list[:, :2].T
        if min(cells.size for cells in ends) < _FEWEST or not all(
            np.array_equal(np.unique(column), np.arange(1, cells.size))
            for column, cells in zip(columns, ends, strict=True)
        ):
            continue
        others = [cells for each in state.projections if each is not one for cells in (each.pre, each.post)]
        connected = np.concatenate([np.empty(0, np.int64), *map(ids_of, others)])
        if not np.isin([ids_of(cells)[0] for cells in ends], connected).any():
            yield (
                f"the list of the projection '{label}' has all cells of '{one.pre.label}' and "
                f"'{one.post.label}' but the first; cells are numbered from 0"
            )


def _multiple(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections that connect each cell to more partners than there are, so to some repeatedly."""
    for one, label in zip(state.projections, labels, strict=True):
        name, n = type(one.connector).__name__, getattr(one.connector, "n", None)
        among = {"FixedNumberPreConnector": one.pre, "FixedNumberPostConnector": one.post}.get(name)
        if among is None or not isinstance(n, int) or one.connector.with_replacement or n <= among.size:
            continue
        yield (
            f"n of the {name} of the projection '{label}' is {n}, and '{among.label}' has {among.size} "
            f"cells: pairs of cells have {n / among.size:.3g} synapses each"
        )


def _certain(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections with a probability above 1, which connects pairs of cells as 1 does."""
    for one, label in zip(state.projections, labels, strict=True):
        highest = highest_probability(one.connector, one)
        if highest > 1.0 + _ROUNDING:
            yield (
                f"the {type(one.connector).__name__} of the projection '{label}' gives probabilities up to "
                f"{highest:.3g}; above 1 it connects every pair"
            )


def _empty(state: State, labels: Sequence[str]) -> Iterator[str]:
    """Yield the projections whose connector drew no synapse; a probability of 0 is deliberate.

    So is a beginning without synapses where they form while the network runs.
    """
    for one, label in zip(state.projections, labels, strict=True):
        name = type(one.connector).__name__
        draws = name in _BY_A_FUNCTION or getattr(one.connector, "p_connect", 0.0) > 0.0
        if draws and not len(one) and getattr(one.synapse_type, "rewiring", None) is None:
            yield f"the projection '{label}' has no synapses: its {name} connects no pair of cells"
