"""A connectome as a network of the cells of Shiu et al. (2024), with groups of neurons by name."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import reduce
from math import inf
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain import IntArray, Network, Population
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_core.utilities import join_with_limit
from nrp_formats.connectome.edges import EdgeChunk, read_edges
from nrp_formats.connectome.neurons import Neurons, read_neurons
from nrp_formats.connectome.signs import Signs
from nrp_formats.connectome.tables import checksum
from nrp_formats.connectome.wiring import Places, Wiring

LABEL: Final = "brain"
CELL: Final = "IF_curr_exp_frozen"
_PUBLISHED: Final = {"v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_refrac": 2.2, "cm": 0.02}
"""Shiu et al. (2024); the capacitance, which they do not need, makes 1 pA lead to 1 mV."""
_OF_WORMS: Final = {"AVAL", "AVAR", "AVBL", "AVBR"}
"""Command neurons of *C. elegans*; a table that contains them is recognised as one of the worm."""
_KNOWN: Final = {
    "efeb23fb99098e9c390f6869969b2a121a2ee92c833cfc45ecb2c1d8e1af0347": "FlyWire v783, Shiu et al. (2024)",
    "cd6707feebb17fc3cf47bc929eac08108ccfc8d154063ac816289d4c10eb1518": "C. elegans, Cook et al. (2019)",
    "98bdafffce1341d3443a83066a6225a977c8218c28c27d69e4bd465782bd4cc8": "Cook et al. (2019), cect 0.3.5",
}
"""Published tables by their SHA-256."""
MOST_GROUPS: Final = 2000
_MAX_NAMED: Final = 12
_MUSCLE: Final = re.compile(r"M[DV][LR]\d\d|BWM-[DV][LR]\d\d|[dv]BWM[LR]\d+")
"""Muscles of the body wall of *C. elegans*, as Cook et al. (2019) and Witvliet et al. (2021) name them."""
_BY: Final = ("transmitter", "class", "side", "type", "name")


@dataclass(frozen=True)
class Connectome:
    """A network and its origin.

    Args:
        network: the network.
        sources: SHA-256 of each table, and the name of published ones.
        left_out: edges whose ends are not both in the table of neurons.
        unknown: edges whose sign the tables do not give, by the type of their source.
        empty: edges with an empty cell in the table, which are left out.
        self_junctions: gap junctions of a cell with itself, which have no effect and are left out.
    """

    network: Network
    sources: dict[str, str] = field(default_factory=dict)
    left_out: int = 0
    unknown: dict[str, int] = field(default_factory=dict)
    empty: int = 0
    self_junctions: int = 0


def read_connectome(
    edges: Path, neurons: Path | Sequence[Path] = (), *, junctions: Path | None = None,
    groups: tuple[str, ...] = (), unit_mv: float = 0.275, delay_ms: float = 1.8, junction_ns: float = 0.1,
    unknown: str | Path | None = None,
) -> Connectome:  # fmt: skip
    """Read a connectome.

    Args:
        edges: the table of edges.
        neurons: the table of neurons, or several: the first has all neurons, and each other one adds what is
            not known of them; without a table, the neurons are those with edges, by id.
        junctions: a table of gap junctions, if they are not in the table of edges.
        groups: patterns such as ``MN9*`` of the groups to name; by default all.
        unit_mv: weight of one synapse, above 0.
        delay_ms: delay of all synapses, above 0.
        junction_ns: conductance of one gap junction; 0 leaves them out. The default is that of Kunert et al.
            (2014, Phys Rev E 89:052805).
        unknown: the rule for edges of unknown sign: ``exclude``, ``excite``, or a table with the columns
            ``type`` and ``sign``; without one they are an error.

    Raises:
        NetworkError: a table or a number cannot be used; the message says why.
    """
    for name, value in (("unit_mv", unit_mv), ("delay_ms", delay_ms)):
        if not 0.0 < value < inf:
            raise NetworkError(f"{name} is {value:g}; it must be above 0")
    if not 0.0 <= junction_ns < inf:
        raise NetworkError(f"junction_ns is {junction_ns:g}; it must be 0 or more")
    signs = Signs.of(unknown)

    def chunks() -> Iterator[EdgeChunk]:
        yield from read_edges(edges, signs)
        for part in read_edges(junctions, signs) if junctions else ():
            yield replace(part, is_electrical=np.ones(len(part.pre), bool), transmitters=Counter())

    tables = [neurons] if isinstance(neurons, Path) else [*neurons]
    known = (
        reduce(Neurons.completed, tables[1:], read_neurons(tables[0])) if tables else _neurons_of(chunks())
    )
    wiring = Wiring(len(known.ids))
    wiring.read(chunks(), known.ids)
    if not wiring.rows:
        raise NetworkError(
            f"no edge of {wiring.left_out} joins two of the {len(known.ids)} neurons", path=edges
        )
    wiring.take_signs(known.signs(signs))
    undecided = _apply_rule(wiring, known, signs, edges)
    if not sum(map(len, (wiring.excitatory, wiring.inhibitory, wiring.electrical))):
        if undecided:
            raise NetworkError(f"all {sum(undecided.values())} edges have an unknown sign", path=edges)
        raise NetworkError(f"all {wiring.rows} edges have 0 synapses", path=edges)
    network = Network(
        {LABEL: _population(known)},
        (*wiring.projections(LABEL, unit_mv, delay_ms), *wiring.junctions(LABEL, 1e-3 * junction_ns)),
        _groups(known, groups, (*tables, edges)[0]),
        remarks=(*known.remarks, *_about_glutamate(known, signs)),
    )
    sources = _sources(edges, *tables, junctions)
    return Connectome(network, sources, wiring.left_out, undecided, wiring.empty, wiring.self_junctions)


def _about_glutamate(known: Neurons, signs: Signs) -> Iterator[str]:
    """Yield a note if the rule for flies is applied to the signs of a worm."""
    names, transmitters = (known.texts.get(what, ()) for what in ("name", "transmitter"))
    count = sum(
        text.strip().lower().startswith("glu") and signs.of_transmitter(text) < 0 for text in transmitters
    )
    if count and set(names) >= _OF_WORMS and "glutamate" not in signs.given:
        yield (
            f"{count} glutamatergic neurons are inhibitory, as in flies; in C. elegans many are excitatory "
            "(Fenyves et al. 2020, PLoS Comput Biol 16:e1007974): to change this, add a row of 'glutamate' "
            "to a table for --unknown"
        )


def _apply_rule(wiring: Wiring, known: Neurons, signs: Signs, path: Path) -> dict[str, int]:
    """Apply the user's rule to edges of unknown sign; return their numbers by type of source.

    Raises:
        NetworkError: the rule does not contain a type.
    """
    undecided: Counter[str] = Counter()
    asked: Counter[str] = Counter()
    decided = np.zeros(len(known.ids), int)
    for cell in np.flatnonzero(wiring.unknown.degrees).tolist():
        labels, count = known.labels(cell), int(wiring.unknown.degrees[cell])
        label = known.label(cell)
        undecided[label] += count
        sign = signs.decided(labels)
        if sign is None:
            asked[label] += count
        else:
            decided[cell] = sign
    if asked:
        total = sum(map(len, (wiring.excitatory, wiring.inhibitory, wiring.unknown)))
        transmitters = [f"'{text}'" if text else "none" for text, _ in wiring.transmitters.most_common()]
        given = f" (given: {join_with_limit(transmitters, _MAX_NAMED)})" if transmitters else ""
        raise NetworkError(
            f"{sum(asked.values())} of {total} edges have a transmitter of unknown sign{given}: "
            f"{counts_by_type(asked)}; choose --unknown exclude, --unknown excite, or --unknown FILE, "
            "a table with the columns type and sign",
            path=path,
        )
    wiring.assign(decided)
    return dict(undecided.most_common())


def counts_by_type(counts: Mapping[str, int]) -> str:
    """Return numbers of edges by the type of their sources, the largest first."""
    ordered = sorted(counts.items(), key=lambda one: -one[1])
    return join_with_limit([f"{label} {count}" for label, count in ordered], _MAX_NAMED)


def _neurons_of(chunks: Iterable[EdgeChunk]) -> Neurons:
    """Return the neurons with edges, in the order of their names or ids."""
    ids, names = np.empty(0, np.int64), dict[int, str]()
    places = Places(ids)
    for part in chunks:
        for end in (part.pre, part.post, np.array([*part.names], np.int64)):
            _, is_known = places.of(end)
            if not is_known.all():
                ids = np.union1d(ids, end[~is_known])
                places = Places(ids)
        names.update(part.names)
    if not names:
        return Neurons(ids, {})
    named = sorted((names.get(number, str(number)), number) for number in ids.tolist())
    texts = {"name": [name for name, _ in named]}
    if any(map(_MUSCLE.fullmatch, texts["name"])):
        texts["class"] = ["muscle" if _MUSCLE.fullmatch(name) else "" for name in texts["name"]]
    return Neurons(np.array([number for _, number in named], np.int64), texts)


def _population(known: Neurons) -> Population:
    size, cell = len(known.ids), CELLS[CELL]
    values = {name: _PUBLISHED.get(name, parameter.default) for name, parameter in cell.parameters.items()}
    parameters = {name: np.full(size, value) for name, value in values.items()}
    return Population(LABEL, size, CELL, parameters, {"v": parameters["v_rest"]}, (), known.positions)


def _groups(known: Neurons, patterns: tuple[str, ...], path: Path) -> dict[str, IntArray]:
    """Return the groups of neurons that match a pattern: by transmitter, class, side, type and name.

    A type or name with a side gives three groups: MN9, MN9_left, MN9_right.
    """
    found: dict[str, list[int]] = {}
    sides = known.texts.get("side", [""] * len(known.ids))
    for what in _BY:
        for index, text in enumerate(known.texts.get(what, ())):
            if text:
                name = re.sub(r"\W+", "_", text).strip("_")
                name = f"_{name}" if name[:1].isdigit() else name
                found.setdefault(name, []).append(index)
                if sides[index] and what not in ("side", "name"):
                    found.setdefault(f"{name}_{sides[index]}", []).append(index)
    chosen = {name for name in found if not patterns or any(fnmatchcase(name, one) for one in patterns)}
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in found):
            raise NetworkError(f"no group is called '{pattern}'{did_you_mean(pattern, found)}", path=path)
    if len(chosen) > MOST_GROUPS:
        raise NetworkError(
            f"the table names {len(chosen)} groups, more than {MOST_GROUPS}; choose some: --group 'MN9*'",
            path=path,
        )
    return {name: np.unique(found[name]) for name in sorted(chosen)}


def _sources(*paths: Path | None) -> dict[str, str]:
    sums = {path: checksum(path) for path in paths if path}
    return {
        str(path): f"{sha256} ({_KNOWN.get(sha256, 'not a table that is known here')})"
        for path, sha256 in sums.items()
    }
