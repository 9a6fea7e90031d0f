"""A connectome as a network of the cells of Shiu et al. (2024), with groups of neurons by name."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from math import inf
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain import IntArray, Network, Population
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_formats.connectome.edges import read_edges
from nrp_formats.connectome.neurons import Neurons, read_neurons
from nrp_formats.connectome.tables import checksum
from nrp_formats.connectome.wiring import Places, Wiring

LABEL: Final = "brain"
CELL: Final = "IF_curr_exp_frozen"
_PUBLISHED: Final = {"v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_refrac": 2.2, "cm": 0.02}
"""Shiu et al. (2024); the capacitance, which they do not need, makes 1 pA lead to 1 mV."""
_KNOWN: Final = {
    "efeb23fb99098e9c390f6869969b2a121a2ee92c833cfc45ecb2c1d8e1af0347": "FlyWire v783, Shiu et al. (2024)",
    "cd6707feebb17fc3cf47bc929eac08108ccfc8d154063ac816289d4c10eb1518": "C. elegans, Cook et al. (2019)",
}
"""Published tables by their SHA-256."""
MOST_GROUPS: Final = 2000
_BY: Final = ("transmitter", "class", "side", "type", "name")


@dataclass(frozen=True)
class Connectome:
    """A network and how it was made.

    Args:
        network: the network.
        sources: SHA-256 of each table, and the name of published ones.
        left_out: edges whose ends are not both in the table of neurons.
        unsigned: edges that are excitatory because their sign is not given.
    """

    network: Network
    sources: dict[str, str] = field(default_factory=dict)
    left_out: int = 0
    unsigned: int = 0


def read_connectome(
    edges: Path, neurons: Path | None = None, *, groups: tuple[str, ...] = (), unit_mv: float = 0.275,
    delay_ms: float = 1.8, junction_ns: float = 0.1,
) -> Connectome:  # fmt: skip
    """Read a connectome.

    Args:
        edges: the table of edges.
        neurons: the table of neurons; without one, the neurons are those with edges, by id.
        groups: patterns such as ``MN9*`` of the groups to name; by default all.
        unit_mv: weight of one synapse, above 0.
        delay_ms: delay of all synapses, above 0.
        junction_ns: conductance of one gap junction; 0 leaves them out. The default is that of Kunert et al.
            (2014, Phys Rev E 89:052805).

    Raises:
        NetworkError: a table or a number cannot be used; the message says why.
    """
    for name, value in (("unit_mv", unit_mv), ("delay_ms", delay_ms)):
        if not 0.0 < value < inf:
            raise NetworkError(f"{name} is {value:g}; it must be above 0")
    if not 0.0 <= junction_ns < inf:
        raise NetworkError(f"junction_ns is {junction_ns:g}; it must be 0 or more")
    known = read_neurons(neurons) if neurons else _neurons_of(edges)
    wiring = Wiring(len(known.ids))
    wiring.read(edges, known.ids)
    if not wiring.rows:
        raise NetworkError(
            f"no edge of {wiring.left_out} joins two of the {len(known.ids)} neurons", path=edges
        )
    if not len(wiring.excitatory) + len(wiring.inhibitory) + len(wiring.electrical):
        raise NetworkError(f"all {wiring.rows} edges have 0 synapses", path=edges)
    unsigned = wiring.take_signs(known.signs) if "transmitter" in known.texts else 0
    network = Network(
        {LABEL: _population(known)},
        (*wiring.projections(LABEL, unit_mv, delay_ms), *wiring.junctions(LABEL, 1e-3 * junction_ns)),
        _groups(known, groups, neurons or edges),
        remarks=known.remarks,
    )
    return Connectome(network, _sources(edges, neurons), wiring.left_out, unsigned)


def _neurons_of(path: Path) -> Neurons:
    """Return the neurons with edges, in the order of their names or ids."""
    ids, names = np.empty(0, np.int64), dict[int, str]()
    places = Places(ids)
    for part in read_edges(path):
        for end in (part.pre, part.post):
            _, is_known = places.of(end)
            if not is_known.all():
                ids = np.union1d(ids, end[~is_known])
                places = Places(ids)
        names.update(part.names)
    if not names:
        return Neurons(ids, {})
    order = sorted(ids.tolist(), key=lambda number: names[number])
    return Neurons(np.array(order, np.int64), {"name": [names[number] for number in order]})


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
