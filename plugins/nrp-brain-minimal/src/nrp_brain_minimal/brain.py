"""Conductance-based cells with alpha synapses on a fixed step.

The membrane obeys ``cm dv/dt = cm (v_rest - v) / tau_m + g_E (e_rev_E - v) + g_I (e_rev_I - v) + i``; a spike
of weight w adds ``w (t / tau) exp(1 - t / tau)`` to a conductance (Rall 1967, J Neurophysiol 30:1138).
Conductances are exact; the membrane takes exponential Euler steps under those in the middle of the step.
"""

from __future__ import annotations

from collections import defaultdict
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrp_core.brain import (
    STATIC,
    TSODYKS_MARKRAM,
    Brain,
    BrainBackend,
    BrainCapabilities,
    BrainOptions,
    FloatArray,
    Grid,
    IntArray,
    Network,
    Spikes,
    SynapticEvents,
)
from nrp_core.brain.devices.short_term import CONSTANTS, released_share
from nrp_core.clock import NS_PER_MS

GRID = Grid(100_000)
STEP_MS = GRID.step_ms
RECEPTORS = ("excitatory", "inhibitory")

WIRE = [(name, np.int64) for name in ("pre", "target", "receptor", "plastic")]
STRENGTH = [(name, np.float64) for name in ("weight", "delay_ms")]
SHORT_TERM = [(name, np.float64) for name in (*CONSTANTS, "tau_psc", "t", "u", "y", "z")]
SYNAPSE = np.dtype((np.record, [*WIRE, *STRENGTH, *SHORT_TERM]))


def outgoing(network: Network, tau_syn: FloatArray) -> Any:
    """Return all synapses at rest as one table, sorted by source; ``tau_syn`` has shape ``(2, n)``."""
    tables = [np.zeros(0, SYNAPSE)]
    for p in network.projections:
        rows = np.zeros(p.size, SYNAPSE)
        rows["pre"] = network.offsets[p.pre] + p.pre_index
        rows["target"] = network.offsets[p.post] + p.post_index
        rows["receptor"] = RECEPTORS.index(p.receptor)
        rows["weight"], rows["delay_ms"] = p.weight, np.maximum(p.delay_ms, STEP_MS)
        rows["plastic"] = p.synapse_type == TSODYKS_MARKRAM
        for name in CONSTANTS if p.synapse_type == TSODYKS_MARKRAM else ():
            rows[name] = p.synapse_parameters[name]
        rows["tau_psc"] = tau_syn[rows["receptor"], rows["target"]]
        tables.append(rows)
    joined = np.concatenate(tables)
    return joined[np.argsort(joined["pre"], kind="stable")]


@dataclass
class Moving:
    """The state; ``g`` and ``rise`` have shape ``(2, n)``, ``arriving`` is by tick."""

    v: FloatArray
    g: FloatArray
    rise: FloatArray
    current_na: FloatArray
    free_at: IntArray
    synapses: Any
    tick: int = 0
    arriving: dict[int, FloatArray] = field(default_factory=dict)


class MinimalBrain(Brain):
    """Steps all cells at once; spikes and arrivals are on the grid."""

    def __init__(self, network: Network, *, seed: int, capabilities: BrainCapabilities) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities, identity="minimal")
        parameters: dict[str, FloatArray] = defaultdict(lambda: np.ones(network.size))
        self._v0 = np.zeros(network.size)
        self._is_cell = np.zeros(network.size, bool)
        for label, population in network.populations.items():
            if not population.is_source:
                ids = network.ids_of(label)
                self._is_cell[ids] = True
                self._v0[ids] = population.initial_values["v"]
                for name, values in population.parameters.items():
                    parameters[name][ids] = values
        self._p = parameters
        self._tau = np.stack([parameters[f"tau_syn_{side}"] for side in "EI"])
        self._reversal = np.stack([parameters[f"e_rev_{side}"] for side in "EI"])
        self._leak = parameters["cm"] / parameters["tau_m"]  # uS
        self._at_rest = outgoing(network, self._tau)
        self._first = np.searchsorted(self._at_rest["pre"], np.arange(network.size + 1))
        self._now = self._fresh()
        self._spikes: list[tuple[IntArray, float]] = []

    def _fresh(self) -> Moving:
        n = self.network.size
        g, rise, free_at = np.zeros((2, n)), np.zeros((2, n)), np.zeros(n, np.int64)
        return Moving(self._v0.copy(), g, rise, np.zeros(n), free_at, self._at_rest.copy())

    # -- required by the interface

    def _do_run_until(self, t_ns: int) -> None:
        while self._now.tick < GRID.number_of(t_ns):
            self._step()

    def _do_take_spikes(self) -> Spikes:
        taken, self._spikes = self._spikes, []
        return Spikes.merged([Spikes(ids, np.full(len(ids), time)) for ids, time in taken])

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        for neuron, time in zip(neurons.tolist(), times_ms.tolist(), strict=True):
            self._send(neuron, time)

    def _do_inject(self, events: SynapticEvents) -> None:
        receptor = np.full(len(events), RECEPTORS.index(events.receptor))
        self._post(events.neurons, receptor, events.weights, events.times_ms)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self._now.current_na = currents_na.copy()

    def _do_reset(self, seed: int) -> None:
        self._now, self._spikes = self._fresh(), []

    # -- optional

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self._now.v[neurons]

    def _do_save(self) -> object:
        return deepcopy(self._now)

    def _do_restore(self, saved: Any) -> None:
        self._now, self._spikes = deepcopy(saved), []

    # -- a step

    def _step(self) -> None:
        s, p = self._now, self._p
        s.rise += np.e / self._tau * s.arriving.pop(s.tick, 0.0)
        g = (s.g + STEP_MS / 2 * s.rise) * np.exp(-STEP_MS / 2 / self._tau)
        drive = self._leak * p["v_rest"] + (g * self._reversal).sum(0) + p["i_offset"] + s.current_na
        total = self._leak + g.sum(0)
        v = drive / total + (s.v - drive / total) * np.exp(-STEP_MS * total / p["cm"])
        s.g = (s.g + STEP_MS * s.rise) * np.exp(-STEP_MS / self._tau)
        s.rise *= np.exp(-STEP_MS / self._tau)
        s.v = np.where(self._is_cell & (s.tick >= s.free_at), v, s.v)
        s.tick += 1
        fired = np.flatnonzero(self._is_cell & (s.tick > s.free_at) & (s.v >= p["v_thresh"]))
        if len(fired):
            self._fire(fired)

    def _fire(self, fired: IntArray) -> None:
        s = self._now
        time_ms = s.tick * GRID.step_ns / NS_PER_MS  # exactly the end of its window
        s.v[fired] = self._p["v_reset"][fired]
        s.free_at[fired] = s.tick + np.rint(self._p["tau_refrac"][fired] / STEP_MS).astype(np.int64)
        self._spikes.append((fired, time_ms))
        for neuron in fired.tolist():
            self._send(neuron, time_ms)

    def _send(self, neuron: int, time_ms: float) -> None:
        own = self._now.synapses[self._first[neuron] : self._first[neuron + 1]]
        weights = own["weight"].copy()
        for i in np.flatnonzero(own["plastic"]):
            weights[i] *= released_share(own[i], time_ms)
        self._post(own["target"], own["receptor"], weights, time_ms + own["delay_ms"])

    def _post(self, target: IntArray, receptor: IntArray, weight: FloatArray, at_ms: FloatArray) -> None:
        """Add weights that arrive at the first step at or after a time."""
        s = self._now
        ticks = np.maximum(s.tick, GRID.first_at(at_ms))
        for tick in np.unique(ticks).tolist():
            now = ticks == tick
            arriving = s.arriving.setdefault(tick, np.zeros_like(s.g))
            np.add.at(arriving, (receptor[now], target[now]), weight[now])


class MinimalBackend(BrainBackend):
    """Opens :class:`MinimalBrain`."""

    interface_version = 1

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return BrainCapabilities(
            cells=frozenset({"IF_cond_alpha"}), synapses=frozenset({STATIC, TSODYKS_MARKRAM}),
            resolution_ns=GRID.step_ns, state_variables=frozenset({"v"}), snapshot=True,
        )  # fmt: skip

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return MinimalBrain(network, seed=seed, capabilities=self.capabilities(options))
