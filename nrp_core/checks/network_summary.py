"""Summaries of a network for checks: the network without its synapses and most parameters.

A network may have been built in another process, which describes it in JSON.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from nrp_core.checks.network_units import unlikely_units
from nrp_core.checks.synaptic_effects import unreached_thresholds
from nrp_core.findings import Code, Finding, Findings
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.rewiring import Neuromodulation, Rewiring


@dataclass(frozen=True, slots=True)
class NetworkSummary:
    """Facts about a network that need its synapses and parameters.

    Args:
        joined: the pairs of populations that have synapses, source first.
        unreached: for each population that cannot fire unless a device drives it, why.

        findings: implausible values, and remarks of whatever read it.
        sizes: numbers of synapses of projections that a skeleton has without any.
    """

    joined: list[tuple[str, str]] = field(default_factory=list)
    unreached: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    sizes: dict[str, int] = field(default_factory=dict)


def summary_of(network: Network) -> NetworkSummary:
    """Return the facts about a complete network."""
    findings = [*Findings(unlikely_units(network), general=Code.NRP297)]
    findings += Findings(network.remarks, general=Code.NRP308)
    others = _acting_by_voltage(network) | _excited_by_currents(network)
    unreached = {label: why for label, why in unreached_thresholds(network).items() if label not in others}
    return NetworkSummary(_joined(network), unreached, findings)


_ALL = 1000
"""Of a network with more projections, one of each kind is described."""
_LARGEST = 10_000_000
"""The largest number of stand-ins for synapses; all have the weight 1."""
_FOR_WEIGHTS = ("tau_syn_E", "tau_syn_I", "v_rest", "v_thresh", "i_offset", "e_rev_E", "e_rev_I")


def described(network: Network) -> dict[str, Any]:
    """Return a network as plain data, from which :func:`skeleton_of` and :func:`summary_from` read it."""
    summary = summary_of(network)
    kinds: dict[object, Projection] = {}
    for one in network.projections:
        kind = one.synapse_type, one.rewiring is None, one.neuromodulation is None
        kinds.setdefault(one.label if len(network.projections) <= _ALL else kind, one)
    return {
        "populations": [
            [one.label, one.size, one.cell_type, _least_leak(one), _text(one.positions_um)]
            for one in network.populations.values()
        ],
        "synapses": [
            [one.label, one.pre, one.post, one.receptor, one.synapse_type, min(one.size, _LARGEST)]
            + [law and law.data() for law in (one.rewiring, one.neuromodulation)]
            for one in kinds.values()
        ],
        "joined": summary.joined,
        "unreached": summary.unreached,
        "findings": [finding.to_dict() for finding in summary.findings],
        "views": {name: _text(ids) for name, ids in network.views.items()},
        "timestep_ms": network.timestep_ms,
    }


def _joined(network: Network) -> list[tuple[str, str]]:
    """Return the pairs of populations, source first, that have synapses or may grow some."""
    having = [one for one in network.projections if one.size or one.rewiring is not None]
    pairs = [(one.pre, one.post) for one in having]
    pairs += [(one.post, one.pre) for one in having if one.is_electrical]
    return list(dict.fromkeys(pairs))


def _acting_by_voltage(network: Network) -> set[str]:
    """Return the labels of the populations that act on others although no cell fires."""
    continuous = [one for one in network.projections if one.is_continuous]
    return {one.pre for one in continuous} | {one.post for one in continuous if one.is_electrical}


def _excited_by_currents(network: Network) -> set[str]:
    """Return the labels of the populations with cells into which currents flow at given times."""
    exciting = [one.neurons for one in network.currents if (one.amplitudes_na > 0.0).any()]
    return {network.label_of(int(cell))[0] for cells in exciting for cell in np.unique(cells)}


def summary_from(described: dict[str, Any]) -> NetworkSummary:
    """Return the facts about a network that :func:`described` wrote."""
    return NetworkSummary(
        [(pre, post) for pre, post in described["joined"]],
        described["unreached"],
        [Finding.from_dict(one) for one in described["findings"]],
        {row[0]: row[5] for row in described["synapses"]},
    )


def skeleton_of(described: dict[str, Any]) -> Network:
    """Return a network with the populations, views and synapse types of another one."""
    populations = {
        label: Population(
            label, size, cell_type, {name: np.full(size, value) for name, value in leak.items()},
            positions_um=None if positions is None else _array(positions, float).reshape(size, 3),
        )
        for label, size, cell_type, leak, positions in described["populations"]
    }  # fmt: skip
    projections = [_stand_in(*row) for row in described["synapses"]]
    views = {name: _array(ids, int) for name, ids in described["views"].items()}
    return Network(populations, tuple(projections), views, timestep_ms=described["timestep_ms"])


def _stand_in(
    label: str, pre: str, post: str, receptor: str, kind: str, _: int, rewiring: Any, neuromodulation: Any
) -> Projection:
    """Return a projection without synapses."""
    (sources, targets), (weights, delays_ms) = np.zeros((2, 0), np.int32), np.ones((2, 0))
    return Projection(
        label, pre, post, receptor, sources, targets, weights, delays_ms, synapse_type=kind,
        rewiring=rewiring and Rewiring.from_data(rewiring),
        neuromodulation=neuromodulation and Neuromodulation.from_data(neuromodulation),
    )  # fmt: skip


def with_stand_ins(network: Network, sizes: dict[str, int]) -> Network:
    """Return a network with as many synapses as projections have, all between the first cells."""
    return replace(
        network,
        projections=tuple(
            one if one.size else _filled(one, sizes.get(one.label, 0)) for one in network.projections
        ),
    )


def _filled(projection: Projection, n: int) -> Projection:
    (sources, targets), (weights, delays_ms) = np.zeros((2, n), np.int32), np.ones((2, n))
    if projection.is_continuous:
        delays_ms = np.zeros(n)
    return replace(projection, pre_index=sources, post_index=targets, weight=weights, delay_ms=delays_ms)


def _least_leak(population: Population) -> dict[str, float]:
    """Return the capacitance and time constant of the cell with the smallest leak, if cells have them.

    They include the values by which weights are judged, if these are equal in all cells.
    """
    cells = population.parameters
    if not {"cm", "tau_m"} <= cells.keys() or population.equations is not None or not population.size:
        return {}
    cell = int(np.argmin(cells["cm"] / cells["tau_m"]))
    alike = all(np.ptp(cells[name]) == 0.0 for name in ("cm", "tau_m", *_FOR_WEIGHTS) if name in cells)
    names = ("cm", "tau_m", *(_FOR_WEIGHTS if alike else ()))
    return {name: float(cells[name][cell]) for name in names if name in cells}


def _text(values: np.ndarray[Any, Any] | None) -> str | None:
    """Return the values of an array as doubles or 64-bit integers, in base64."""
    if values is None:
        return None
    return base64.b64encode(values.astype(np.result_type(values, int)).tobytes()).decode()


def _array(text: str, kind: type) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(text), dtype=kind)
