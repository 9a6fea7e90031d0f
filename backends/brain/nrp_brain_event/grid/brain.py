"""A network on a time grid.

Spikes in transit, synapse by synapse: weights can be read, and changed for later spikes only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np

from nrp_brain_event.cell_types import TIME_CONSTANTS, diverged, require_variable
from nrp_brain_event.connections import begin_plastic, numbers_of, places_of_plastic
from nrp_brain_event.engine import StoredSpikes, doubled
from nrp_brain_event.equation_synapses import (
    change_rules,
    change_shares,
    keep_addresses,
    keep_kernels,
    share_state,
)
from nrp_brain_event.grid.advance import set_currents
from nrp_brain_event.grid.couplings import couplings_of, with_responses
from nrp_brain_event.grid.equations.blocks import (
    begin_cell_streams,
    places_of,
    require_input,
    require_receptor,
    with_code,
)
from nrp_brain_event.grid.inputs import fire, inject, joined, sort, waiting, with_waiting
from nrp_brain_event.grid.loader import build_grid, change_cells, changing, enlarged, labels_from, offsets_of
from nrp_brain_event.grid.on_demand import with_kernels
from nrp_brain_event.grid.parts import Held, Threads, advance
from nrp_brain_event.grid.poisson import drawable
from nrp_brain_event.grid.readout import load_probes, lost_row, no_probes, read
from nrp_brain_event.grid.records import PLASTIC, SHORT_TERM, TAKE_SAMPLES, WITHOUT_COPY, Grid, Input
from nrp_brain_event.grid.synapses import send_all, transmitted
from nrp_brain_event.grid.tables import load_tables
from nrp_brain_event.grid.weights import Given, Layout, find_layout, written
from nrp_brain_event.handles import handle, with_arrays
from nrp_brain_event.live import PlasticState, freeze, require_slow
from nrp_brain_event.options import EventOptions
from nrp_brain_event.random_numbers import begin_streams
from nrp_brain_event.records import DIVERGED, Array
from nrp_brain_event.rewards import Tables, require_weights, rewards_of, wired
from nrp_brain_event.synapse_kernels import SIMULTANEOUS, bring_up_to, released_share, synapses_at
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core._support.signals import end_if_asked
from nrp_core.brain.devices.sinks import Trace
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.errors import CapabilityError
from nrp_core.findings import Code
from nrp_core.network.changes import DOPAMINE, ParameterChange
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.drawing import extremes, in_parts
from nrp_core.network.grid import Grid as TimeGrid
from nrp_core.network.indices import stored_form
from nrp_core.network.limits import distinct


def unfolded(grid: Grid) -> Grid:
    """Return the grid with an empty calendar, and all inputs in transit among its arrivals.

    Spikes that have passed their synapses keep their weights.
    """
    grid = _sent(grid)
    sources, ahead = waiting(grid)
    arrivals = joined(ahead, _released_ahead(grid))
    grid.slots[:] = -1
    n = len(grid.entry_after)
    grid.entry_after[:] = np.arange(1, n + 1)
    grid.entry_after[-1] = -1
    grid.clock["free"], grid.clock["n_free"] = 0, n
    sort(arrivals, len(arrivals))
    passed, arrivals_ms = _passed(grid, arrivals)
    weights = np.empty(len(passed))
    _transmit(grid, arrivals["synapse"][passed], arrivals_ms, weights)
    arrivals["weight"][passed], arrivals["synapse"][passed] = weights, -1
    return with_waiting(grid, sources, arrivals)


def plastic_now(grid: Grid, rows: Array) -> PlasticState:
    """Return the plastic synapses in these rows after all spikes until now.

    Because of the axonal and dendritic parts of the delay, synapses process a spike before it arrives.
    """
    seen = _ahead_of(grid)
    arrivals = joined(waiting(seen)[1], _synapses_ahead(seen))
    sort(arrivals, len(arrivals))
    passed, arrivals_ms = _passed(seen, arrivals)
    synapses = arrivals["synapse"][passed]
    order = np.argsort(synapses, kind="stable")
    found = PlasticState.room(grid.plastic, grid.slow, grid.rules, rows)
    synapses_at(
        _now(grid), grid.memories, grid.plastic, grid.slow, grid.rules, grid.stored, synapses[order],
        arrivals_ms[order], rows, found.plastic, found.slow,
    )  # fmt: skip
    return found


def _ahead_of(grid: Grid) -> Grid:
    """Return a grid whose calendar has all spikes, without a change of this one."""
    return _sent(grid._replace(**{name: array.copy() for name, array in _calendar(grid).items()}))


def shares_now(grid: Grid) -> Array:
    """Return the synapses that transmit a share after all spikes that were emitted until now.

    Their times are those of arrivals.
    """
    found, rows = _through_synapses(_ahead_of(grid))
    dynamic, table = np.flatnonzero(rows >= 0), grid.short_term.copy()
    _released(table, rows[dynamic], found["step"][dynamic] * grid.clock["h"][0])
    return table


def _calendar(grid: Grid) -> dict[str, Array]:
    """Return the parts of the grid that change when queued spikes are sent."""
    return {name: getattr(grid, name) for name in ("clock", "slots", "entry_segment", "entry_after")}


def hear_all(grid: Grid) -> None:
    """Process the spikes of targets up to now in plastic synapses."""
    none = np.empty(0, np.int64)
    bring_up_to(_now(grid), grid.memories, grid.plastic, grid.slow, grid.rules, grid.stored, none)


def _sent(grid: Grid) -> Grid:
    """Return the grid with all spikes in the calendar."""
    while grid.clock["n_free"][0] < grid.clock["n_out"][0]:
        grid = enlarged(grid)
    _send_all(grid)
    return grid


def _now(grid: Grid) -> float:
    return float(grid.clock["step"][0] * grid.clock["h"][0])


def _released_ahead(grid: Grid) -> Array:
    """Return the inputs through each synapse of the spikes in the calendar, with the shares released."""
    found, rows = _through_synapses(grid)
    dynamic = np.flatnonzero(rows >= 0)
    times_ms = found["step"][dynamic] * grid.clock["h"][0]
    found["weight"][dynamic] *= _released(grid.short_term, rows[dynamic], times_ms)
    return found


def _synapses_ahead(grid: Grid) -> Array:
    """Return the inputs through each synapse of the spikes in the calendar; nothing changes."""
    return _through_synapses(grid)[0]


def _through_synapses(grid: Grid) -> tuple[Array, IntArray]:
    """Return the inputs through each synapse, and its row in ``short_term`` or -1."""
    n = _count_ahead(grid)
    steps, segments = np.empty(n, np.int64), np.empty(n, np.int64)
    _list_ahead(grid, steps, segments)
    order = np.argsort(steps, kind="stable")
    steps, segments = steps[order], segments[order]
    passed = grid.segments[segments]
    lengths = passed["length"].astype(np.int64)
    begins = passed["start"] - (np.cumsum(lengths) - lengths)
    synapses = np.repeat(begins, lengths) + np.arange(lengths.sum())
    steps, tables = np.repeat(steps, lengths), grid.tables[np.repeat(passed["table"], lengths)]
    found = np.zeros(len(steps), Input.dtype())
    found["step"], found["target"] = steps, tables["line"] + grid.targets[synapses]
    own, of = tables["own"] > 0, tables["dynamic"] == PLASTIC
    found["weight"] = tables["weight"]
    found["weight"][own] = grid.weights[synapses[own] + tables["weights"][own]]
    found["synapse"] = -1
    found["synapse"][of] = grid.plastic_rows[synapses[of] + tables["dynamics"][of]]
    return found, np.where(tables["dynamic"] == SHORT_TERM, synapses + tables["dynamics"], -1)


def _passed(grid: Grid, inputs: Array) -> tuple[IntArray, FloatArray]:
    """Return the inputs that have passed their plastic synapses by now, and when they will arrive, ms.

    They have the order in which they passed.
    """
    plastic = np.flatnonzero(inputs["synapse"] >= 0)
    arrivals_ms = inputs["step"][plastic] * grid.clock["h"][0]
    heard = arrivals_ms - grid.plastic["dendritic_delay"][inputs["synapse"][plastic]]
    chosen = np.flatnonzero(heard <= _now(grid) + SIMULTANEOUS)
    chosen = chosen[np.argsort(heard[chosen], kind="stable")]
    return plastic[chosen], arrivals_ms[chosen]


@jit
def _send_all(grid: Grid) -> None:
    send_all(grid.clock[0], grid)


@jit
def _count_ahead(grid: Grid) -> int:
    n = 0
    for slot in range(len(grid.slots)):
        entry = grid.slots[slot]
        while entry >= 0:
            segment = grid.entry_segment[entry]
            n += 1
            while not grid.segments[segment].last:
                segment += 1
                n += 1
            entry = grid.entry_after[entry]
    return n


@jit
def _list_ahead(grid: Grid, steps: IntArray, segments: IntArray) -> None:
    now, n_slots, n = grid.clock[0].step, len(grid.slots), 0
    for ahead in range(1, n_slots + 1):
        entry = grid.slots[(now + ahead) & (n_slots - 1)]
        while entry >= 0:
            segment, step = grid.entry_segment[entry], now + ahead
            steps[n], segments[n] = step, segment
            n += 1
            while not grid.segments[segment].last:
                segment += 1
                step += grid.segments[segment].gap
                steps[n], segments[n] = step, segment
                n += 1
            entry = grid.entry_after[entry]


@jit
def _released(short_term: Array, rows: IntArray, times: FloatArray) -> FloatArray:
    shares = np.empty(len(rows))
    for k in range(len(rows)):
        shares[k] = released_share(short_term[rows[k]], times[k])
    return shares


@jit
def _transmit(grid: Grid, rows: IntArray, times: FloatArray, weights: FloatArray) -> None:
    for k in range(len(rows)):
        weights[k] = transmitted(grid, rows[k], times[k])


_PATIENCE_NS: Final = 20_000_000
_PIECE: Final = 1 << 22
"""Number of updates of neurons and of arrivals after which compiled code returns: less than 1 s."""
_SYNAPSES_PER_ARRIVAL: Final = 64
"""Synapses for which one arrival is expected in a step, at the most."""
_EXACT_MS: Final = 1e-6
_WORTH_SHARING: Final = 50_000
"""Minimum number of neuron updates between two exchanges of spikes, which take about 0.1 ms."""


class GridBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    _grid: Grid
    _held: Held
    """The same."""
    _cells: Array
    """``Cell`` in each row, for its parameters."""
    _given: Given
    """Changed weights of projections."""
    _layout: tuple[object, Layout | None] = (None, None)
    """Where weights are in the tables, and for which weights that was found."""

    def __init__(
        self,
        network: Network,
        seed: int,
        capabilities: BrainCapabilities,
        options: EventOptions,
        resolution_ns: int,
    ) -> None:
        self._options = options
        self._wired = wired(network)
        rewarding = {one.pre for one in network.projections if one.neuromodulation is not None}
        self._drawn = drawable(network) - rewarding if options.poisson == "grid" else frozenset()
        self._times = TimeGrid(resolution_ns, "the grid")
        self._patience = -(-_PATIENCE_NS // resolution_ns)
        """The steps after which a lazy grid judges its cost."""
        identity = f"event:{options.model_dump_json(exclude={'threads'})}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        grid, self._initial_cells, self._row_of = build_grid(
            self._wired, options.tolerance, self._times, self._drawn
        )
        self._rewards, more = rewards_of(
            network, self._row_of, self._times, grid._asdict(), lambda: self._plastic_places
        )
        self._initial = grid._replace(**more)
        self._warn_of_rounding()
        self._threads = self._as_many(options.threads)
        load = len(grid.drive) + len(grid.targets) // _SYNAPSES_PER_ARRIVAL
        self._piece = self._patience if self._threads else max(1, min(self._patience, _PIECE // max(load, 1)))
        """The steps between two returns from compiled code, because signals are handled only there."""
        self._start()

    def _do_run_until(self, t_ns: int) -> None:
        if self._rewards is None:
            self._run_to(t_ns)
        else:
            since_ns = self._step.item(0) * self._times.step_ns
            self._rewards.run(
                since_ns, t_ns, self._run_to, lambda n: self._stored.since(n), self._synapses
            )  # fmt: skip

    def _synapses(self) -> Tables:
        now = self._grid
        return Tables(now.memories, now.plastic, now.slow, now.rules, now.stored)

    def _run_to(self, t_ns: int) -> None:
        until, stop = self._times.number_of(t_ns), self._step.item(0)
        patience = self._patience
        if len(self._grid.noise):
            self._listen_to_noise()
        while stop < until:
            end_if_asked()
            stop = min(stop + self._piece, stop - stop % patience + patience, until)
            if self._step_to(stop) == DIVERGED:
                raise diverged(self.network, self._failed(), t_ns)

    def _step_to(self, step: int) -> int:
        """Advance to a step; return ``DONE`` or ``DIVERGED``."""
        move = self._threads.advance if self._threads else advance
        held, status = move(self._held, step)
        if held is not self._held:
            self._take(held)
        return status

    def _failed(self) -> int:
        """Return the global id of a neuron that cannot be integrated, or whose voltage is not a number."""
        failed: int = self._grid.clock["failed"].item(0)
        return failed if failed >= 0 else int(self._grid.ids[lost_row(self._grid)])

    def _do_run_recording(self, t_ns: int, traces: Sequence[Trace], samples: FloatArray) -> None:
        for trace in traces:
            require_variable(self.network, trace.variable, trace.neurons)
        if self._rewards is not None:
            super()._do_run_recording(t_ns, traces, samples)
            return
        probes = load_probes(self._grid, self.network, traces, samples, self._row_of, self._times)
        codes = with_kernels(self._grid.codes, TAKE_SAMPLES)
        self._take(with_arrays(self._held, **probes, codes=codes))
        self._do_run_until(t_ns)
        self._take(with_arrays(self._held, **no_probes()))

    def _take(self, held: Held) -> None:
        """Continue with a grid."""
        self._held, self._grid = held, held.arrays
        clock = self._grid.clock
        self._step, self._stored = clock["step"], StoredSpikes(clock, self._grid.spikes)

    def _do_take_spikes(self) -> Spikes:
        if self._rewards is not None:
            self._rewards.n_heard = 0
        return self._stored.take()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        if self._rewards is not None:
            self._rewards.fire(neurons, times_ms)
        done = 0
        while (done := fire(self._held.places, neurons, times_ms, done)) < len(neurons):
            self._take(handle(self._grid._replace(sources=doubled(self._grid.sources))))

    def _do_inject(self, events: SynapticEvents) -> None:
        if len(self._grid.blocks):
            require_receptor(self.network, events)
        neurons, times_ms, weights = events.neurons, events.times_ms, events.weights
        inhibitory, done = int(events.receptor == "inhibitory"), 0
        while (done := inject(self._held.places, neurons, times_ms, weights, inhibitory, done)) < len(
            neurons
        ):
            self._take(handle(self._grid._replace(arrivals=doubled(self._grid.arrivals))))

    def _do_set_current(self, currents_na: FloatArray) -> None:
        require_input(self.network, currents_na)
        total = offsets_of(self._grid, self._cells) + currents_na[self._grid.ids]
        self._grid.coupled["steady"] = total[self._grid.coupled["row"]]
        if not set_currents(self._held.places, total):
            raise diverged(self.network, int(self._grid.clock["failed"][0]), self.now_ns)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        require_variable(self.network, variable, neurons)
        rows = self._row_of[neurons]
        places, sizes = places_of(self._grid, self.network, rows, variable)
        own = places >= 0
        values = np.empty(len(rows))
        values[own] = self._grid.values[places[own]] / sizes[own]
        if not own.all():
            values[~own] = read(self._grid, rows[~own], variable)
        return values

    def _do_set_parameters(self, change: ParameterChange) -> None:
        if change.label in self._drawn:
            raise CapabilityError(
                f"population '{change.label}' is drawn by the grid in counts and cannot change; leave out "
                "`poisson: grid`"
            )
        grid, self._cells = change_cells(self._grid, self._cells, self.network, change, self._row_of)
        self._take(handle(with_responses(grid, self._cells, self.network, self._row_of)))
        if change.values.keys() & TIME_CONSTANTS.keys() and len(self._grid.short_term):
            self._grid.short_term["tau_psc"] = self._tables()["short_term"]["tau_psc"]
        self._do_set_current(self._currents)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        if not projection.is_plastic:
            return self._given.weights.get(projection.label, projection.weight).copy()
        return plastic_now(self._grid, self._plastic_places[projection.label]).weights

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        if variable == DOPAMINE and self._rewards is not None and self._rewards.has(projection):
            return self._rewards.dopamine(projection, _now(self._grid))
        if not projection.is_plastic:
            return self._read_share(projection, variable)
        return plastic_now(self._grid, self._plastic_places[projection.label]).variable(projection, variable)

    def _read_share(self, projection: Projection, variable: str) -> FloatArray:
        rows, arrivals = self._share_rows(projection)
        return share_state(shares_now(self._grid)[rows], projection, variable, arrivals)

    def _share_rows(self, projection: Projection) -> tuple[IntArray, FloatArray]:
        """Return the places of synapses in ``short_term``, and when a spike of now would arrive, ms."""
        order = np.argsort(self._initial.short_term["stream"])  # which are the numbers of the synapses there
        numbers = self._initial.short_term["stream"][order]
        rows: IntArray = order[np.searchsorted(numbers, numbers_of(projection))]
        delays_ms = self._times.time_ms(self._times.delays(projection.delay_ms))
        arrivals: FloatArray = _now(self._grid) + delays_ms
        return rows, arrivals

    def _do_reward(self, population: str, amount: float) -> None:
        assert self._rewards is not None
        self._rewards.reward(population, amount, _now(self._grid))

    def _do_hold_reward(self, population: str, value: float) -> None:
        assert self._rewards is not None
        self._rewards.hold(population, value, _now(self._grid))

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        require_weights(projection)
        self._take(handle(unfolded(self._grid)))
        if projection.is_plastic:
            hear_all(self._grid)
            rows = self._plastic_places[projection.label]
            signs = self._grid.rules["sign"][self._grid.plastic["rule"][rows]]
            self._grid.plastic["weight"][rows] = weights * signs
        elif len(weights):
            self._set_static(projection, weights)

    def _do_set_synapse_parameters(self, projection: Projection, values: Mapping[str, FloatArray]) -> None:
        self._take(handle(unfolded(self._grid)))
        if not projection.is_plastic:
            rows, arrivals = self._share_rows(projection)
            table = self._grid.short_term[rows]
            change_shares(table, projection, values, arrivals)
            self._grid.short_term[rows] = table
            return
        if self._rewards is not None:
            self._rewards.require_same_decay(projection, values, self._grid.rules)
        hear_all(self._grid)
        numbers = self._grid.plastic["rule"][self._plastic_places[projection.label]]
        rules = self._grid.rules.copy()
        change_rules(rules, numbers, projection, values)
        self._take(handle(self._grid._replace(rules=rules)))

    def _do_set_plastic(self, projection: Projection, plastic: bool) -> None:
        self._take(handle(unfolded(self._grid)))
        hear_all(self._grid)
        numbers = self._grid.plastic["rule"][self._plastic_places[projection.label]]
        for rules in (self._grid.rules, self._initial.rules):
            freeze(rules, numbers, not plastic)

    @cached_property
    def _plastic_places(self) -> dict[str, Array]:
        return places_of_plastic(self._wired, self._row_of)[1]

    def _set_static(self, projection: Projection, weights: FloatArray) -> None:
        """Change weights in place where the tables have room for them; else rebuild the tables."""
        label, before = projection.label, self._given.form(projection)
        self._given = self._given.with_weights(label, weights)
        if projection.is_continuous:
            self._set_couplings()
        elif self._given.form(projection) == before and (layout := self._found_layout()) is not None:
            grid = written(self._grid, self._initial, layout, label, weights)
            if grid is not self._grid:
                self._take(handle(grid))
        else:
            self._rebuild()

    def _found_layout(self) -> Layout | None:
        """Return where the weights are in the present tables."""
        key = frozenset(self._given.weights), self._given.each
        if self._layout[0] != key:
            own = self._wired, self._cells, self._row_of, self._times
            self._layout = key, find_layout(*own, labels_from(self._wired, self._drawn), self._given)
        return self._layout[1]

    def _rebuild(self) -> None:
        """Rebuild the tables with the changed weights."""
        tables = self._tables()
        del tables["short_term"]  # the order of its rows stays
        self._take(handle(self._grid._replace(**tables)))
        self._set_couplings()

    def _set_couplings(self) -> None:
        if len(self._grid.couplings):
            step_ms = self._times.step_ms
            fresh = couplings_of(self._wired, self._row_of, step_ms, dict(self._given.weights))
            self._grid.couplings["weight"] = fresh["weight"]

    def _tables(self) -> dict[str, Array]:
        noisy, given = labels_from(self._wired, self._drawn), self._given
        own = self._wired, self._cells, self._row_of, self._times
        return load_tables(*own, noisy, given.weights, given.each)

    def _do_reset(self, seed: int) -> None:
        self._start()

    def _start(self) -> None:
        if self._rewards is not None:
            self._rewards.begin()
        if len(self._initial.plastic):  # no copy of it is kept: there can be many
            begin_plastic(self._wired, self._initial.plastic, self._initial.slow, self._plastic_places)
        self._take(handle(self._initial._replace(**changing(self._initial, WITHOUT_COPY))))
        self._cells, self._given = self._initial_cells, Given()
        if len(self._grid.short_term):
            begin_streams(self._grid.short_term, self._seeds.integer("synapses", 62))
        begin_cell_streams(self._grid, self.network, self._seeds)
        for noise in self._grid.noise:
            label, _ = self.network.label_of(int(self._grid.noise_ids[noise["first"]]))
            noise["key"] = self._seeds.integer(f"population/{label}", 62)

    def _do_save(self) -> object:
        cells = None if self._cells is self._initial_cells else self._cells
        rewards = () if self._rewards is None else (self._rewards.save(),)
        given = dict(self._given.weights), self._given.each
        arrays, rules = changing(self._grid), self._grid.rules
        if rules is not self._initial.rules:
            arrays["rules"] = rules.copy()
        return arrays, waiting(self._grid), cells, given, *rewards

    def _do_restore(self, saved: Any) -> None:
        arrays, inputs, cells, given, *rewards = saved
        if self._rewards is not None:
            self._rewards.restore(*rewards)
        require_slow(arrays, self._initial.plastic)
        self._cells = self._initial_cells if cells is None else cells
        self._grid = self._initial
        self._given = Given.of_saved(given)
        if self._given.weights:
            self._rebuild()
        grid = with_waiting(self._grid._replace(**arrays), *inputs)
        self._take(handle(with_code(grid, self.network)))
        keep_kernels(self._grid.short_term, self._initial.short_term)
        keep_addresses(self._grid.rules, self._initial.rules)

    def _do_close(self) -> None:
        if self._threads:
            self._threads.close()
        del self._grid, self._held, self._initial, self._cells, self._initial_cells, self._step, self._stored

    def _emits(self, population: Population) -> bool:
        return population.label in self._drawn

    def _listen_to_noise(self) -> None:
        """Store the spikes of Poisson cells that the grid draws, if a sink records them."""
        for noise in self._grid.noise:
            own = self._grid.noise_ids[noise["first"] : noise["last"]]
            low, high = own.min(), own.max()
            heard = (sink.neurons for sink in self._attached.sinks)
            noise["heard"] = any(((ids >= low) & (ids <= high)).any() for ids in heard)

    def _as_many(self, n: int) -> Threads | None:
        """Return a pool of threads for the rows, or None for a single thread."""
        n_rows = len(self._initial.drive)
        n = min(n, n_rows)
        if n <= 1:
            return None
        alone = ""
        if len(self._initial.memories):
            alone = "spike-timing-dependent plasticity uses"
        elif len(self._initial.coupled):
            alone = "synapses that transmit voltages use"
        if alone:
            self.warnings.add(Code.NRP279, f"{alone} one thread; `threads` has no effect")
            return None
        window = int(self._initial.clock["window"][0])
        if n_rows * window < _WORTH_SHARING:
            self.warnings.add(
                Code.NRP279,
                f"`threads: {n}` makes this network slower: threads wait for each other after the shortest "
                f"delay, {window * self._times.step_ms:g} ms, too soon for {n_rows} neurons",
            )
        return Threads(n, n_rows)

    def _warn_of_rounding(self) -> None:
        rounded = [
            projection.label for projection in self.network.projections if self._is_rounded(projection)
        ]
        if rounded:
            others = f" and of {len(rounded) - 1} more" if len(rounded) > 1 else ""
            self.warnings.add(
                Code.NRP217,
                f"delays of projection '{rounded[0]}'{others} are rounded to the grid of "
                f"{self._times.step_ms:g} ms, to at least one step",
                subject=rounded[0],
            )

    def _is_rounded(self, projection: Projection) -> bool:
        if projection.is_continuous:
            return False
        delays = distinct(extremes(stored_form(projection, "delay_ms")))
        return any(map(self._are_rounded, in_parts(delays)))

    def _are_rounded(self, delays_ms: FloatArray) -> bool:
        on_grid_ms = self._times.time_ms(self._times.delays(delays_ms))
        return bool((abs(on_grid_ms - delays_ms) > _EXACT_MS).any())
