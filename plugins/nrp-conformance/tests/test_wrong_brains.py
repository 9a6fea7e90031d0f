"""Brains with one edit of the minimal brain each, and the test of the kit that finds it."""

from __future__ import annotations

import sys
from itertools import count
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from nrp_conformance import BrainBackendTests
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests

SOURCE = Path(__file__).parents[3] / "plugins/nrp-brain-minimal/src/nrp_brain_minimal/brain.py"


def merged(synapses: Any) -> Any:
    """Return synapses with all between the same two cells made one, of the first one's delay."""
    if not len(synapses):
        return synapses
    _, first, back = np.unique(synapses[["pre", "target"]], return_index=True, return_inverse=True)
    total = np.bincount(back, synapses["weight"])
    left = synapses[first]
    left["weight"] = total
    return left


def without_bursts(brain: Any, fired: Any, time_ms: float) -> Any:
    """Return the cells whose last spike is more than 3 ms ago."""
    last = brain.__dict__.setdefault("_last", np.full(brain.network.size, -99.0))
    alone = fired[time_ms - last[fired] > 3.0]
    last[fired] = time_ms
    return alone


def split_at(spikes: Any, now_ms: float) -> Any:
    """Return the spikes before a time, and the others."""
    return [s for s in spikes if s[1] < now_ms], [s for s in spikes if s[1] >= now_ms]


HELPERS = {"merged": merged, "without_bursts": without_bursts, "split_at": split_at}
WRONG: dict[str, tuple[str, ...]] = {
    # the test, then each text with its replacement
    "threshold 2 % of the gap too high": (
        "a_cell_under_a_current_fires_at_the_times_of_its_equations",
        '(s.v >= p["v_thresh"])',
        '(s.v >= p["v_thresh"] + 0.02 * (p["v_thresh"] - p["v_rest"]))',
    ),
    "refractory one step long": (
        "a_cell_under_a_current_fires_at_the_times_of_its_equations",
        'np.rint(self._p["tau_refrac"][fired] / STEP_MS).astype(np.int64)',
        'np.rint(self._p["tau_refrac"][fired] / STEP_MS).astype(np.int64) + 1',
    ),
    "refractory one step short": (
        "a_cell_does_not_fire_in_its_refractory_period",
        'np.rint(self._p["tau_refrac"][fired] / STEP_MS).astype(np.int64)',
        'np.rint(self._p["tau_refrac"][fired] / STEP_MS).astype(np.int64) - 1',
    ),
    "delay one step long": (
        "a_spike_arrives_after_its_delay_and_not_before",
        'time_ms + own["delay_ms"])',
        'time_ms + own["delay_ms"] + STEP_MS)',
    ),
    "delay one step short": (
        "nothing_acts_before_its_delay",
        'time_ms + own["delay_ms"])',
        'time_ms + own["delay_ms"] - STEP_MS)',
    ),
    "inhibition excites": (
        "a_synaptic_potential_follows_its_equations",
        "+ (g * self._reversal).sum(0)",
        '+ (g * np.stack([p["e_rev_E"], p["e_rev_E"]])).sum(0)',
    ),
    "spike times at the start of the step": (
        "every_spike_is_reported_in_its_own_window",
        "self._spikes.append((fired, time_ms))",
        "self._spikes.append((fired, time_ms - STEP_MS))",
    ),
    "weights 2 % up": (
        "a_synaptic_potential_follows_its_equations",
        'weights = own["weight"].copy()',
        'weights = 1.02 * own["weight"]',
    ),
    "membrane time constant 2 % long": (
        "a_tsodyks_markram_synapse_follows_its_equations",
        'parameters["cm"] / parameters["tau_m"]',
        'parameters["cm"] / parameters["tau_m"] / 1.02',
    ),
    "capacitance 2 % up": (
        "a_cell_under_a_current_fires_at_the_times_of_its_equations",
        'parameters["cm"] / parameters["tau_m"]  # uS',
        'parameters["cm"] / parameters["tau_m"]; parameters["cm"] = 1.02 * parameters["cm"]',
    ),
    "synaptic time constant 2 % long": (
        "a_tsodyks_markram_synapse_follows_its_equations",
        'for side in "EI"])\n        self._reversal',
        'for side in "EI"]) * 1.02\n        self._reversal',
    ),
    "lost spike in a burst": (
        "a_reset_brain_equals_a_fresh_one",
        "self._spikes.append((fired, time_ms))",
        "self._spikes.append((without_bursts(self, fired, time_ms), time_ms))",
    ),
    "spikes at the end of a run twice": (
        "every_spike_is_reported_in_its_own_window",
        "taken, self._spikes = self._spikes, []",
        "taken = self._spikes; self._spikes = [s for s in taken if s[1] == self._now.tick * STEP_MS]",
    ),
    "spikes at the end of a run late": (
        "every_spike_is_reported_in_its_own_window",
        "taken, self._spikes = self._spikes, []",
        "taken, self._spikes = split_at(self._spikes, self._now.tick * GRID.step_ns / NS_PER_MS)",
    ),
    "seed ignored": (
        "a_reset_repeats_the_noise",
        "return MinimalBrain(network, seed=seed,",
        "return MinimalBrain(network, seed=1,",
    ),
    "reset keeps synapses": (
        "a_reset_restores_depressed_synapses",
        "self._now, self._spikes = self._fresh(), []",
        "kept = self._now.synapses; self._now, self._spikes = self._fresh(), []; self._now.synapses = kept",
    ),
    "reset keeps current": (
        "a_reset_forgets_spikes_in_transit",
        "self._now, self._spikes = self._fresh(), []",
        "old = self._now.current_na; self._now, self._spikes = self._fresh(), []; self._now.current_na = old",
    ),
    "reset keeps delay line": (
        "a_reset_forgets_spikes_in_transit",
        "self._now, self._spikes = self._fresh(), []",
        "kept = self._now.arriving; self._now, self._spikes = self._fresh(), []; self._now.arriving = kept",
    ),
    "snapshot forgets delay line": (
        "a_snapshot_keeps_spikes_in_flight",
        "return deepcopy(self._now)",
        "kept = deepcopy(self._now); kept.arriving = {}; return kept",
    ),
    "snapshot forgets refractoriness": (
        "a_snapshot_keeps_the_refractory_time",
        "return deepcopy(self._now)",
        "kept = deepcopy(self._now); kept.free_at[:] = 0; return kept",
    ),
    "snapshot forgets rise": (
        "a_snapshot_keeps_the_membrane_and_its_synapses",
        "return deepcopy(self._now)",
        "kept = deepcopy(self._now); kept.rise[:] = 0; return kept",
    ),
    "two projections merged": (
        "projections_between_the_same_cells_keep_their_delays_and_receptors",
        "joined = np.concatenate(tables)",
        "joined = merged(np.concatenate(tables))",
    ),
    "spike source 1 ms late": (
        "a_spike_arrives_after_its_delay_and_not_before",
        "self._send(neuron, time)",
        "self._send(neuron, time + 1.0)",
    ),
    "read state is a step old": (
        "a_cell_starts_from_its_initial_potential_also_after_a_reset",
        "return self._now.v[neurons]",
        'return getattr(self, "_old", self._now.v)[neurons]',
        "s, p = self._now, self._p",
        "s, p = self._now, self._p; self._old = s.v",
    ),
    "one source spike in fifty lost": (
        "a_reset_repeats_the_noise",
        "self._send(neuron, time)",
        "if next(COUNT) % 50:\n                self._send(neuron, time)",
    ),
    "current 2 % up": (
        "currents_of_several_sources_add_up",
        "= currents_na.copy()",
        "= 1.02 * currents_na",
    ),
    "current unit": (
        "a_current_acts_from_the_moment_it_is_set",
        "= currents_na.copy()",
        "= 1e-3 * currents_na",
    ),
    "current one step late": (
        "a_current_acts_from_the_moment_it_is_set",
        "+ s.current_na",
        '+ getattr(self, "_was", s.current_na)',
        "s.tick += 1",
        "s.tick += 1; self._was = s.current_na",
    ),
    "inhibitory reversal 2 mV off": (
        "a_synaptic_potential_follows_its_equations",
        'parameters[f"e_rev_{side}"] for side in "EI"]',
        'parameters[f"e_rev_{side}"] + 2.0 * (side == "I") for side in "EI"]',
    ),
    "self connections dropped": (
        "a_cell_can_act_on_itself",
        "joined = np.concatenate(tables)",
        'joined = np.concatenate(tables)\n    joined = joined[joined["pre"] != joined["target"]]',
    ),
    "reset to rest": (
        "a_cell_does_not_fire_in_its_refractory_period",
        'self._p["v_reset"][fired]',
        'self._p["v_rest"][fired]',
    ),
    "one parameter for a population": (
        "each_cell_has_its_own_parameters",
        "parameters[name][ids] = values",
        "parameters[name][ids] = values[0]",
    ),
    "the reset of the first of the cells that fire": (
        "cells_that_fire_at_once_are_reset_each_to_its_own_potential",
        's.v[fired] = self._p["v_reset"][fired]',
        's.v[fired] = self._p["v_reset"][fired[0]]',
    ),
    "a current replaces the offset": (
        "a_current_adds_to_the_offset_of_its_cell",
        'p["i_offset"] + s.current_na',
        'np.where(s.current_na, s.current_na, p["i_offset"])',
    ),
    "initial values ignored": (
        "a_cell_starts_from_its_initial_potential_also_after_a_reset",
        'population.initial_values["v"]',
        'population.parameters["v_rest"]',
    ),
    "simultaneous synapses lost": (
        "two_synapses_onto_one_cell_add_up",
        "np.add.at(arriving, (receptor[now], target[now]), weight[now])",
        "arriving[receptor[now], target[now]] += weight[now]",
    ),
    "indices of a byte": (
        "many_cells_are_independent",
        'np.int64) for name in ("pre", "target"',
        'np.int8) for name in ("pre", "target"',
    ),
    "delays at most 25 ms": (
        "a_spike_arrives_after_its_delay_and_not_before",
        'time_ms + own["delay_ms"])',
        'time_ms + np.minimum(own["delay_ms"], 25.0))',
    ),
    "tau_rec 2 % long": (
        "a_short_term_synapse_acts_like_static_ones_of_its_released_weights",
        "rows[name] = p.synapse_parameters[name]",
        'rows[name] = p.synapse_parameters[name] * (1.02 if name == "tau_rec" else 1.0)',
    ),
    "tau_facil 2 % long": (
        "a_short_term_synapse_acts_like_static_ones_of_its_released_weights",
        "rows[name] = p.synapse_parameters[name]",
        'rows[name] = p.synapse_parameters[name] * (1.02 if name == "tau_facil" else 1.0)',
    ),
    "U 2 % up": (
        "a_tsodyks_markram_synapse_follows_its_equations",
        "rows[name] = p.synapse_parameters[name]",
        'rows[name] = p.synapse_parameters[name] * (1.02 if name == "U" else 1.0)',
    ),
    "integrates while refractory": (
        "a_cell_does_not_fire_in_its_refractory_period",
        "s.v = np.where(self._is_cell & (s.tick >= s.free_at), v, s.v)",
        "s.v = np.where(self._is_cell, v, s.v)",
    ),
    "a step's conductance is that of its start": (
        "a_spike_arrives_after_its_delay_and_not_before",
        "g = (s.g + STEP_MS / 2 * s.rise) * np.exp(-STEP_MS / 2 / self._tau)",
        "g = s.g",
    ),
}


def opened(*edits: str) -> Any:
    """Return the backend with texts of its source replaced."""
    source = SOURCE.read_text("utf-8")
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        assert source.count(old) == 1
        source = source.replace(old, new)
    module = sys.modules["wrong_brain"] = ModuleType("wrong_brain")
    module.__dict__.update(HELPERS, COUNT=count(1))
    exec(compile(source, "wrong_brain", "exec"), module.__dict__)
    return module.__dict__["MinimalBackend"]


def failing(test: str, *edits: str) -> bool:
    """Return whether a test of the kit, which the minimal brain passes, fails with edits."""
    backend = opened(*edits)
    tests = type("Wrong", (BrainBackendTests,), {"make_backend": classmethod(lambda cls: backend())})
    results = run_tests(tests, only=[f"test_{test}"], traceback="native")
    return any(result.outcome is Outcome.FAILED for result in results)


@pytest.mark.one_of(8)
@pytest.mark.parametrize("fault", WRONG)
def test_a_wrong_brain_is_found(fault: str) -> None:
    assert failing(*WRONG[fault])
