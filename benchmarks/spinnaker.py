"""The spinnaker backend: neuron updates, synaptic events, and the step of the Braitenberg brain.

CPU time of one thread, best of several runs; the first start, which compiles, is not included.

    python benchmarks/spinnaker.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import numpy as np
from conditions import print_conditions
from nrp_brain_spinnaker import SpinnakerBackend, SpinnakerOptions

from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha
from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.brain.files.script import load_network
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import Network, Population, Projection

MS = 1_000_000
UPDATES_AT_LEAST, EVENTS_AT_LEAST, STEP_AT_MOST_US = 20e6, 100e6, 150.0
REPEATS = 5

_LEAKY = {
    "v_rest": -65.0, "cm": 1.0, "tau_m": 20.0, "tau_refrac": 2.0, "v_reset": -65.0, "v_thresh": -50.0,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "e_rev_E": 0.0, "e_rev_I": -70.0, "i_offset": 0.7,
}  # fmt: skip
_SIMPLE = ("IF_curr_exp", "IF_cond_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_alpha")
_CELLS = {
    **dict.fromkeys(_SIMPLE, _LEAKY),
    "IZK_curr_exp": {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "i_offset": 10.0},
    "EIF_cond_exp_isfa_ista": {
        **_LEAKY, "v_spike": -40.0, "delta_T": 2.0, "a": 4.0, "b": 0.08, "tau_w": 144.0,
    },
    "HH_cond_exp": {
        "gbar_Na": 20.0, "gbar_K": 6.0, "g_leak": 0.01, "cm": 0.2, "v_offset": -63.0, "e_rev_Na": 50.0,
        "e_rev_K": -90.0, "e_rev_leak": -65.0, "i_offset": 0.7,
    },
}  # fmt: skip


def population(cell_type: str, size: int) -> Population:
    parameters = {name: np.full(size, value) for name, value in _CELLS[cell_type].items()}
    return Population(cell_type, size, cell_type, parameters, {"v": np.linspace(-65.0, -51.0, size)})


def opened(network: Network, **options: object) -> Brain:
    brain = SpinnakerBackend().open(network, seed=1, options=SpinnakerOptions.model_validate(options))
    brain.run_until(20 * MS)
    return brain


def best(action: Callable[[], None]) -> float:
    """Return the least CPU time of an action, in seconds."""
    times = []
    for _ in range(REPEATS):
        before = time.process_time()
        action()
        times.append(time.process_time() - before)
    return min(times)


def updates_per_second(cell_type: str, size: int = 10_000, duration_ms: int = 100) -> float:
    brain = opened(Network({cell_type: population(cell_type, size)}))
    return size * duration_ms / best(lambda: brain.run_until(brain.now_ns + duration_ms * MS))


def events_per_second(n_sources: int = 1000, fan_out: int = 10_000, size: int = 10_000) -> float:
    """Make every source spike in every fifth tick; weights and delays differ between synapses."""
    rng = np.random.default_rng(1)
    n = n_sources * fan_out
    trains = tuple(np.arange(1.0, 1000.0, 5.0) for _ in range(n_sources))
    sources = Population("sources", n_sources, "SpikeSourceArray", {}, {}, trains)
    cells = population("IF_curr_exp", size)
    projection = Projection(
        "all", "sources", cells.label, "excitatory",
        np.repeat(np.arange(n_sources, dtype=np.int32), fan_out), rng.integers(0, size, n, dtype=np.int32),
        rng.uniform(0.0, 2e-3, n), rng.integers(1, 17, n).astype(float),
    )  # fmt: skip
    brain = opened(Network({"sources": sources, cells.label: cells}, (projection,)))
    duration_ms = 50
    quiet = size * duration_ms / updates_per_second("IF_curr_exp", size)
    return n * duration_ms / 5 / (best(lambda: brain.run_until(brain.now_ns + duration_ms * MS)) - quiet)


def braitenberg_step_us(timestep: str, steps: int = 300) -> float:
    """Return the cost of 20 ms with five Poisson sources whose rates change and two integrators read."""
    network = load_network(Path(experiment.__file__).parent / "brain.py")
    brain = opened(network, timestep=timestep)
    eyes = [brain.add_source(PoissonSource(), [cell], name=f"eye {cell}") for cell in range(5)]
    wheels = [brain.add_sink(LeakyIntegratorAlpha(), [cell], name=f"wheel {cell}") for cell in (6, 7)]
    rates = np.random.default_rng(1).uniform(0, 2000, (steps, len(eyes)))

    def drive() -> None:
        for step in rates.tolist():
            for eye, rate in zip(eyes, step, strict=True):
                eye.rate = rate  # type: ignore[attr-defined]
            brain.run_until(brain.now_ns + 20 * MS)
            for wheel in wheels:
                assert np.isfinite(wheel.voltage)  # type: ignore[attr-defined]

    return best(drive) / steps * 1e6


def main() -> int:
    print_conditions()
    updates = {cell_type: updates_per_second(cell_type) for cell_type in _CELLS}
    for cell_type, rate in updates.items():
        print(f"{cell_type:24s} {rate / 1e6:7.1f} M neuron updates/s on a 1 ms grid")
    events = events_per_second()
    print(f"{'synaptic events':24s} {events / 1e6:7.1f} M/s")
    steps = {timestep: braitenberg_step_us(timestep) for timestep in ("1 ms", "0.1 ms")}
    for timestep, cost in steps.items():
        print(f"{'Braitenberg brain':24s} {cost:7.1f} us CPU per 20 ms step on a {timestep} grid")
    enough = updates["IF_curr_exp"] >= UPDATES_AT_LEAST and events >= EVENTS_AT_LEAST
    return 0 if enough and steps["1 ms"] <= STEP_AT_MOST_US else 1


if __name__ == "__main__":
    sys.exit(main())
