"""Deviation of PyNN's simulators from continuous time, by the references in ``tests/backends/event/oracles``.

Errors in the spike times of single neurons with a current or spike trains as input, at two time steps: errors
due to the step decrease with it.

    python benchmarks/agreement.py neuron brian2
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from nrp_core.brain import DCSource, Network, Population, Projection, SpikeRecorder
from nrp_core.clock import from_milliseconds

from nrp_brain_pynn import PyNNBackend
from nrp_brain_pynn.simulators import SIMULATORS

ORACLES = Path(__file__).parents[3] / "tests" / "backends" / "event" / "oracles"
DELAY_MS = 0.1


def network(case: dict[str, Any]) -> tuple[Network, dict[float, float]]:
    """Return a case as a network, and the current from each time on."""
    meta = json.loads(str(case["meta"]))
    parameters = {name: np.array([float(value)]) for name, value in meta["params"].items()}
    cell = Population("cell", 1, meta["model"], parameters, {"v": np.array([float(meta["v0"])])})
    populations, projections = {"cell": cell}, []
    for label, receptor, weight in (("exc", "excitatory", "w_e"), ("inh", "inhibitory", "w_i")):
        if len(case[label]):
            trains = (np.sort(case[label]) - DELAY_MS,)  # the times are those of arrival
            populations[label] = Population(label, 1, "SpikeSourceArray", {}, {}, trains)
            index, of = np.zeros(1, np.int32), np.array([meta[weight], DELAY_MS], float)
            synapse = Projection(label, label, "cell", receptor, index, index, of[:1], of[1:])
            projections.append(synapse)
    return Network(populations, tuple(projections)), dict(case["steps"].tolist())


def errors(simulator: str, path: Path, timestep: str) -> tuple[int, int, float, float]:
    """Return the numbers of spikes here and there, the first one's error, and the median error, ms.

    The median is over the distances of the reference's spikes to the nearest one found: where a membrane
    comes within a hair of the threshold, a simulator with a step may gain or lose a spike.
    """
    with np.load(path) as arrays:
        case = {name: arrays[name] for name in arrays.files}
    made, currents = network(case)
    backend = PyNNBackend()
    with backend.open(made, seed=1, options=backend.options(simulator=simulator, timestep=timestep)) as brain:
        recorder = brain.add_sink(SpikeRecorder(), [0], name="spikes")
        electrode = brain.add_source(DCSource(), [0], name="current")
        for time_ms, amplitude in sorted(currents.items()):
            brain.run_until(from_milliseconds(time_ms))
            electrode.amplitude = amplitude  # type: ignore[attr-defined]
        brain.run_until(from_milliseconds(float(case["truth_t"][-1])))
        found = recorder.spikes().times_ms  # type: ignore[attr-defined]
    truth = case["truth_spikes"]
    off = np.abs(truth[:, None] - found).min(axis=1)
    return len(found), len(truth), float(off[0]), float(np.median(off))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("simulators", nargs="+", choices=list(SIMULATORS))
    parser.add_argument("--timesteps", nargs="+", default=["0.1 ms", "0.01 ms"])
    arguments = parser.parse_args()
    for simulator in arguments.simulators:
        for path in sorted(ORACLES.glob("*.npz")):
            if path.stem.partition("__")[0] in SIMULATORS[simulator].cells:
                for timestep in arguments.timesteps:
                    n, of, first, median = errors(simulator, path, timestep)
                    print(
                        f"{simulator:8s}{path.stem:32s}{timestep:>8s}  {n}/{of} spikes, "
                        f"first off by {first:.3f} ms, median {median:.3f} ms",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
