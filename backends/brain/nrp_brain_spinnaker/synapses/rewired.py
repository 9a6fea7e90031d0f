"""Load the synapses that form and vanish; :mod:`~nrp_brain_spinnaker.machine.rewiring` changes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_spinnaker.host.plastic_rows import at_rest, rules_of
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.rewired_rows import Rewired, Sites
from nrp_brain_spinnaker.machine.rewiring import CHOICE_COLUMNS, FAST, PERIOD
from nrp_brain_spinnaker.machine.stdp_rows import StdpRows
from nrp_brain_spinnaker.synapses.layout import Layout
from nrp_brain_spinnaker.synapses.rewiring_rules import Rules
from nrp_brain_spinnaker.synapses.sites import Group, Site
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.synapses import STDP
from nrp_core.errors import NetworkError

_CHANGES = 1024
"""The number of changes that are noted before the host takes them."""


def load_rewired(wires: Sequence[Wires], sites: Sequence[Site], layout: Layout) -> Rewired:
    """Return the synapses of those projections that form and vanish.

    Raises:
        CapabilityError, NetworkError: the machine cannot rewire them in this way.
    """
    groups = [group for site in sites for group in site.groups]
    own = [part for part in wires if part.projection.rewiring is not None]
    plastic = [part for part in own if part.projection.synapse_type == STDP]
    starts = np.cumsum([0, *(group.part.n_pre for group in groups)])
    row_of, order = _rows(groups)
    room = np.repeat([_room(site, group) for site in sites for group in site.groups], np.diff(starts))
    first = np.append(0, np.cumsum(room[order])) if groups else np.zeros(1, np.int64)
    rule = np.repeat([_rule(plastic, group) for group in groups], np.diff(starts)).astype(np.int64)
    pre = np.concatenate(
        [np.empty(0, np.int64), *(group.part.pre_first + np.arange(group.part.n_pre) for group in groups)]
    )
    n_rows, n_synapses = len(row_of), int(first[-1])
    rows = StdpRows(
        start=np.searchsorted(pre[order], np.arange(layout.n_sources + 1)).astype(np.int64),
        first=first.astype(np.int64), rule=rule[order],
        line=np.zeros(n_synapses, np.int32), weight=np.zeros(n_synapses, np.uint16),
        delay=np.zeros(n_synapses, np.uint16), eligibility=np.zeros(0, np.uint16), **at_rest(n_rows),
        **rules_of(plastic, layout.n, layout.grid.step_us, layout.options.semantics, {}),
    )  # fmt: skip
    rules = Rules(layout)
    for site in sites:
        rules.add(site, starts)
    length = np.zeros(n_rows, np.int64)
    places = [_fill(rows, length, row_of, starts, site, layout.n) for site in sites]
    longest = int(room.max(initial=0))
    settings = rules.arrays()
    at_once = np.where(settings["settings"][:, FAST], settings["settings"][:, PERIOD], 1)
    attempts = int(at_once.sum())
    own_sites = Sites(
        length=length, row_of=row_of, n_neurons=max(layout.n, 1),
        **settings,
        place_group=np.concatenate([np.empty(0, np.int64), *(group for group, _ in places)]),
        place_source=np.concatenate([np.empty(0, np.int64), *(source for _, source in places)]),
        waited=np.zeros(len(sites), np.int64),
        shared=np.zeros((len(sites), 4), np.int64), local=np.zeros((len(sites), 4), np.int64),
        choice=np.zeros((2, CHOICE_COLUMNS), np.int64), copy_count=np.zeros(2, np.int64),
        copy_line=np.zeros((2, longest), np.int32), copy_weight=np.zeros((2, longest), np.uint16),
        copy_delay=np.zeros((2, longest), np.uint16),
        **_hearing(sites, wires, layout),
        attempts=attempts, changes=np.zeros((5, attempts + _CHANGES), np.int64),
        n_changes=np.zeros(1, np.int64),
    )  # fmt: skip
    return Rewired(rows, own_sites)


def _rows(groups: Sequence[Group]) -> tuple[IntArray, IntArray]:
    """Return the row of each source cell of each group, and the order of these cells in the rows."""
    pre = [group.part.pre_first + np.arange(group.part.n_pre) for group in groups]
    order = np.argsort(np.concatenate([np.empty(0, np.int64), *pre]), kind="stable")
    row_of = np.empty(len(order), np.int64)
    row_of[order] = np.arange(len(order))
    return row_of, order


def _room(site: Site, group: Group) -> int:
    longest = np.bincount(group.part.projection.pre_index[group.inside]).max(initial=0)
    return max(site.rewiring.s_max, int(longest))


def _rule(plastic: Sequence[Wires], group: Group) -> int:
    return plastic.index(group.part) if group.part in plastic else -1


def _fill(
    rows: StdpRows, length: IntArray, row_of: IntArray, starts: IntArray, site: Site, n: int
) -> tuple[IntArray, IntArray]:
    """Put the first synapses of a site into their rows; return group and source at each place there."""
    s_max, size = site.rewiring.s_max, site.last - site.first
    groups, sources, targets = [], [], []
    for group in site.groups:
        part, inside = group.part, group.inside
        pre, post = part.projection.pre_index[inside], part.projection.post_index[inside]
        row = row_of[starts[group.number] + pre]
        order = np.argsort(row, kind="stable")
        place = rows.first[row[order]] + _ranks(row[order])
        rows.line[place] = part.receptor * n + part.post_first + post[order]
        rows.weight[place] = part.raw[inside][order]
        rows.delay[place] = np.broadcast_to(part.ticks, part.projection.weight.shape)[inside][order]
        np.add.at(length, row, 1)
        groups.append(np.full(len(pre), group.number))
        sources.append(pre)
        targets.append(post - site.first)
    target = np.concatenate(targets).astype(np.int64)
    filled = np.bincount(target, minlength=size)
    if filled.max(initial=0) > s_max:
        cell = int(np.argmax(filled))
        raise NetworkError(
            f"population '{site.label}': cell {site.first + cell} begins with {filled[cell]} synapses that "
            f"form and vanish; s_max allows {s_max}"
        )
    order = np.argsort(target, kind="stable")
    place = (target[order] + 1) * s_max - filled[target[order]] + _ranks(target[order])
    found = np.full((2, size * s_max), -1, np.int64)
    found[0, place] = np.concatenate(groups)[order]
    found[1, place] = np.concatenate(sources)[order]
    return found[0], found[1]


def _ranks(ascending: IntArray) -> IntArray:
    """Return the number of equal values before each of ascending ones."""
    ranks: IntArray = np.arange(len(ascending)) - np.searchsorted(ascending, ascending)
    return ranks


def _hearing(sites: Sequence[Site], wires: Sequence[Wires], layout: Layout) -> dict[str, IntArray]:
    """Return which sites hear which source cells, and room for the spikes that they remember."""
    listening = [site for site in sites if site.rewiring.partner == "LastNeuronSelection"]
    size = max((site.rewiring.spike_buffer_size for site in listening), default=0)
    ids, heard = [np.empty(0, np.int64)], [np.empty((2, 0), np.int64)]
    for number, site in enumerate(sites):
        for part in (part for part in wires if site in listening and part.projection.post == site.label):
            cells = site.sources_of(part)
            known = (
                group.number for group in site.groups if group.part.projection.pre == part.projection.pre
            )
            ids.append(part.pre_first + cells)
            heard.append(np.repeat([[number], [next(known, -1)]], len(cells), axis=1))
    order = np.argsort(np.concatenate(ids), kind="stable")
    at, as_group = np.concatenate(heard, axis=1)[:, order]
    return {
        "heard_start": np.searchsorted(np.concatenate(ids)[order], np.arange(layout.n_sources + 1)),
        "heard_site": np.ascontiguousarray(at), "heard_as": np.ascontiguousarray(as_group),
        "first_of": np.array([g.part.pre_first for site in sites for g in site.groups], np.int64),
        "heard_at": np.zeros(len(sites), np.int64), "n_heard": np.zeros((len(sites), 2), np.int64),
        "heard_group": np.zeros((len(sites), 2, size), np.int64),
        "heard_source": np.zeros((len(sites), 2, size), np.int64),
    }  # fmt: skip
