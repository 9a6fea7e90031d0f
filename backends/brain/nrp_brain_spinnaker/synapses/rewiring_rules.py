"""The settings of synapses that form and vanish as the host writes them for the machine."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.hints import cells_per_core, slices_of
from nrp_brain_spinnaker.machine import rewiring as machine
from nrp_brain_spinnaker.synapses.layout import Layout
from nrp_brain_spinnaker.synapses.sites import Group, Site
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.rewiring import Rewiring


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
    """Return whether there are several attempts a tick, and their number, or else the ticks between two."""
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
    one_column = grid_x == 1  # the host does not look at columns then
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
