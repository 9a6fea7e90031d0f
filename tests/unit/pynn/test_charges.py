"""The charge that a current source delivers is its amplitude times its duration, whatever its times are.

A membrane of 1 nF shows it: ``R I (exp((stop - t) / tau) - exp((start - t) / tau))``.
"""

from __future__ import annotations

from fractions import Fraction
from math import floor
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import nrp_core.network.pynn.export as export
from nrp_core.brain.backends import brains
from nrp_core.clock import NS_PER_MS
from nrp_core.network.pynn import builder
from nrp_core.pynn import new_simulator

END_MS = 30.0
AMPLITUDE_NA = 0.6
EXACT: dict[str, Any] = {"backend": "event"}
GRID: dict[str, Any] = {"backend": "event", "options": {"resolution": "0.1 ms"}}
MACHINE: dict[str, Any] = {"backend": "spinnaker"}
CELL = {"tau_m": 20.0, "cm": 1.0, "v_thresh": 1e3}

# as people write times, compute them, and on the middle between two steps
TIMES = st.one_of(
    st.integers(0, 299).map(lambda n: n / 10),
    st.integers(0, 299).map(lambda n: n * 0.1),
    st.integers(0, 598).map(lambda n: round(n * 0.05, 2)),
    st.integers(0, 598).map(lambda n: n * 0.05),
    st.floats(0.0, 29.0),
)
WINDOWS = st.lists(TIMES, min_size=2, max_size=2, unique_by=lambda t: whole_ns(t)).map(sorted)
KINDS = st.sampled_from(["DCSource", "ACSource", "NoisyCurrentSource", "StepCurrentSource"])


def whole_ns(t_ms: float) -> int:
    return round(Fraction(repr(t_ms)) * NS_PER_MS)


def source(sim: Any, kind: str, start: float, stop: float) -> Any:
    if kind == "StepCurrentSource":
        return sim.StepCurrentSource(times=[start, stop], amplitudes=[AMPLITUDE_NA, 0.0])
    own = {
        "DCSource": {"amplitude": AMPLITUDE_NA},
        "ACSource": {"amplitude": 0.0, "offset": AMPLITUDE_NA},
        "NoisyCurrentSource": {"mean": AMPLITUDE_NA, "stdev": 0.0, "dt": 0.3},
    }
    return getattr(sim, kind)(start=start, stop=stop, **own[kind])


def expected_mv(windows: list[list[float]], step_ns: int) -> Any:
    """Return the voltages; the grid takes the step that is nearest to a time, the later one of two."""
    steps = [[floor(Fraction(whole_ns(t), step_ns) + Fraction(1, 2)) for t in window] for window in windows]
    start, stop = np.exp((np.array(steps).T * step_ns / NS_PER_MS - END_MS) / CELL["tau_m"])
    return AMPLITUDE_NA * CELL["tau_m"] / CELL["cm"] * (stop - start)


def voltages_of_script(where: dict[str, Any], timestep: float, chosen: list[tuple[str, list[float]]]) -> Any:
    sim = new_simulator()
    sim.setup(timestep=timestep, **where)
    cells = sim.Population(len(chosen), sim.IF_curr_exp(**CELL))
    for cell, (kind, window) in zip(cells, chosen, strict=True):
        cell.inject(source(sim, kind, *window))
    cells.record("v", sampling_interval=END_MS / 2)
    sim.run(END_MS / 2)
    sim.run(END_MS / 2)
    return np.asarray(cells.get_data("v").segments[0].analogsignals[0])[-1] + 65.0


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("where", "timestep", "step_ns", "error_mv"),
    [(EXACT, 0.1, 1, 1e-9), (GRID, 0.1, 100_000, 1e-9), (MACHINE, 1.0, NS_PER_MS, 5e-3)],
    ids=["exact", "grid", "machine"],
)
@settings(max_examples=3, deadline=None, phases=(Phase.explicit, Phase.generate))
@given(chosen=st.lists(st.tuples(KINDS, WINDOWS), min_size=60, max_size=60))
def test_a_script_delivers_the_charge_of_each_source(
    where: dict[str, Any], timestep: float, step_ns: int, error_mv: float, chosen: Any
) -> None:
    found = voltages_of_script(where, timestep, chosen)
    assert found == pytest.approx(expected_mv([window for _, window in chosen], step_ns), abs=error_mv)


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("backend", "options", "step_ns", "error_mv"),
    [("event", {}, 1, 1e-9), ("event", {"resolution": "0.1 ms"}, 100_000, 1e-9),
     ("spinnaker", {}, NS_PER_MS, 5e-3)],
    ids=["exact", "grid", "machine"],
)  # fmt: skip
@settings(max_examples=3, deadline=None, phases=(Phase.explicit, Phase.generate))
@given(
    chosen=st.lists(
        st.tuples(st.sampled_from(["DCSource", "StepCurrentSource"]), WINDOWS), min_size=60, max_size=60
    )
)
def test_an_experiment_delivers_the_charge_of_each_source_of_its_network(
    backend: str, options: dict[str, Any], step_ns: int, error_mv: float, chosen: Any
) -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    cells = sim.Population(len(chosen), sim.IF_curr_exp(**CELL))
    for cell, (kind, window) in zip(cells, chosen, strict=True):
        cell.inject(source(sim, kind, *window))
    chosen_backend = brains().load(backend)
    network = export.network_of(cells._simulator.state)
    with chosen_backend.open(
        network, seed=1, options=chosen_backend.options.model_validate(options)
    ) as brain:
        for stop_ms in (2, 4, 10, 30):
            brain.run_until(stop_ms * NS_PER_MS)
        found = brain.read_state("v", np.arange(len(chosen))) + 65.0
    assert found == pytest.approx(expected_mv([window for _, window in chosen], step_ns), abs=error_mv)


def test_a_pulse_between_two_steps_lasts_as_long_as_it_is_written() -> None:
    """Rounding half to even would make 0.55 to 4.85 ms 4.2 ms long."""
    found = voltages_of_script(GRID, 0.1, [("StepCurrentSource", [0.55, 4.85])])
    assert found == pytest.approx(expected_mv([[0.6, 4.9]], 1))


def test_of_two_changes_in_one_step_the_later_one_stays() -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1, **GRID)
    cells = sim.Population(1, sim.IF_curr_exp(**CELL))
    cells.inject(sim.StepCurrentSource(times=[0.41, 0.42, 0.86], amplitudes=[9.0, AMPLITUDE_NA, 0.0]))
    cells.record("v")
    sim.run(END_MS)
    found = np.asarray(cells.get_data("v").segments[0].analogsignals[0])[-1] + 65.0
    assert found == pytest.approx(expected_mv([[0.4, 0.9]], 1))
