"""Load the synapses that form and vanish; :mod:`~nrp_brain_spinnaker.machine.rewiring` changes them.

The settings of synapses that form and vanish as the host writes them for the machine.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nrp_brain_spinnaker.host.cells import Layout
from nrp_brain_spinnaker.host.stdp_rules import at_rest, rules_of
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine import rewiring as machine
from nrp_brain_spinnaker.machine.rewired_rows import Rewired, Sites
from nrp_brain_spinnaker.machine.rewiring import CHOICE_COLUMNS, FAST, PERIOD
from nrp_brain_spinnaker.machine.stdp_rows import StdpRows
from nrp_brain_spinnaker.options import cells_per_core, slices_of
from nrp_brain_spinnaker.synapses.sites import Group, Site
from nrp_core._support.arrays import IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.rewiring import Rewiring
from nrp_core.network.synapses import STDP


class Rules:
    """The tables of sites and groups, site after site.

    Args:
        layout: the network on the machine.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._sites: list[IntArray] = []
        self._groups: list[IntArray] = []
        self._parts: list[tuple[int, int]] = []
        self._part_of: dict[str, int] = {}
        self._probabilities: list[int] = []
        self._places = 0

    def add(self, site: Site, starts: IntArray) -> None:
        """Add a site; the rows of its groups begin at ``starts``."""
        own, size = site.rewiring, self._layout.network.populations[site.label].size
        row = np.zeros(machine.SITE_COLUMNS, np.int64)
        row[machine.FIRST_GROUP] = site.groups[0].number
        row[machine.LAST_GROUP] = site.groups[-1].number + 1
        row[machine.PLACES], row[machine.TARGETS] = own.s_max, size
        row[machine.LOW], row[machine.HIGH] = site.first, site.last - 1
        row[machine.FIRST_NEURON] = site.groups[0].part.post_first + site.first
        row[machine.FIRST_PLACE] = self._places
        row[machine.FAST], row[machine.PERIOD] = pace(own.f_rew, self._layout.grid.step_us)
        row[machine.REPLACES] = own.with_replacement
        row[machine.LAST_SPIKES] = own.partner == "LastNeuronSelection"
        self._places += (site.last - site.first) * own.s_max
        self._sites.append(row)
        for group in site.groups:
            self._groups.append(self._group(site, group, int(starts[group.number])))

    def _group(self, site: Site, group: Group, first_row: int) -> IntArray:
        part, own = group.part, group.part.projection.rewiring
        assert own is not None
        row = np.zeros(machine.GROUP_COLUMNS, np.int64)
        row[machine.SOURCES] = part.n_pre
        row[machine.DELAY_LOW], row[machine.DELAY_HIGH] = part.new_ticks
        row[machine.WEIGHT] = part.converted(np.array([own.initial_weight]))[0]
        row[machine.FIRST_LINE] = part.receptor * self._layout.n
        row[machine.FIRST_ROW] = first_row
        row[machine.FIRST_PART] = self._first_core_of(part.projection.pre)
        row[machine.GRID_X], row[machine.GRID_Y] = own.grid_x, own.grid_y
        row[machine.PART_X], row[machine.PART_Y] = _reciprocals(own)
        table = formation_probabilities(own, lateral=part.projection.pre == site.label)
        row[machine.FORMS], row[machine.N_FORMS] = len(self._probabilities), len(table)
        self._probabilities += table
        row[machine.VANISHES_BELOW] = int(own.prob_elim_depressed * 0xFFFFFFFF)
        row[machine.VANISHES] = int(own.prob_elim_potentiated * 0xFFFFFFFF)
        row[machine.THRESHOLD] = int(own.threshold * part.scale)
        return row

    def _first_core_of(self, label: str) -> int:
        """Return the index of the first core of a source population among all source cores."""
        if label not in self._part_of:
            population = self._layout.network.populations[label]
            self._part_of[label] = len(self._parts)
            self._parts += slices_of(population.size, cells_per_core(population, self._layout.options))
        return self._part_of[label]

    def arrays(self) -> dict[str, IntArray]:
        """Return the tables by their names on the machine."""
        parts = np.array(self._parts, np.int64).reshape(-1, 2)
        return {
            "settings": np.array(self._sites, np.int64).reshape(-1, machine.SITE_COLUMNS),
            "groups": np.array(self._groups, np.int64).reshape(-1, machine.GROUP_COLUMNS),
            "part_first": parts[:, 0].copy(),
            "part_size": parts[:, 1] - parts[:, 0],
            "probability": np.array(self._probabilities, np.int64),
        }


def pace(f_rew: float, step_us: int) -> tuple[bool, int]:
    """Return whether a tick has several attempts, and their number; else the ticks between two attempts."""
    period_s = 1.0 / f_rew
    if period_s * 1000.0 < step_us / 1000.0:
        return True, int(step_us / (period_s * 1e6))
    return False, int(period_s * 1e6 / step_us)


def _reciprocals(own: Rewiring) -> tuple[int, int]:
    """Return the factors for the division by the grid, s0.31; 0 for a grid of one row."""
    x, y = (round(2**31 / n) if n > 1 else 0 for n in (own.grid_x, own.grid_y))
    return x, y


def formation_probabilities(own: Rewiring, *, lateral: bool) -> list[int]:
    """Return the probability of forming (of 65535) by squared distance, up to the first that is 0.

    An even number of them is stored, so that a 0 may follow.
    """
    peak = own.p_form_lateral if lateral else own.p_form_forward
    sigma = own.sigma_form_lateral if lateral else own.sigma_form_forward
    squared = np.arange(_largest_squared_distance(own.grid_x, own.grid_y) + 1)
    table = (peak * np.exp(-squared / (2 * sigma**2)) * 65535).astype(np.uint16)
    found: list[int] = table[table > 0].tolist()
    return [*found, 0] if len(found) % 2 else found


def _largest_squared_distance(grid_x: int, grid_y: int) -> float:
    """Return the largest squared distance that the host finds, in floating point as there.

    It looks at cells 0 .. x**2 - 1 on one side and 0 .. y**2 - 1 on the other.
    """
    if grid_x == grid_y:
        half = grid_x // 2
        return float(np.sqrt(2.0 * half**2) ** 2)
    one_column = grid_x == 1  # the host ignores columns then
    cells, places, largest = np.arange(grid_y if one_column else grid_y**2), np.arange(grid_y), 0
    for column in range(grid_x):  # for all cells at once the host's table does not fit into memory
        across = 0 if one_column else _wrapped(column - cells // grid_x, grid_x)
        own = np.unique((column * grid_x + np.arange(grid_x)) % grid_y)
        farthest = (_wrapped(own[:, None] - places, grid_y) ** 2).max(axis=0)
        largest = max(largest, int((across**2 + farthest[cells % grid_y]).max()))
    return float(np.sqrt(largest) ** 2)


def _wrapped(difference: IntArray, size: int) -> IntArray:
    distance = abs(difference)
    return np.where(distance > 0.5 * size, distance - size, distance)


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
    """Return the source cells whose spikes each site receives, and room to store the spikes."""
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
