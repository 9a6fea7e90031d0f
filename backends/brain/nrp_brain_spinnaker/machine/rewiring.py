"""Synapses that form and vanish: the attempts of one tick, and their random draws.

A *site* is a core with the synapses onto a slice of a population. An attempt first chooses a target cell, one
of its places and, if that is empty, a source cell; then the row of that source is changed. As on the machine,
the next attempt chooses, and its row is copied, before the row of this one is changed and written back: two
attempts in turn on one row work on the same copy, and only the change of the second is kept.

The released software divides by the size of the grid with a factor that is half of what it should be, so a
cell's coordinates there are ``n // (2 x)`` and ``n - y (n // (2 y))``. This is kept.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_spinnaker.machine.generator import next_word
from nrp_brain_spinnaker.machine.rewired_rows import Rewired, Sites
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit

FIRST_GROUP, LAST_GROUP, PLACES, TARGETS, LOW, HIGH, FIRST_NEURON, FIRST_PLACE = range(8)
FAST, PERIOD, REPLACES, LAST_SPIKES = range(8, 12)
SITE_COLUMNS: Final = 12

SOURCES, DELAY_LOW, DELAY_HIGH, WEIGHT, FIRST_LINE, FIRST_ROW, FIRST_PART = range(7)
GRID_X, GRID_Y, PART_X, PART_Y, FORMS, N_FORMS, VANISHES_BELOW, VANISHES, THRESHOLD = range(7, 16)
GROUP_COLUMNS: Final = 16

TARGET, PLACE, GROUP, SOURCE, EXISTS, ROW = range(6)
CHOICE_COLUMNS: Final = 6
_MAX_SHORT: Final = 65535


@jit
def below(limit: int, state: IntArray) -> int:
    """Return a random whole number from 0 to ``limit - 1``; 0 for a limit of 0."""
    return int((limit * next_word(state)) >> 32)


@jit
def rewire(rewired: Rewired, tick: int) -> None:
    """Make all attempts of a tick, before its spikes."""
    for site in range(rewired.sites.settings.shape[0]):
        _attempt(rewired, site, tick, _attempts(rewired.sites, site))


@jit
def _attempts(sites: Sites, site: int) -> int:
    """Return the number of attempts of a site in this tick."""
    settings = sites.settings[site]
    if settings[FAST]:
        return int(settings[PERIOD])
    sites.waited[site] += 1
    if sites.waited[site] < settings[PERIOD]:
        return 0
    sites.waited[site] = 0
    return 1


@jit
def _attempt(rewired: Rewired, site: int, tick: int, n: int) -> None:
    """Make ``n`` attempts; each chooses before the one before it has changed its row."""
    sites, turn, waits = rewired.sites, 0, False
    while n > 0 or waits:
        buffer, follows = turn & 1, False
        while n > 0 and not follows:
            follows = _choose(sites, site, tick, sites.choice[1 - buffer])
            n -= 1
        if follows:
            _copy_row(rewired, 1 - buffer)
        if waits and _restructured(sites, site, buffer):
            _write_row(rewired, buffer)
            _note(sites, site, buffer, tick)
        turn, waits = turn + 1, follows


@jit
def _choose(sites: Sites, site: int, tick: int, choice: IntArray) -> bool:
    """Choose a target, a place and a source; False if the attempt ends here."""
    settings = sites.settings[site]
    target = below(settings[TARGETS], sites.shared[site])
    if target < settings[LOW] or target > settings[HIGH]:
        return False
    target -= settings[LOW]
    own = sites.local[site]
    place = settings[FIRST_PLACE] + target * settings[PLACES] + below(settings[PLACES], own)
    group, source = sites.place_group[place], sites.place_source[place]
    exists = source >= 0
    if not exists:
        if settings[LAST_SPIKES]:
            group, source = _last_spike(sites, site, tick)
        else:
            group, source = _any_source(sites, site)
        if group < 0:
            return False
    choice[TARGET], choice[PLACE], choice[GROUP] = target, place, group
    choice[SOURCE], choice[EXISTS] = source, exists
    choice[ROW] = sites.row_of[sites.groups[group, FIRST_ROW] + source]
    return True


@jit
def _any_source(sites: Sites, site: int) -> tuple[int, int]:
    """Return a projection and a source cell: first its core by a first number, then the cell on that core."""
    settings, own = sites.settings[site], sites.local[site]
    group = settings[FIRST_GROUP] + below(settings[LAST_GROUP] - settings[FIRST_GROUP], own)
    part, number = sites.groups[group, FIRST_PART], below(sites.groups[group, SOURCES], own)
    total = sites.part_size[part]
    while total < number:
        part += 1
        total += sites.part_size[part]
    return int(group), int(sites.part_first[part] + below(sites.part_size[part], own))


@jit
def _last_spike(sites: Sites, site: int, tick: int) -> tuple[int, int]:
    """Return projection and source cell of a spike of the previous tick; -1 for none."""
    parity = (tick - 1) & 1
    n = sites.n_heard[site, parity]
    if n == 0:
        return -1, -1
    chosen = below(n, sites.local[site])
    return int(sites.heard_group[site, parity, chosen]), int(sites.heard_source[site, parity, chosen])


@jit
def _copy_row(rewired: Rewired, buffer: int) -> None:
    rows, sites = rewired
    row = sites.choice[buffer, ROW]
    first, n = rows.first[row], sites.length[row]
    sites.copy_count[buffer] = n
    for k in range(n):
        sites.copy_line[buffer, k] = rows.line[first + k]
        sites.copy_weight[buffer, k] = rows.weight[first + k]
        sites.copy_delay[buffer, k] = rows.delay[first + k]


@jit
def _write_row(rewired: Rewired, buffer: int) -> None:
    rows, sites = rewired
    row = sites.choice[buffer, ROW]
    first, n = rows.first[row], sites.copy_count[buffer]
    sites.length[row] = n
    for k in range(n):
        rows.line[first + k] = sites.copy_line[buffer, k]
        rows.weight[first + k] = sites.copy_weight[buffer, k]
        rows.delay[first + k] = sites.copy_delay[buffer, k]


@jit
def _note(sites: Sites, site: int, buffer: int, tick: int) -> None:
    """Note a change in the form that the host records."""
    choice, k = sites.choice[buffer], sites.n_changes[0]
    sites.changes[0, k], sites.changes[1, k], sites.changes[2, k] = tick, choice[GROUP], choice[SOURCE]
    sites.changes[3, k] = sites.settings[site, LOW] + choice[TARGET]
    sites.changes[4, k] = 1 - choice[EXISTS]
    sites.n_changes[0] = k + 1


@jit
def _restructured(sites: Sites, site: int, buffer: int) -> bool:
    """Apply the choice to the copy of a row; return whether it changed."""
    choice, settings = sites.choice[buffer], sites.settings[site]
    neuron = settings[FIRST_NEURON] + choice[TARGET]
    found = _found(sites, buffer, neuron)
    if choice[EXISTS]:
        return found >= 0 and _vanished(sites, site, buffer, found)
    if sites.copy_count[buffer] >= settings[PLACES] or (found >= 0 and not settings[REPLACES]):
        return False
    return _formed(sites, site, buffer, neuron)


@jit
def _found(sites: Sites, buffer: int, neuron: int) -> int:
    """Return the first synapse of a copied row onto a neuron, or -1."""
    for k in range(sites.copy_count[buffer]):
        if sites.copy_line[buffer, k] % sites.n_neurons == neuron:
            return k
    return -1


@jit
def _vanished(sites: Sites, site: int, buffer: int, k: int) -> bool:
    choice = sites.choice[buffer]
    group, number = sites.groups[choice[GROUP]], next_word(sites.local[site])
    depressed = sites.copy_weight[buffer, k] < group[THRESHOLD]
    if number > group[VANISHES_BELOW if depressed else VANISHES]:
        return False
    last = sites.copy_count[buffer] - 1
    sites.copy_line[buffer, k] = sites.copy_line[buffer, last]
    sites.copy_weight[buffer, k] = sites.copy_weight[buffer, last]
    sites.copy_delay[buffer, k] = sites.copy_delay[buffer, last]
    sites.copy_count[buffer] = last
    sites.place_source[choice[PLACE]] = -1
    return True


@jit
def _formed(sites: Sites, site: int, buffer: int, neuron: int) -> bool:
    choice, own = sites.choice[buffer], sites.local[site]
    group = sites.groups[choice[GROUP]]
    distance = squared_distance(group, choice[SOURCE], sites.settings[site, LOW] + choice[TARGET])
    if distance >= group[N_FORMS]:
        return False
    if below(_MAX_SHORT, own) > sites.probability[group[FORMS] + distance]:
        return False
    last = sites.copy_count[buffer]
    sites.copy_line[buffer, last] = group[FIRST_LINE] + neuron
    sites.copy_weight[buffer, last] = group[WEIGHT]
    sites.copy_delay[buffer, last] = group[DELAY_LOW] + below(group[DELAY_HIGH] - group[DELAY_LOW], own)
    sites.copy_count[buffer] = last + 1
    sites.place_group[choice[PLACE]] = choice[GROUP]
    sites.place_source[choice[PLACE]] = choice[SOURCE]
    return True


@jit
def squared_distance(group: IntArray, source: int, target: int) -> int:
    """Return the squared distance of two cells on the grid as the released software computes it."""
    x, y = group[GRID_X], group[GRID_Y]
    across, along = 0, 0
    if x > 1:
        across = abs(((source * group[PART_X]) >> 32) - ((target * group[PART_X]) >> 32))
        if across > x >> 1:
            across -= x
    if y > 1:
        part = group[PART_Y]
        along = abs((source - y * ((source * part) >> 32)) - (target - y * ((target * part) >> 32)))
        if along > y >> 1:
            along -= y
    return int(across * across + along * along)
