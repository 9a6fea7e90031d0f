"""The network of microcircuit_pynn.py in NEST, for an interpreter that has it."""

from __future__ import annotations

import argparse
import json
import resource
import time
from typing import Any

import microcircuit_model as model
import nest
import numpy as np


def build(scale: float, threads: int, seed: int) -> list[Any]:
    """Build the network; return a recorder for each population."""
    nest.ResetKernel()
    nest.set(resolution=model.STEP_MS, local_num_threads=threads, rng_seed=seed)
    populations, recorders = [], []
    rates, currents = model.input_hz(scale), model.constant_na(scale)
    for k in range(len(model.LABELS)):
        cell = model.CELL
        parameters = {
            "C_m": 1e3 * cell["cm"], "tau_m": cell["tau_m"], "t_ref": cell["tau_refrac"],
            "tau_syn_ex": cell["tau_syn_E"], "tau_syn_in": cell["tau_syn_I"], "E_L": cell["v_rest"],
            "V_reset": cell["v_reset"], "V_th": cell["v_thresh"], "I_e": 1e3 * currents[k],
        }  # fmt: skip
        cells = nest.Create("iaf_psc_exp", int(model.sizes(scale)[k]), params=parameters)
        cells.V_m = nest.random.normal(*model.START_MV)
        noise = nest.Create("poisson_generator", params={"rate": rates[k]})
        weight = 1e3 * model.WEIGHT_NA / np.sqrt(scale)
        nest.Connect(noise, cells, syn_spec={"weight": weight, "delay": model.DELAY_MS["E"]})
        recorder = nest.Create("spike_recorder")
        nest.Connect(cells[: model.OBSERVED], recorder)
        populations.append(cells)
        recorders.append(recorder)
    for label in model.LABELS:  # NEST has room for 134 million synapses of a model
        nest.CopyModel("static_synapse", f"onto {label}")
    for target, source in np.argwhere(model.PROBABILITIES > 0):
        _connect(populations, int(target), int(source), scale)
    return recorders


def _connect(populations: list[Any], target: int, source: int, scale: float) -> None:
    kind = model.LABELS[source][-1]
    mean = 1e3 * model.weights_na(scale)[target, source]
    low, high = (0.0, np.inf) if kind == "E" else (-np.inf, 0.0)
    weight = nest.random.normal(mean, abs(mean) * model.spread(target, source))
    delay_ms = model.DELAY_MS[kind]
    delay = nest.random.normal(delay_ms, delay_ms * model.DELAY_SPREAD)
    nest.Connect(
        populations[source], populations[target],
        {"rule": "fixed_total_number", "N": int(model.synapses(scale)[target, source])},
        {
            "synapse_model": f"onto {model.LABELS[target]}",
            "weight": nest.math.redraw(weight, min=low, max=high),
            # NEST rounds after it has redrawn
            "delay": nest.math.redraw(delay, min=model.STEP_MS - 0.5 * nest.resolution, max=np.inf),
        },
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scale", type=float, default=0.1)
    parser.add_argument("--warm-up", type=float, default=100.0, help="ms")
    parser.add_argument("--duration", type=float, default=1000.0, help="ms")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    nest.verbosity = nest.VerbosityLevel.ERROR
    began, first = time.process_time(), time.perf_counter()
    recorders = build(asked.scale, asked.threads, asked.seed)
    built = time.process_time()
    nest.Simulate(asked.warm_up)
    ready, elapsed = time.process_time(), time.perf_counter() - first
    nest.Simulate(asked.duration)
    cost = time.process_time() - ready
    found = {}
    for label, size, recorder in zip(model.LABELS, model.sizes(asked.scale), recorders, strict=True):
        events = recorder.get("events")
        order = np.argsort(events["senders"], kind="stable")
        _, begins = np.unique(events["senders"][order], return_index=True)
        trains = [np.asarray(train) for train in np.split(events["times"][order], begins[1:])]
        trains += [np.empty(0)] * (min(int(size), model.OBSERVED) - len(trains))
        found[label] = model.statistics(trains, asked.warm_up, asked.warm_up + asked.duration)
    report = {
        "scale": asked.scale,
        "synapses": int(model.synapses(asked.scale).sum()),
        "build_cpu_s": built - began,
        "to_start_cpu_s": ready - began,
        "to_start_s": elapsed,
        "s_per_s": cost / asked.duration * 1e3,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "statistics": found,
    }
    print(model.table(found, asked.scale))
    print(json.dumps(report))


if __name__ == "__main__":
    main()
