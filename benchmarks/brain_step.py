"""The cost of a 20 ms step of the Braitenberg brain, with three rates written and two integrators read.

The brain is that of the shipped experiment; all its spikes are recorded. NEST runs the same network where
it can be imported, with the calls that a closed loop needs (set the rates, simulate, read two voltages),
at its grid of 0.1 ms on one thread. CPU time, best of several rounds in which all take turns; every step
has new rates.

    python benchmarks/brain_step.py
    python benchmarks/brain_step.py --brains event "event:resolution=0.1 ms" spinnaker --rounds 5 --json
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from conditions import print_conditions

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha, SpikeRecorder
from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network
from nrp_core.network.files.script import load_network

STEP_MS = 20
LARGEST_RATE_HZ = 2000.0
EYES = {"left": [0, 2], "right": [1, 3], "green_blue": [4]}
WHEELS = [6, 7]
WIDTHS = {"brain": 24}

Step = Callable[[list[float]], None]
Spikes = Callable[[], int]


def braitenberg() -> Network:
    return load_network(Path(str(files("nrp_experiments.braitenberg_husky"))) / "brain.py")


@contextmanager
def backend(name: str, network: Network) -> Iterator[tuple[Step, Spikes]]:
    """One of our brains, through the interface that the loop uses; ``name`` or ``name:option=value``."""
    name, _, given = name.partition(":")
    chosen = brains().load(name)
    options = chosen.options.model_validate(dict([given.split("=")]) if given else {})
    with chosen.open(network, seed=1, options=options) as brain:
        eyes = [brain.add_source(PoissonSource(), ids, name=eye) for eye, ids in EYES.items()]
        wheels = [brain.add_sink(LeakyIntegratorAlpha(), [cell], name=f"wheel {cell}") for cell in WHEELS]
        recorder = brain.add_sink(SpikeRecorder(), np.arange(8), name="all")

        def step(rates_hz: list[float]) -> None:
            for eye, rate in zip(eyes, rates_hz, strict=True):
                eye.rate = rate  # type: ignore[attr-defined]
            brain.run_until(brain.now_ns + STEP_MS * NS_PER_MS)
            for wheel in wheels:
                assert wheel.voltage is not None  # type: ignore[attr-defined]

        yield step, lambda: len(recorder.spikes())  # type: ignore[attr-defined]


@contextmanager
def nest_alone(network: Network) -> Iterator[tuple[Step, Spikes]]:
    """NEST's own calls on the same network."""
    import nest

    nest.verbosity = nest.VerbosityLevel.ERROR
    nest.ResetKernel()
    (cells,) = network.populations.values()
    neurons = nest.Create("iaf_cond_alpha", cells.size)
    to_nest = {
        "E_L": ("v_rest", 1), "V_reset": ("v_reset", 1), "V_th": ("v_thresh", 1), "t_ref": ("tau_refrac", 1),
        "C_m": ("cm", 1e3), "E_ex": ("e_rev_E", 1), "E_in": ("e_rev_I", 1),
        "tau_syn_ex": ("tau_syn_E", 1), "tau_syn_in": ("tau_syn_I", 1),
    }  # fmt: skip
    parameters = {ours: cells.parameters[theirs] * factor for ours, (theirs, factor) in to_nest.items()}
    neurons.set(**parameters, g_L=1e3 * cells.parameters["cm"] / cells.parameters["tau_m"], V_m=-60.5)
    for projection in network.projections:
        sign = 1e3 if projection.receptor == "excitatory" else -1e3
        for pre, post, weight in zip(
            projection.pre_index, projection.post_index, projection.weight, strict=True
        ):
            synapse = {"synapse_model": "tsodyks_synapse", "weight": sign * weight, "delay": 0.1}
            dynamics = {"U": 1.0, "tau_rec": 1.0, "tau_fac": 1.0, "tau_psc": 2.5}
            nest.Connect(neurons[int(pre)], neurons[int(post)], syn_spec=synapse | dynamics)
    eyes = nest.Create("poisson_generator", len(EYES))
    for eye, ids in zip(eyes, EYES.values(), strict=True):
        nest.Connect(eye, neurons[ids], syn_spec={"weight": 0.15, "delay": 0.1})
    leaky = {"V_th": 1e9, "C_m": 1e3, "tau_m": 10.0, "tau_syn_ex": 2.0, "E_L": 0.0, "V_m": 0.0}
    wheels = nest.Create("iaf_psc_alpha", len(WHEELS), params=leaky)
    nest.Connect(neurons[WHEELS], wheels, "one_to_one", syn_spec={"weight": 10.0, "delay": 0.1})
    recorder = nest.Create("spike_recorder")
    nest.Connect(neurons, recorder)

    def step(rates_hz: list[float]) -> None:
        eyes.rate = rates_hz
        nest.Simulate(STEP_MS)
        assert len(wheels.get("V_m")) == len(WHEELS)

    yield step, lambda: int(recorder.n_events)


def measure(step: Step, rates_hz: np.ndarray) -> float:
    """Return CPU microseconds for a step."""
    rows = rates_hz.tolist()
    began = time.process_time()
    for row in rows:
        step(row)
    return (time.process_time() - began) / len(rows) * 1e6


def row(name: str, costs_us: list[float], spikes_a_step: float, nest_us: float | None) -> dict[str, Any]:
    best = min(costs_us)
    return {
        "brain": name,
        "us_per_step": round(best, 1),
        "times_faster_than_nest": "-" if nest_us is None else round(nest_us / best, 2),
        "times_real_time": round(STEP_MS * 1e3 / best, 1),
        "spikes_a_step": round(spikes_a_step, 2),
    }


def compare(names: list[str], steps: int, rounds: int) -> list[dict[str, Any]]:
    """Run all brains in turn; the first round is the warm-up."""
    network, rng = braitenberg(), np.random.default_rng(1)
    with ExitStack() as stack:
        runs = {name: stack.enter_context(backend(name, network)) for name in names}
        if importlib.util.find_spec("nest"):
            runs["nest"] = stack.enter_context(nest_alone(network))
        costs: dict[str, list[float]] = {name: [] for name in runs}
        for _ in range(rounds + 1):
            rates_hz = rng.uniform(0.0, LARGEST_RATE_HZ, (steps, len(EYES)))
            for name, (step, _) in runs.items():
                costs[name].append(measure(step, rates_hz))
        nest_us = min(costs["nest"][1:]) if "nest" in costs else None
        total = steps * (rounds + 1)
        return [row(name, costs[name][1:], spikes() / total, nest_us) for name, (_, spikes) in runs.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--brains", nargs="+", default=["event"])
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    print_conditions()
    rows = compare(arguments.brains, arguments.steps, arguments.rounds)
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return
    for line in (dict(zip(rows[0], rows[0], strict=True)), *rows):
        print("  ".join(f"{value!s:>{WIDTHS.get(key, len(key))}}" for key, value in line.items()))


if __name__ == "__main__":
    main()
