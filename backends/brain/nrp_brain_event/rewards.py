"""The rewards of a network: from spikes and from outside to the dopamine that its synapses follow."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.dopamine import Dopamine, Jump, Modulator, Room, add, begin, forget, kernel, levels
from nrp_brain_event.engine import chain_free, doubled
from nrp_brain_event.equation_synapses import follow_modulator
from nrp_brain_event.handles import Shelf
from nrp_brain_event.records import Array, Slow
from nrp_brain_event.synapse_laws import NEUROMODULATED, RULES
from nrp_core._support.arrays import BoolArray, FloatArray, IntArray
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Network, Projection
from nrp_core.network.grid import Grid
from nrp_core.network.modulations import follows_dopamine, modulations_of
from nrp_core.network.rewiring import Neuromodulation

Places = Callable[[], Mapping[str, Array]]
_UNREACHED: Final = 2.0**80
"""A limit that no eligibility reaches."""
_TIDY_NS: Final = 1_000_000_000
"""Interval between two looks at lists that have become long, a fixed one: runs may be split anywhere."""


def wired(network: Network) -> Network:
    """Return a network without rewarding synapses, which do not transmit spikes."""
    others = tuple(one for one in network.projections if one.neuromodulation is None)
    return network if len(others) == len(network.projections) else replace(network, projections=others)


def rewards_of(
    network: Network, row_of: IntArray, times: Grid | None, tables: Mapping[str, Array], places: Places
) -> tuple[Rewards | None, dict[str, Array]]:
    """Return the rewards of a network and the tables that change for them, or None and no table.

    Args:
        network: the network.
        row_of: row of each cell by global id.
        times: the grid of the engine, or None if its times are exact.
        tables: the plastic synapses and rules of the engine, which change.
        places: returns the rows of the plastic synapses of each projection.
    """
    _require_dopamine(network)
    if all(one.neuromodulation is None for one in network.projections):
        return None, {}
    rewards = Rewards(network, row_of, times)
    rewards.modulate(tables["plastic"], tables["rules"], places())
    return rewards, {"slow": np.zeros(len(tables["plastic"]), Slow.dtype())}


def _require_dopamine(network: Network) -> None:
    """Refuse equations whose weights follow a dopamine without a source, or a separate one for each cell.

    Raises:
        CapabilityError: the network has such synapses.
    """
    of = {one.post: one.neuromodulation for one in network.projections if one.neuromodulation}
    for one in network.projections:
        if one.equations is None or not one.equations.model.eligibility:
            continue
        if one.post not in of or not of[one.post].shared:
            raise CapabilityError(
                f"projection '{one.label}': its weights follow the dopamine that the cells of '{one.post}' "
                f"share, and no projection of Neuromodulation onto '{one.post}' with shared=True brings it"
            )


def require_weights(projection: Projection) -> None:
    """Refuse to change the meaning of rewards while a network runs.

    Raises:
        CapabilityError: the synapses reward.
    """
    if projection.neuromodulation is not None:
        raise CapabilityError(
            f"projection '{projection.label}': the dopamine that a spike brings cannot change while the "
            "network runs"
        )


class _Synapses(NamedTuple):
    """The synapses that reward, in the order of their sources.

    Args:
        first: the first synapse of each neuron (global id), and the number of all.
        number: the modulator.
        amount: the change of dopamine by a spike.
        delay: ms, or steps on a grid.
    """

    first: IntArray
    number: IntArray
    amount: FloatArray
    delay: FloatArray


class _Pending(NamedTuple):
    """Future changes of dopamine."""

    times: FloatArray
    numbers: IntArray
    amounts: FloatArray

    def only(self, chosen: BoolArray | IntArray) -> _Pending:
        """Return some of them."""
        return _Pending(self.times[chosen], self.numbers[chosen], self.amounts[chosen])


_NOTHING: Final = _Pending(np.empty(0), np.empty(0, np.int64), np.empty(0))


@dataclass(frozen=True, slots=True)
class Tables:
    """The parts of an engine that rewards need."""

    cells: Array
    plastic: Array
    slow: Array
    rules: Array
    events: Array


class Rewards:
    """The dopamine of a network that runs.

    Args:
        network: the network.
        row_of: row of each cell by global id.
        times: the grid of the engine, or None if its times are exact.
    """

    def __init__(self, network: Network, row_of: IntArray, times: Grid | None) -> None:
        self._network, self._row_of, self._times = network, row_of, times
        self._modulations = modulations_of(network)
        of_row, modulators = _modulators(network, self._modulations, row_of)
        jumps, room = np.zeros(4 * len(modulators), Jump.dtype()), np.zeros(1, Room.dtype())
        self._shelf = Shelf(Dopamine(modulators, jumps, room, of_row))
        self._synapses = _synapses(network, of_row[row_of], times)
        sources = {one.pre for one in network.projections if one.neuromodulation is not None}
        spiking = [label for label in sources if not network.populations[label].is_source]
        self._window_ns = self._shortest_ns(spiking) if spiking else 0
        self.begin()

    def _shortest_ns(self, labels: list[str]) -> int:
        """Return the shortest delay from neurons, whose spikes cannot be predicted."""
        shortest = inf
        for label in labels:
            ids = self._network.ids_of(label)
            own = self._synapses.delay[self._synapses.first[ids[0]] : self._synapses.first[ids[-1] + 1]]
            shortest = min(shortest, own.min(initial=inf))
        if shortest == inf:
            return 0
        shortest_ns = int(shortest * (NS_PER_MS if self._times is None else self._times.step_ns))
        if shortest_ns < 1:
            raise NetworkError("rewards from neurons need a delay of at least 1e-06 ms")
        return shortest_ns

    def begin(self) -> None:
        """Return to time 0."""
        self._pending = _NOTHING
        self.n_heard = 0
        begin(self._shelf.arrays)

    def modulate(self, plastic: Array, rules: Array, places: Mapping[str, Array]) -> None:
        """Let the rules of synapses onto rewarded cells wait for rewards.

        Args:
            plastic: the records of plastic synapses.
            rules: their rules, which change.
            places: the rows of the synapses of each projection.
        """
        for projection in self._network.projections:
            if not self.has(projection):
                continue
            modulation = self._modulations[projection.post]
            for row in np.unique(plastic["rule"][places[projection.label]]).tolist():
                rule = rules[row]
                rule["law"], rule["dopamine"] = RULES.index(NEUROMODULATED), self._shelf.number
                if projection.equations is not None:
                    number = self._numbers(projection.post)[0]
                    follow_modulator(rule, projection, number, modulation.tau_c)
                    continue
                rule["own"] = kernel()
                if not modulation.eligibility_limits:
                    for name in ("A_plus", "A_minus"):
                        rule[name] = rule[name] * rule["w_max"] / _UNREACHED
                    rule["w_min"], rule["w_max"] = -_UNREACHED, _UNREACHED

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add the future changes by spikes of neurons (global ids)."""
        first, number, amount, delay = self._synapses
        counts = first[neurons + 1] - first[neurons]
        if not counts.any():
            return
        spikes = np.repeat(np.arange(len(neurons)), counts)
        own = np.arange(len(spikes)) - np.repeat(np.cumsum(counts) - counts, counts) + first[neurons][spikes]
        times = times_ms[spikes]
        if self._times is None:
            times = times + delay[own]
        else:
            times = self._times.time_ms(self._times.first_at(times) + delay[own].astype(np.int64))
        old = self._pending
        self._pending = _Pending(
            np.concatenate([old.times, times]), np.concatenate([old.numbers, number[own]]),
            np.concatenate([old.amounts, amount[own]]),
        )  # fmt: skip

    def reward(self, population: str, amount: float, now_ms: float) -> None:
        """Add to the dopamine of all cells of a population now."""
        numbers = self._numbers(population)
        self._add(numbers, np.full(len(numbers), now_ms), np.full(len(numbers), amount))

    def hold(self, population: str, value: float, now_ms: float) -> None:
        """Set the value that is held for all cells of a population, from now on."""
        numbers = self._numbers(population)
        last = self._shelf.arrays.modulators["last"][numbers]
        if (self._shelf.arrays.jumps["held"][last] == value).all():
            return
        self._add(numbers, np.full(len(numbers), now_ms), np.zeros(len(numbers)))
        modulators, jumps, *_ = self._shelf.arrays
        jumps["held"][modulators["last"][numbers]] = value

    def _numbers(self, population: str) -> IntArray:
        """Return the modulators of the cells of a population."""
        found: IntArray = np.unique(self._shelf.arrays.of_row[self._row_of[self._network.ids_of(population)]])
        return found

    def run(
        self, now_ns: int, until_ns: int, run: Callable[[int], None],
        new_spikes: Callable[[int], tuple[IntArray, FloatArray]], tables: Callable[[], Tables],
    ) -> None:  # fmt: skip
        """Run an engine whose dopamine is known in advance.

        Args:
            now_ns: its time.
            until_ns: where to stop.
            run: runs to a time.
            new_spikes: returns the spikes that the engine has stored, from a number on.
            tables: returns its synapses.
        """
        for stop_ns in self._stops(now_ns, until_ns):
            self._push(milliseconds(stop_ns))
            run(stop_ns)
            if self._window_ns:
                neurons, times_ms = new_spikes(self.n_heard)
                self.n_heard += len(neurons)
                self.fire(neurons, times_ms)
            if stop_ns % _TIDY_NS == 0:
                self._tidy(milliseconds(stop_ns), tables())

    def _stops(self, now_ns: int, until_ns: int) -> Iterator[int]:
        while now_ns < until_ns:
            stop_ns = min(until_ns, now_ns - now_ns % _TIDY_NS + _TIDY_NS)
            now_ns = min(stop_ns, now_ns + self._window_ns) if self._window_ns else stop_ns
            yield now_ns

    def _push(self, until_ms: float) -> None:
        """Apply the changes of dopamine up to a time."""
        due = self._pending.times <= until_ms
        if not due.any():
            return
        now, self._pending = self._pending.only(due), self._pending.only(~due)
        now = now.only(np.lexsort((now.amounts, now.numbers, now.times)))
        self._add(now.numbers, now.times, now.amounts)

    def _add(self, numbers: IntArray, times: FloatArray, amounts: FloatArray) -> None:
        while self._shelf.arrays.room["n_free"][0] < len(numbers):
            jumps, room = self._shelf.arrays.jumps, self._shelf.arrays.room
            larger = doubled(jumps)
            chain_free(room, larger, len(jumps))
            self._shelf.put(self._shelf.arrays._replace(jumps=larger))
        add(self._shelf.places, numbers, times, amounts)

    def _tidy(self, now_ms: float, of: Tables) -> None:
        """Drop changes that all synapses have processed, once there are many."""
        needed = np.empty(len(self._shelf.arrays.modulators))
        forget(
            now_ms, of.cells, of.plastic, of.slow, of.rules, of.events, self._shelf.places, needed
        )  # fmt: skip

    def require_same_decay(
        self, projection: Projection, values: Mapping[str, FloatArray], rules: Array
    ) -> None:
        """Refuse parameters of equations with which an eligibility does not decay with ``tau_c``.

        Raises:
            CapabilityError: it decays with another time constant.
        """
        if self.has(projection):
            changed = replace(projection, synapse_parameters={**projection.synapse_parameters, **values})
            tau_c = self._modulations[projection.post].tau_c
            follow_modulator(rules[:1].copy(), changed, 0, tau_c)

    def has(self, projection: Projection) -> bool:
        """Return whether the synapses of a projection wait for rewards."""
        return projection.post in self._modulations and follows_dopamine(projection)

    def dopamine(self, projection: Projection, now_ms: float) -> FloatArray:
        """Return the dopamine of the target of each synapse."""
        rows = self._row_of[self._network.offsets[projection.post] + projection.post_index]
        found = np.empty(len(rows))
        levels(self._shelf.places, rows, now_ms, found)
        return found

    def save(self) -> tuple[object, ...]:
        """Return the state."""
        modulators, jumps, room, _ = self._shelf.arrays
        return modulators.tobytes(), jumps.tobytes(), room.tobytes(), *self._pending

    def restore(self, saved: tuple[object, ...]) -> None:
        """Return to a state from :meth:`save`."""
        now = self._shelf.arrays
        state, pending = saved[:3], saved[3:]
        modulators, jumps, room = (
            np.frombuffer(part, array.dtype).copy()  # type: ignore[call-overload]
            for part, array in zip(state, now[:3], strict=True)
        )
        self._shelf.put(Dopamine(modulators, jumps, room, now.of_row))
        self._pending, self.n_heard = _Pending(*pending), 0  # type: ignore[arg-type]


def _modulators(
    network: Network, modulations: Mapping[str, Neuromodulation], row_of: IntArray
) -> tuple[IntArray, Array]:
    """Return the modulator of the cell in each row or -1, and the modulators."""
    of_row = np.full(int(row_of.max(initial=-1)) + 1, -1)
    tables = [np.zeros(0, Modulator.dtype())]
    done = 0
    for label, one in modulations.items():
        rows = row_of[network.ids_of(label)]
        table = np.zeros(1 if one.shared else len(rows), Modulator.dtype())
        for name in ("tau_c", "tau_d", "baseline", "w_min", "w_max", "shared"):
            table[name] = getattr(one, name)
        table["tau_both"] = 1.0 / (1.0 / one.tau_c + 1.0 / one.tau_d)
        of_row[rows] = done + (0 if one.shared else np.arange(len(rows)))
        done += len(table)
        tables.append(table)
    return of_row, np.concatenate(tables).view(Modulator.dtype())


def _synapses(network: Network, of_id: IntArray, times: Grid | None) -> _Synapses:
    """Return the rewarding synapses; synapses of one source and delay onto shared dopamine are merged.

    Args:
        network: the network.
        of_id: the modulator of each neuron by global id.
        times: the grid, or None.
    """
    pre, number, amount, delay = ([np.empty(0, kind)] for kind in (np.int64, np.int64, float, float))
    for one in network.projections:
        if one.neuromodulation is None:
            continue
        sign = 1.0 if one.receptor == "reward" else -1.0
        cells = network.populations[one.post].size if one.neuromodulation.shared else 1
        pre.append(network.offsets[one.pre] + one.pre_index.astype(np.int64))
        number.append(of_id[network.offsets[one.post] + one.post_index])
        amount.append(sign * one.weight / cells)
        delay.append(one.delay_ms if times is None else times.delays(one.delay_ms).astype(float))
    keys = np.column_stack([np.concatenate(pre), np.concatenate(number), np.concatenate(delay)])
    kept, of = np.unique(keys, axis=0, return_inverse=True)
    sums = np.bincount(of.reshape(-1), np.concatenate(amount), len(kept)).astype(float)
    first = np.searchsorted(kept[:, 0], np.arange(network.size + 1))
    return _Synapses(first, kept[:, 1].astype(np.int64), sums, kept[:, 2].copy())
