"""Compiled code returns from time to time, for signals, and the events of a network are bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import brain as exact
from nrp_brain_event import engine
from nrp_brain_event.grid import brain as grid
from nrp_brain_event.records import PAUSED

from nrp_core._support import signals
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import NetworkError
from nrp_core.network.data import Population, Projection

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Source = Callable[..., Population]
Open = Callable[..., Brain]
Parts = tuple[Population | Projection, ...]


@pytest.fixture
def returned(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Results of the calls of compiled code in the exact mode."""
    found: list[int] = []
    run = vars(exact)["run"]

    def noted(*arguments: Any) -> int:
        found.append(run(*arguments))
        return found[-1]

    monkeypatch.setattr(exact, "run", noted)
    return found


def outcome(brain: Brain, stops_ms: Iterable[float]) -> tuple[bytes, ...]:
    """Return the spikes and the final voltages of a run with these stops."""
    recorder: Any = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="all")
    for stop_ms in stops_ms:
        brain.run_until(round(stop_ms * NS_PER_MS))
    spikes = recorder.spikes()
    assert len(spikes)
    voltages = brain.read_state("v", brain.network.ids_of("cells"))
    return spikes.neurons.tobytes(), spikes.times_ms.tobytes(), voltages.tobytes()


def busy(cells: Cells, connect: Connect, cell_type: str) -> Parts:
    """Return cells that excite each other, with some 100000 arrivals in 10 ms."""
    own = cells("cells", cell_type, 200, i_offset=np.linspace(2.0, 8.0, 200), tau_refrac=0.5, cm=0.1)
    pairs = [(pre, (pre + 7 * k) % 200) for pre in range(200) for k in range(100)]
    delays = np.resize([0.5, 0.7, 1.3], len(pairs))
    return own, connect("cells", "cells", 0.001, delays, pairs=pairs)


def bundled(cells: Cells, connect: Connect, spike_source: Source) -> Parts:
    """Return a source with more synapses than the arrivals of a piece, all with the same delay."""
    source, own = spike_source("source", [1.0, 2.0]), cells("cells", "IF_curr_exp", 3, cm=0.1)
    pairs = [(0, k % 3) for k in range(300_000)]
    return source, own, connect("source", "cells", np.linspace(0.0, 2e-4, len(pairs)), pairs=pairs)


def frantic(cells: Cells) -> Population:
    """Return a cell that fires a million times a millisecond, as a relay into which a current flows."""
    return cells("cells", "IF_curr_delta", v_thresh=-64.999, tau_refrac=0.0, i_offset=1000.0)


def test_pauses_do_not_change_the_result(
    cells: Cells, connect: Connect, spike_source: Source, open_brain: Open, returned: list[int]
) -> None:
    networks: list[tuple[Parts, float]] = [
        (busy(cells, connect, "IF_curr_exp"), 20.0),
        (busy(cells, connect, "IF_cond_exp"), 20.0),
        (bundled(cells, connect, spike_source), 4.0),
        ((frantic(cells),), 0.4),
    ]
    for parts, until_ms in networks:
        returned.clear()
        whole = outcome(open_brain(*parts), [until_ms])
        assert PAUSED in returned
        assert outcome(open_brain(*parts), np.linspace(until_ms / 64, until_ms, 64)) == whole


@pytest.mark.parametrize("lazy", ["never", "always"])
def test_the_length_of_a_piece_does_not_change_the_result_on_a_grid(
    lazy: str, cells: Cells, connect: Connect, open_brain: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = busy(cells, connect, "IF_curr_exp")
    whole = outcome(open_brain(*parts, resolution="0.1 ms", lazy=lazy), [20.0])
    monkeypatch.setattr(grid, "_PIECE", 1)
    assert outcome(open_brain(*parts, resolution="0.1 ms", lazy=lazy), [20.0]) == whole


@pytest.mark.parametrize("options", [{}, {"resolution": "0.1 ms"}])
def test_a_thread_ends_where_the_process_was_asked_to_end(
    options: dict[str, Any], cells: Cells, connect: Connect, open_brain: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    brain = open_brain(*busy(cells, connect, "IF_curr_exp"), **options)
    monkeypatch.setattr(signals, "asked", True)
    with pytest.raises(KeyboardInterrupt):
        brain.run_until(NS_PER_MS)


def test_events_without_end_are_refused_with_the_cell_that_fires(
    cells: Cells, connect: Connect, spike_source: Source, open_brain: Open,
    monkeypatch: pytest.MonkeyPatch, golden: Golden,
) -> None:  # fmt: skip
    monkeypatch.setattr(engine, "_MOST_EVENTS", 1 << 12)
    monkeypatch.setattr(engine, "_MOST_SPIKES", 1 << 12)
    brain = open_brain(frantic(cells))
    with golden.raises(NetworkError, match="4096 spikes since.*cell 0 of population 'cells'"):
        brain.run_until(NS_PER_MS)
    pairs = [(0, 0)] * 3000
    own = connect("cells", "cells", 0.0, np.linspace(1.0, 2.0, 3000), pairs=pairs)
    brain = open_brain(frantic(cells), own)
    with golden.raises(NetworkError, match="4096 spikes in transit.*population 'cells'"):
        brain.run_until(NS_PER_MS)
