"""Synapses that form and vanish: the attempts of one tick, and what they draw.

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
from nrp_brain_spinnaker.machine.rewired_rows import Rewired
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
    for site in range(rewired.sites.shape[0]):
        _attempt(rewired, site, tick, _attempts(rewired, site))


@jit
def _attempts(rewired: Rewired, site: int) -> int:
    """Return the number of attempts of a site in this tick."""
    settings = rewired.sites[site]
    if settings[FAST]:
        return int(settings[PERIOD])
    rewired.waited[site] += 1
    if rewired.waited[site] < settings[PERIOD]:
        return 0
    rewired.waited[site] = 0
    return 1


@jit
def _attempt(rewired: Rewired, site: int, tick: int, n: int) -> None:
    """Make ``n`` attempts; each chooses before the one before it has changed its row."""
    buffer, waits = 0, False
    while n > 0 or waits:
        follows = False
        while n > 0 and not follows:
            follows = _choose(rewired, site, tick, rewired.choice[1 - buffer])
            n -= 1
        if follows:
            _copy_row(rewired, 1 - buffer)
        if waits and _restructured(rewired, site, buffer):
            _write_row(rewired, buffer)
        buffer, waits = 1 - buffer, follows


@jit
def _choose(rewired: Rewired, site: int, tick: int, choice: IntArray) -> bool:
    """Choose a target, a place and a source; False if the attempt ends here."""
    settings = rewired.sites[site]
    target = below(settings[TARGETS], rewired.shared[site])
    if target < settings[LOW] or target > settings[HIGH]:
        return False
    target -= settings[LOW]
    own = rewired.local[site]
    place = settings[FIRST_PLACE] + target * settings[PLACES] + below(settings[PLACES], own)
    group, source = rewired.place_group[place], rewired.place_source[place]
    exists = source >= 0
    if not exists:
        if settings[LAST_SPIKES]:
            group, source = _last_spike(rewired, site, tick)
        else:
            group, source = _any_source(rewired, site)
        if group < 0:
            return False
    choice[TARGET], choice[PLACE], choice[GROUP] = target, place, group
    choice[SOURCE], choice[EXISTS] = source, exists
    choice[ROW] = rewired.row_of[rewired.groups[group, FIRST_ROW] + source]
    return True


@jit
def _any_source(rewired: Rewired, site: int) -> tuple[int, int]:
    """Return a projection and a source cell: first its core by a first number, then the cell on that core."""
    settings, own = rewired.sites[site], rewired.local[site]
    group = settings[FIRST_GROUP] + below(settings[LAST_GROUP] - settings[FIRST_GROUP], own)
    part, number = rewired.groups[group, FIRST_PART], below(rewired.groups[group, SOURCES], own)
    total = rewired.part_size[part]
    while total < number:
        part += 1
        total += rewired.part_size[part]
    return int(group), int(rewired.part_first[part] + below(rewired.part_size[part], own))


@jit
def _last_spike(rewired: Rewired, site: int, tick: int) -> tuple[int, int]:
    """Return projection and source cell of a spike of the previous tick; -1 for none."""
    parity = (tick - 1) & 1
    n = rewired.n_heard[site, parity]
    if n == 0:
        return -1, -1
    chosen = below(n, rewired.local[site])
    return int(rewired.heard_group[site, parity, chosen]), int(rewired.heard_source[site, parity, chosen])


@jit
def _copy_row(rewired: Rewired, buffer: int) -> None:
    row = rewired.choice[buffer, ROW]
    first, n = rewired.rows.first[row], rewired.length[row]
    rewired.copy_count[buffer] = n
    for k in range(n):
        rewired.copy_line[buffer, k] = rewired.rows.line[first + k]
        rewired.copy_weight[buffer, k] = rewired.rows.weight[first + k]
        rewired.copy_delay[buffer, k] = rewired.rows.delay[first + k]


@jit
def _write_row(rewired: Rewired, buffer: int) -> None:
    row = rewired.choice[buffer, ROW]
    first, n = rewired.rows.first[row], rewired.copy_count[buffer]
    rewired.length[row] = n
    for k in range(n):
        rewired.rows.line[first + k] = rewired.copy_line[buffer, k]
        rewired.rows.weight[first + k] = rewired.copy_weight[buffer, k]
        rewired.rows.delay[first + k] = rewired.copy_delay[buffer, k]


@jit
def _restructured(rewired: Rewired, site: int, buffer: int) -> bool:
    """Change the copy of a row as the choice says; return whether it changed."""
    choice, settings = rewired.choice[buffer], rewired.sites[site]
    neuron = settings[FIRST_NEURON] + choice[TARGET]
    found = _found(rewired, buffer, neuron)
    if choice[EXISTS]:
        return found >= 0 and _vanished(rewired, site, buffer, found)
    if rewired.copy_count[buffer] >= settings[PLACES] or (found >= 0 and not settings[REPLACES]):
        return False
    return _formed(rewired, site, buffer, neuron)


@jit
def _found(rewired: Rewired, buffer: int, neuron: int) -> int:
    """Return the first synapse of a copied row onto a neuron, or -1."""
    for k in range(rewired.copy_count[buffer]):
        if rewired.copy_line[buffer, k] % rewired.n_neurons == neuron:
            return k
    return -1


@jit
def _vanished(rewired: Rewired, site: int, buffer: int, k: int) -> bool:
    choice = rewired.choice[buffer]
    group, number = rewired.groups[choice[GROUP]], next_word(rewired.local[site])
    depressed = rewired.copy_weight[buffer, k] < group[THRESHOLD]
    if number > group[VANISHES_BELOW if depressed else VANISHES]:
        return False
    last = rewired.copy_count[buffer] - 1
    rewired.copy_line[buffer, k] = rewired.copy_line[buffer, last]
    rewired.copy_weight[buffer, k] = rewired.copy_weight[buffer, last]
    rewired.copy_delay[buffer, k] = rewired.copy_delay[buffer, last]
    rewired.copy_count[buffer] = last
    rewired.place_source[choice[PLACE]] = -1
    return True


@jit
def _formed(rewired: Rewired, site: int, buffer: int, neuron: int) -> bool:
    choice, own = rewired.choice[buffer], rewired.local[site]
    group = rewired.groups[choice[GROUP]]
    distance = squared_distance(group, choice[SOURCE], rewired.sites[site, LOW] + choice[TARGET])
    if distance >= group[N_FORMS]:
        return False
    if below(_MAX_SHORT, own) > rewired.probability[group[FORMS] + distance]:
        return False
    last = rewired.copy_count[buffer]
    rewired.copy_line[buffer, last] = group[FIRST_LINE] + neuron
    rewired.copy_weight[buffer, last] = group[WEIGHT]
    rewired.copy_delay[buffer, last] = group[DELAY_LOW] + below(group[DELAY_HIGH] - group[DELAY_LOW], own)
    rewired.copy_count[buffer] = last + 1
    rewired.place_group[choice[PLACE]] = choice[GROUP]
    rewired.place_source[choice[PLACE]] = choice[SOURCE]
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
