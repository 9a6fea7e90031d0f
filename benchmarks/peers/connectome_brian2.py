"""The brain of benchmarks/connectome.py in Brian2's C++ standalone mode, for an interpreter that has it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import brian2 as b2
import numpy as np

_EQUATIONS = """
dv/dt = (g - (v - v_0))/t_m : volt (unless refractory)
dg/dt = -g/tau : volt (unless refractory)
rfc : second
"""
_KICK = "g += 20000*mV"

graph, duration = np.load(sys.argv[1]), float(sys.argv[2]) * b2.ms
with tempfile.TemporaryDirectory() as directory:
    b2.set_device("cpp_standalone", build_on_run=False, directory=directory)
    b2.defaultclock.dt = 0.1 * b2.ms
    n = 138_639
    neurons = b2.NeuronGroup(
        n, _EQUATIONS, method="linear", threshold="v > -45*mV", reset="v = v_0; g = 0*mV", refractory="rfc",
        namespace={"v_0": -52 * b2.mV, "t_m": 20 * b2.ms, "tau": 5 * b2.ms},
    )  # fmt: skip
    refractory = np.full(n, 2.2)
    refractory[graph["driven"]] = 0.0
    neurons.v, neurons.rfc = -52 * b2.mV, refractory * b2.ms
    synapses = b2.Synapses(neurons, neurons, "w : volt", on_pre="g += w", delay=1.8 * b2.ms)
    synapses.connect(i=graph["pre"], j=graph["post"])
    synapses.w = graph["weight"] * b2.mV
    driven = graph["driven"]
    own = np.searchsorted(driven, graph["cells"])
    source = b2.SpikeGeneratorGroup(len(driven), own, graph["steps"] * 0.1 * b2.ms)
    kick = b2.Synapses(source, neurons, on_pre=_KICK)
    kick.connect(i=np.arange(len(driven)), j=driven)
    monitor = b2.SpikeMonitor(neurons, record=False)
    network = b2.Network(neurons, synapses, source, kick, monitor)
    device = b2.get_device()
    network.run(1 * b2.ms)
    device.insert_code("before_network_run", "std::clock_t began_ = std::clock();")
    device.insert_code(
        "after_network_run",
        'std::printf("simulated %f\\n", double(std::clock() - began_) / CLOCKS_PER_SEC);std::fflush(stdout);',
    )
    network.run(duration - 1 * b2.ms)
    device.build(directory=directory, compile=True, run=False)
    done = subprocess.run(["./main"], cwd=directory, capture_output=True, text=True, check=True)
    spent = float([line for line in done.stdout.splitlines() if line.startswith("simulated")][-1].split()[1])
    count = np.fromfile(next(Path(directory, "results").glob("_array_spikemonitor_N_*")), np.int32)[0]
print(f"{spent / float(duration):.3f} CPU s/s   {count} spikes")
