"""Cost of a 20 ms step of the Braitenberg brain on PyNN's simulators, relative to their own run call in it.

Three rates are written and two integrators read in each step; all spikes are recorded. CPU time, by blocks of
steps, so that a cost that grows shows.

    python benchmarks/step_cost.py neuron brian2 --steps 10000
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from nrp_core import load_network
from nrp_core.brain import LeakyIntegratorAlpha, PoissonSource, SpikeRecorder
from nrp_core.clock import NS_PER_MS

from nrp_brain_pynn import PyNNBackend

OWN_RUN = {
    "neuron": ("pyNN.neuron", "run_until"),
    "brian2": ("nrp_brain_pynn.stepping", "SteppedRun.until"),
}
EYES = {"left": [0, 2], "right": [1, 3], "green_blue": [4]}
BLOCKS = 5


class Stopwatch:
    """Adds up the CPU time of a function of a module, in whose place it stands."""

    def __init__(self, module: str, path: str) -> None:
        owner: Any = import_module(module)
        *outer, name = path.split(".")
        for part in outer:
            owner = getattr(owner, part)
        self.spent_s, timed = 0.0, getattr(owner, name)

        def run(*arguments: Any, **keywords: Any) -> Any:
            began = time.process_time()
            try:
                return timed(*arguments, **keywords)
            finally:
                self.spent_s += time.process_time() - began

        setattr(owner, name, run)


def measure(simulator: str, steps: int) -> tuple[list[float], float]:
    """Return CPU microseconds a step in each block, and the ratio of steps to the simulator's own calls."""
    backend = PyNNBackend()
    options = backend.options(simulator=simulator)
    network = load_network(Path(str(files("nrp_experiments.braitenberg_husky"))) / "brain.py")
    rng = np.random.default_rng(1)
    with backend.open(network, seed=1, options=options) as brain:
        eyes = [brain.add_source(PoissonSource(), ids, name=eye) for eye, ids in EYES.items()]
        wheels = [brain.add_sink(LeakyIntegratorAlpha(), [cell], name=f"wheel {cell}") for cell in (6, 7)]
        brain.add_sink(SpikeRecorder(), np.arange(8), name="all")

        def step() -> None:
            for eye, rate in zip(eyes, rng.uniform(0.0, 2000.0, 3).tolist(), strict=True):
                eye.rate = rate  # type: ignore[attr-defined]
            brain.run_until(brain.now_ns + 20 * NS_PER_MS)
            for wheel in wheels:
                assert wheel.voltage is not None  # type: ignore[attr-defined]

        for _ in range(20):
            step()
        own = Stopwatch(*OWN_RUN[simulator])
        blocks = [timed(step, steps // BLOCKS) for _ in range(BLOCKS)]
    return blocks, sum(blocks) * (steps // BLOCKS) / (own.spent_s * 1e6)


def timed(step: Callable[[], None], times: int) -> float:
    began = time.process_time()
    for _ in range(times):
        step()
    return (time.process_time() - began) / times * 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("simulators", nargs="+", choices=list(OWN_RUN))
    parser.add_argument("--steps", type=int, default=1000)
    arguments = parser.parse_args()
    for simulator in arguments.simulators:
        blocks, ratio = measure(simulator, arguments.steps)
        print(
            f"{simulator:8s} us a step, by fifths: {[round(us) for us in blocks]}, {ratio:.2f} x its own run"
        )


if __name__ == "__main__":
    main()
