"""A healthy brain of one kind of cell on a grid, in plain NumPy: what the wrong brains are made from."""

from __future__ import annotations

from collections import defaultdict
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network
from nrp_core.network.grid import Grid
from nrp_core.network.synapses import CONTINUOUS, STATIC

STEP_NS = 100_000
GRID = Grid(STEP_NS)
STEP_MS = GRID.step_ms
CELL = "IF_curr_exp"


@dataclass
class State:
    """Everything that changes while running; ``in_flight`` by the tick of arrival."""

    tick: int
    v: FloatArray
    exc: FloatArray
    inh: FloatArray
    free_at: IntArray
    current: FloatArray
    in_flight: dict[int, list[tuple[int, float, str]]] = field(default_factory=lambda: defaultdict(list))


class SmallBrain(Brain):
    """Exact integration of every step; spikes and arrivals lie on the grid."""

    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities, identity="small")
        n = network.size
        self.p = {name: np.ones(n) for name in ("v_rest", "v_reset", "v_thresh", "tau_m", "cm", "tau_refrac",
                                                "tau_syn_E", "tau_syn_I", "i_offset")}  # fmt: skip
        self.alive = np.zeros(n, bool)
        self.v0, self.exc0, self.inh0 = np.zeros((3, n))
        for label, population in network.populations.items():
            if not population.is_source:
                ids = network.ids_of(label)
                self.alive[ids] = True
                starts = population.initial_values
                self.v0[ids] = starts["v"]
                self.exc0[ids], self.inh0[ids] = starts.get("isyn_exc", 0.0), starts.get("isyn_inh", 0.0)
                for name in self.p:
                    self.p[name][ids] = population.parameters[name]
        self.targets = self.outgoing()
        self.live = self.fresh()
        self.spikes: list[tuple[int, float]] = []

    def outgoing(self) -> dict[int, list[tuple[int, float, float, str]]]:
        """Return target, weight, delay and receptor of the synapses of every neuron that transmit spikes."""
        found: dict[int, list[tuple[int, float, float, str]]] = defaultdict(list)
        for p in (p for p in self.network.projections if p.synapse_type not in CONTINUOUS):
            pre, post = self.network.offsets[p.pre], self.network.offsets[p.post]
            columns = zip(p.pre_index, p.post_index, p.weight, p.delay_ms, strict=True)
            for i, j, weight, delay in columns:
                found[pre + int(i)].append(
                    (post + int(j), float(weight), max(float(delay), STEP_MS), p.receptor)
                )
        return found

    def fresh(self) -> State:
        n = self.network.size
        starts = self.v0.copy(), self.exc0.copy(), self.inh0.copy()
        return State(0, *starts, np.zeros(n, np.int64), np.zeros(n))

    def _do_run_until(self, t_ns: int) -> None:
        while self.live.tick < GRID.number_of(t_ns):
            self.step()

    def step(self) -> None:
        s = self.live
        for target, weight, receptor in s.in_flight.pop(s.tick, ()):
            self.receive(target, weight, receptor)
        self.integrate()
        s.tick += 1
        (fired,) = (self.alive & (s.v >= self.p["v_thresh"])).nonzero()
        for neuron in fired.tolist():
            self.fire(neuron)

    def receive(self, target: int, weight: float, receptor: str) -> None:
        (self.live.exc if receptor == "excitatory" else self.live.inh)[target] += weight

    @cached_property
    def factors(self) -> tuple[FloatArray, ...]:
        """Return how the membrane and both currents decay in a step, and what a current leaves behind."""
        p = self.p
        leak = np.exp(-STEP_MS / p["tau_m"])
        found = [leak]
        for tau in (p["tau_syn_E"], p["tau_syn_I"]):
            fade = np.exp(-STEP_MS / tau)
            found += [fade, self.left_behind(tau, leak, fade) / p["cm"]]
        return tuple(found)

    def left_behind(self, tau: FloatArray, leak: FloatArray, fade: FloatArray) -> FloatArray:
        """Return how long a current acts on the membrane in a step, ms, given the decays of both."""
        rate = 1 / tau - 1 / self.p["tau_m"]
        return np.where(rate == 0, STEP_MS * leak, (leak - fade) / np.where(rate == 0, 1.0, rate))

    def integrate(self) -> None:
        s, p = self.live, self.p
        leak, fade_exc, left_exc, fade_inh, left_inh = self.factors
        settled = p["v_rest"] + p["tau_m"] / p["cm"] * (p["i_offset"] + s.current)
        v = settled + (s.v - settled) * leak + s.exc * left_exc + s.inh * left_inh
        s.exc *= fade_exc
        s.inh *= fade_inh
        s.v = np.where(self.alive & (s.tick >= s.free_at), v, s.v)

    def fire(self, neuron: int) -> None:
        s = self.live
        s.v[neuron] = self.p["v_reset"][neuron]
        s.free_at[neuron] = s.tick + round(self.p["tau_refrac"][neuron] / STEP_MS)
        time_ms = s.tick * STEP_NS / NS_PER_MS
        self.spikes.append((neuron, time_ms))
        self.send(neuron, time_ms)

    def send(self, neuron: int, time_ms: float) -> None:
        for target, weight, delay, receptor in self.targets[neuron]:
            self.post(target, weight, time_ms + delay, receptor)

    def post(self, target: int, weight: float, time_ms: float, receptor: str) -> None:
        tick = max(self.live.tick, ceil(time_ms / STEP_MS - 1e-9))
        self.live.in_flight[tick].append((target, weight, receptor))

    def _do_take_spikes(self) -> Spikes:
        taken, self.spikes = self.spikes, []
        return Spikes(np.array([n for n, _ in taken], np.int64), np.array([t for _, t in taken], float))

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        for neuron, time in zip(neurons.tolist(), times_ms.tolist(), strict=True):
            self.send(neuron, time)

    def _do_inject(self, events: SynapticEvents) -> None:
        columns = zip(events.neurons.tolist(), events.times_ms.tolist(), events.weights.tolist(), strict=True)
        for target, time, weight in columns:
            self.post(target, weight, time, events.receptor)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self.live.current = currents_na.copy()

    def _do_reset(self, seed: int) -> None:
        self.live, self.spikes = self.fresh(), []

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self.live.v[neurons]

    def _do_save(self) -> object:
        return deepcopy(self.live)

    def _do_restore(self, saved: State) -> None:
        self.live, self.spikes = deepcopy(saved), []

    def _do_close(self) -> None:
        self.spikes = []


class SmallBackend(BrainBackend):
    """Opens :class:`SmallBrain`, or a wrong one."""

    brain: type[SmallBrain] = SmallBrain

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return BrainCapabilities(
            cells=frozenset({CELL}), synapses=frozenset({STATIC}), resolution_ns=STEP_NS,
            state_variables=frozenset({"v"}), snapshot=True,
        )  # fmt: skip

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return self.brain(network, seed=seed, capabilities=self.capabilities(options))
