"""The random numbers of the machine: KISS with a 64-bit multiply-with-carry, and variates from them.

Marsaglia's generator of 2003 (state x, y, z, c, four words of 32 bits); exponential variates by von Neumann's
comparison method, Poisson variates by Knuth's product of uniform ones.

Poisson source populations drawn by the machine itself.

Slow sources (less than 0.01 spikes per tick) count down random intervals, fast ones draw a number of spikes
in each tick. Sources of one core share a generator. From 10 spikes per tick on the machine rounds a normal
variate; here the sum of smaller Poisson draws is used, which is exact in distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_spinnaker.hardware import POISSON_SOURCES_PER_CORE
from nrp_brain_spinnaker.machine.fixed_point import FRACTION_LARGEST, ONE, exp_accum
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core.clock import FOREVER_NS, nanoseconds
from nrp_core.network.data import Population
from nrp_core.network.grid import nearest_ns
from nrp_core.seeds import Seeds

_WORD: Final = 0xFFFFFFFF


def kiss_state(seeds: Seeds, name: str) -> IntArray:
    """Return the state of the generator with a name."""
    return valid_state([seeds.integer(f"{name}/{word}") for word in "xyzc"])


def valid_state(words: list[int]) -> IntArray:
    """Return a valid state: words from which the generator must not start are replaced."""
    x, y, z, c = words
    return np.array([x, y or 13031301, z, c % 698769068 + 1], np.int64)


@jit
def next_word(state: IntArray) -> int:
    """Return the next uniform 32-bit number."""
    x, y, z, c = state[0], state[1], state[2], state[3]
    x = (314527869 * x + 1234567) & _WORD
    y ^= (y << 5) & _WORD
    y ^= y >> 7
    y ^= (y << 22) & _WORD
    low = c - 382903 * z  # 4294584393 z + c, less 2**32 z, which would not fit
    z, c = low & _WORD, z + (low >> 32)
    state[0], state[1], state[2], state[3] = x, y, z, c
    return int((x + y + z) & _WORD)


@jit
def exponential_variate(state: IntArray) -> int:
    """Return an exponential variate of mean 1, s16.15."""
    whole = 0
    while True:
        first = word = next_word(state)
        while True:
            other = next_word(state)
            if word < other:
                return whole + (first >> 17)
            word = next_word(state)
            if word >= other:
                break
        whole += ONE


@jit
def poisson_variate(state: IntArray, exp_minus_mean: int) -> int:
    """Return a Poisson variate, given exp(-mean) as u0.32."""
    product, count = FRACTION_LARGEST, -1
    while True:
        word = next_word(state)
        product = (product * (word >> 16) + ((product * (word & 0xFFFF)) >> 16)) >> 16
        count += 1
        if product <= exp_minus_mean:
            return count


_SLOW_BELOW: Final = 328
"""0.01 spikes a tick, s16.15."""
_FAST_BELOW: Final = 10 << 15
_MEAN_OF_A_PART: Final = 2 << 15
"""Small enough for exp(-mean) to be exact to 0.01 % in s16.15."""
_INTERVAL_UNITS: Final = 1000
"""Unit of intervals: thousandths of a tick."""
_FOREVER: Final = 1 << 62

START, END, MEAN_INTERVAL, DRAWS, EXP_MINUS_MEAN = range(5)


class Sources(NamedTuple):
    """Poisson sources of a machine, core by core.

    Args:
        core_first: first source of each core, shape ``(n_cores + 1,)``.
        ids: global ids.
        settings: start and end tick, mean interval in ticks (0: fast), draws per tick and exp(-mean) of one
            draw as u0.32; shape ``(5, n)``.
        countdown: thousandths of a tick to the next spike of a slow source, shape ``(n,)``.
        generators: shape ``(n_cores, 4)``.
    """

    core_first: IntArray
    ids: IntArray
    settings: IntArray
    countdown: IntArray
    generators: IntArray


def load_sources(
    populations: Sequence[tuple[Population, IntArray]],
    step_us: int,
    generator: Callable[[str], IntArray],
) -> Sources:
    """Return the sources of populations at tick 0.

    Args:
        populations: populations with the global ids of their cells.
        step_us: length of a tick, us.
        generator: returns the state of the generator of a core, by name.
    """
    settings = [np.empty((5, 0), np.int64), *(_settings(own, step_us) for own, _ in populations)]
    generators, sizes = [], []
    for population, ids in populations:
        for first in range(0, len(ids), POISSON_SOURCES_PER_CORE):
            generators.append(generator(f"{population.label}/{first}"))
            sizes.append(min(POISSON_SOURCES_PER_CORE, len(ids) - first))
    sources = Sources(
        core_first=np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)]).astype(np.int64),
        ids=np.concatenate([np.empty(0, np.int64), *(ids for _, ids in populations)]),
        settings=np.concatenate(settings, axis=1),
        countdown=np.zeros(sum(sizes), np.int64),
        generators=np.array(generators, np.int64).reshape(-1, 4),
    )
    _draw_anew(sources, np.arange(sources.ids.size))
    return sources


def change_sources(sources: Sources, population: Population, ids: IntArray, step_us: int) -> None:
    """Update the sources of a population (global ids of all its cells) to its present parameters.

    As on the machine, slow sources draw a new interval.
    """
    places = np.flatnonzero(np.isin(sources.ids, ids))
    settings = _settings(population, step_us)
    changed = (sources.settings[:, places] != settings).any(axis=0)
    sources.settings[:, places[changed]] = settings[:, changed]
    _draw_anew(sources, places[changed])


def mean_per_tick(rate_hz: float, step_us: int) -> int:
    """Return spikes per tick, s16.15, by the truncating product of the machine."""
    seconds_a_tick = round(Fraction(step_us, 1_000_000) * 2**32)
    return (int(rate_hz * 2**16) * seconds_a_tick) >> 33


def mean_interval(rate_hz: float, step_us: int) -> int:
    """Return the mean interval of a slow source in ticks, a whole number on the machine."""
    per_second = Fraction(1_000_000, step_us)
    return int(round(per_second * 2**32) // round(Fraction(rate_hz) * 2**32))


def draw(sources: Sources, tick: int, until: int) -> IntArray:
    """Draw all ticks before ``until``; return ticks and global ids of the spikes, shape ``(2, n)``."""
    n, parts = sources.ids.size, [np.empty((3, 0), np.int64)]
    while n and tick < until:
        entries = np.empty((3, max(4 * n, 1024)), np.int64)
        tick, used = _draw_ticks(sources, tick, until, entries)
        parts.append(entries[:, :used])
    spikes = np.concatenate(parts, axis=1)
    return np.repeat(spikes[:2], spikes[2], axis=1)


def _settings(population: Population, step_us: int) -> IntArray:
    columns = (population.parameters[name].tolist() for name in ("rate", "start", "duration"))
    settings = [_setting(step_us, *given) for given in zip(*columns, strict=True)]
    return np.array(settings, np.int64).reshape(-1, 5).T


def _setting(step_us: int, rate_hz: float, start_ms: float, duration_ms: float) -> tuple[int, ...]:
    start_ns, duration_ns = nanoseconds([start_ms, duration_ms]).tolist()
    start, end = (_ticks(t_ns, step_us) for t_ns in (start_ns, min(start_ns + duration_ns, FOREVER_NS)))
    mean = mean_per_tick(rate_hz, step_us)
    if mean == 0 and round(rate_hz * 2**32) == 0:
        return start, start, 1, 0, 0
    if mean < _SLOW_BELOW:
        return start, end, mean_interval(rate_hz, step_us), 0, 0
    draws = 1 if mean < _FAST_BELOW else -(-mean // _MEAN_OF_A_PART)
    return start, end, 0, draws, exp_accum(-(mean // draws)) << 17


def _ticks(t_ns: int, step_us: int) -> int:
    return _FOREVER if t_ns == FOREVER_NS else nearest_ns(t_ns, 1000 * step_us) // (1000 * step_us)


@jit
def _interval(state: IntArray, mean: int) -> int:
    """Return a random interval in thousandths of a tick, in 32 bits."""
    return (((exponential_variate(state) * _INTERVAL_UNITS + (1 << 14)) >> 15) * mean) & 0xFFFFFFFF


@jit
def _draw_anew(sources: Sources, places: IntArray) -> None:
    """Draw the intervals of slow sources to their next spikes."""
    core = 0
    for i in places:
        while sources.core_first[core + 1] <= i:
            core += 1
        if sources.settings[MEAN_INTERVAL, i] > 0:
            sources.countdown[i] = _interval(sources.generators[core], sources.settings[MEAN_INTERVAL, i])


@jit
def _draw_ticks(sources: Sources, tick: int, until: int, entries: IntArray) -> tuple[int, int]:
    """Write tick, id and count of spikes until full; return the tick reached and the number of entries."""
    used = 0
    while tick < until and entries.shape[1] - used >= sources.ids.size:
        for core in range(sources.generators.shape[0]):
            for i in range(sources.core_first[core], sources.core_first[core + 1]):
                if not sources.settings[START, i] <= tick < sources.settings[END, i]:
                    continue
                count = _count(sources, i, sources.generators[core])
                if count > 0:
                    entries[0, used], entries[1, used], entries[2, used] = tick, sources.ids[i], count
                    used += 1
        tick += 1
    return tick, used


@jit
def _count(sources: Sources, i: int, state: IntArray) -> int:
    """Return the number of spikes of source ``i`` in this tick."""
    count, mean = 0, sources.settings[MEAN_INTERVAL, i]
    if mean == 0:
        for _ in range(sources.settings[DRAWS, i]):
            count += poisson_variate(state, sources.settings[EXP_MINUS_MEAN, i])
        return count
    while sources.countdown[i] < _INTERVAL_UNITS:
        count += 1
        sources.countdown[i] += _interval(state, mean)
    sources.countdown[i] -= _INTERVAL_UNITS
    return count
