"""Weights that change in every step are written in place, and act as those of tables that are made anew."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from nrp_brain_event.grid import brain as grid_brain
from nrp_brain_event.grid.brain import GridBrain

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import TSODYKS_MARKRAM

N = 20


@pytest.fixture
def parts(cells: Callable[..., Population], connect: Callable[..., Projection]) -> tuple[Any, ...]:
    """Cells that fire, with projections whose tables are alone, shared, or of equal weights."""
    rng = np.random.default_rng(5)
    pairs = [(int(i), int(j)) for i, j in rng.integers(0, N, (120, 2))]
    delays = rng.integers(1, 8, 120).astype(float)
    own = rng.uniform(0.0, 0.3, 120)

    def synapses(label: str, weight: Any, **more: Any) -> Projection:
        return connect("cells", "cells", weight, delays, pairs=pairs, label=label, **more)

    return (
        cells("cells", "IF_curr_exp", N, i_offset=rng.uniform(0.9, 1.6, N)),
        synapses("own", own),
        synapses("equal", 0.1),
        synapses("alike", 0.1),
        synapses("other", own[::-1]),
        synapses("release", 0.4, kind=TSODYKS_MARKRAM, U=0.4, tau_rec=50.0, tau_facil=5.0),
        connect("cells", "cells", 0.3, 2.0, pairs=[(3, 4)], label="single"),
    )


CHANGES = {
    "own": [0.05, None, 0.2, None, None],
    "equal": [0.2, 0.15, None, 0.1, 0.25],
    "alike": [None, None, 0.1, None, 0.3],
    "release": [None, 0.3, 0.3, None, 0.5],
    "single": [0.1, 0.4, 0.2, 0.5, 0.3],
}
"""The weight of all synapses, or None for individual ones, in the steps that change a projection."""


def run(brain: Brain) -> tuple[Any, ...]:
    rng, seen = np.random.default_rng(7), []
    recorder = brain.add_sink(SpikeRecorder(), np.arange(N), name="spikes")
    for step in range(25):
        for k, (label, values) in enumerate(CHANGES.items()):
            if (step + k) % 3 == 0:
                value = values[step % len(values)]
                size = brain.read_weights(label).size
                brain.set_weights(label, rng.uniform(0.0, 0.4, size) if value is None else value)
        brain.run_until(from_milliseconds(4.0 * (step + 1)))
        seen.append(brain.read_state("v", np.arange(N)).tolist())
    spikes = recorder.spikes()
    assert len(spikes) > 50
    return spikes.neurons.tolist(), spikes.times_ms.tolist(), seen


@pytest.mark.parametrize("lazy", ["never", "always"])
def test_they_act_as_those_of_new_tables(
    parts: tuple[Any, ...], open_brain: Callable[..., Brain], lazy: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"resolution": "0.1 ms", "lazy": lazy}
    brain = open_brain(*parts, **options)
    found = run(brain)
    brain.reset()
    assert run(brain) == found
    monkeypatch.setattr(GridBrain, "_found_layout", lambda self: None)
    assert run(open_brain(*parts, **options)) == found


def test_tables_are_made_only_where_their_form_changes(
    parts: tuple[Any, ...], open_brain: Callable[..., Brain], monkeypatch: pytest.MonkeyPatch
) -> None:
    brain = open_brain(*parts, resolution="0.1 ms")
    made = []
    monkeypatch.setattr(grid_brain, "load_tables", lambda *given: made.append(given))
    for step in range(5):
        brain.set_weights("own", np.linspace(0.0, 0.1 * step + 0.1, 120))
        brain.run_until(from_milliseconds(4.0 * (step + 1)))
    brain.reset()
    brain.set_weights("own", np.linspace(0.0, 0.2, 120))
    assert made == []


def test_a_snapshot_has_the_form_of_its_tables(
    parts: tuple[Any, ...], open_brain: Callable[..., Brain]
) -> None:
    """Weights that have differed and are equal again keep a place each, in single precision."""
    brain = open_brain(*parts, resolution="0.1 ms")
    brain.set_weights("equal", np.linspace(0.1, 0.2, 120))
    brain.set_weights("equal", 0.1)
    brain.run_until(from_milliseconds(30.0))
    saved = brain.snapshot()
    brain.run_until(from_milliseconds(90.0))
    expected = brain.read_state("v", np.arange(N)).tolist()
    brain.reset()
    brain.restore(saved)
    brain.run_until(from_milliseconds(90.0))
    assert brain.read_state("v", np.arange(N)).tolist() == expected
