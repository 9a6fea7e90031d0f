"""A network of benchmarks/networks.py in Brian2's C++ standalone mode, for an interpreter that has it."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

import brian2 as b2
import measure
import numpy as np
from graphs import Graph

_EQUATIONS = {
    "cuba": """dv/dt = (R*(x + y) + v_rest - v)/tau_m : volt (unless refractory)
               dx/dt = -x/tau_e : amp
               dy/dt = -y/tau_i : amp""",
    "coba": """dv/dt = (v_rest - v)/tau_m + (x*(e_e - v) + y*(e_i - v))/c_m : volt (unless refractory)
               dx/dt = -x/tau_e : siemens
               dy/dt = -y/tau_i : siemens""",
    "brunel": "dv/dt = (v_rest - v)/tau_m : volt (unless refractory)",
}
_UNIT = {"cuba": b2.nA, "coba": b2.uS, "brunel": b2.mV}
_METHOD = {"cuba": "exact", "coba": "exponential_euler", "brunel": "exact"}


def build(graph: Graph) -> b2.Network:
    b2.defaultclock.dt = measure.STEP_MS * b2.ms
    cells, model = graph.cells, graph.model
    space = {
        "v_rest": cells["v_rest"] * b2.mV, "v_reset": cells["v_reset"] * b2.mV,
        "v_thresh": cells["v_thresh"] * b2.mV, "tau_m": cells["tau_m"] * b2.ms, "c_m": cells["cm"] * b2.nF,
        "R": cells["tau_m"] / cells["cm"] * b2.Mohm,
        **{name: cells.get(key, 0.0) * unit for name, key, unit in (
            ("tau_e", "tau_syn_E", b2.ms), ("tau_i", "tau_syn_I", b2.ms),
            ("e_e", "e_rev_E", b2.mV), ("e_i", "e_rev_I", b2.mV),
        )},
    }  # fmt: skip
    neurons = b2.NeuronGroup(
        graph.n, _EQUATIONS[model], threshold="v >= v_thresh", reset="v = v_reset", method=_METHOD[model],
        refractory=cells["tau_refrac"] * b2.ms, namespace=space,
    )  # fmt: skip
    neurons.v = graph.initial["v"] * b2.mV
    if model == "coba":
        neurons.x, neurons.y = graph.initial["gsyn_exc"] * b2.uS, graph.initial["gsyn_inh"] * b2.uS
    network = b2.Network(neurons)
    for kind, weight in enumerate(graph.weight):
        variable = "v" if model == "brunel" else "xy"[kind]
        pre, post = graph.pre(kind), graph.post(kind)
        order = np.argsort(pre, kind="stable")  # in which they are used
        own = None if graph.own_weights is None else graph.own_weights[kind]
        unit = {"cuba": "amp", "coba": "siemens", "brunel": "volt"}[model]
        synapses = b2.Synapses(
            neurons, neurons, "" if own is None else f"w : {unit}", on_pre=f"{variable}_post += w",
            delay=None if graph.own_delays is not None else graph.delay * b2.ms,
            namespace={} if own is not None else {"w": weight * _UNIT[model]},
        )  # fmt: skip
        synapses.connect(i=pre[order].astype(np.int32), j=post[order].astype(np.int32))
        if own is not None:
            synapses.w = own.reshape(-1)[order] * _UNIT[model]
        if graph.own_delays is not None:
            synapses.delay = graph.own_delays[kind].reshape(-1)[order] * b2.ms
        network.add(synapses)
    rate, weight = graph.noise
    if rate:
        network.add(b2.PoissonInput(neurons, "v", 1000, rate / 1000 * b2.Hz, weight * b2.mV))
    network.add(b2.SpikeMonitor(neurons, record=False))
    return network


def run_alone(directory: str) -> tuple[float, float, float]:
    """Run the compiled program; return CPU seconds of all and of the simulation, and its peak memory."""
    began = os.times()
    process = subprocess.Popen(["./main"], cwd=directory, stdout=subprocess.PIPE, text=True)
    _, _, usage = os.wait4(process.pid, 0)
    assert process.stdout is not None
    lines = [line for line in process.stdout.read().splitlines() if line.startswith("simulated")]
    del began
    cpu = usage.ru_utime + usage.ru_stime
    return cpu, float(lines[-1].split()[1]), usage.ru_maxrss / 1024


chosen = measure.arguments()
graph = measure.graph_of(chosen)
with tempfile.TemporaryDirectory() as directory:
    b2.set_device("cpp_standalone", build_on_run=False, directory=directory)
    if chosen.threads > 1:
        b2.prefs.devices.cpp_standalone.openmp_threads = chosen.threads
    network = build(graph)
    device = b2.get_device()
    network.run(chosen.warm_up * b2.ms)
    device.insert_code("before_network_run", "std::clock_t began_ = std::clock();")
    device.insert_code(
        "after_network_run",
        'std::printf("simulated %f\\n", double(std::clock() - began_) / CLOCKS_PER_SEC);std::fflush(stdout);',
    )
    network.run(chosen.duration * b2.ms)
    began = time.process_time()
    device.build(directory=directory, compile=True, run=False)
    found = [run_alone(directory) for _ in range(chosen.chunks)]
    count = np.fromfile(next(Path(directory, "results").glob("_array_spikemonitor_N_*")), np.int32)
rate = float(count[0]) / graph.n / ((chosen.duration + chosen.warm_up) * 1e-3)
costs = [simulated / chosen.duration * 1e3 for _, simulated, _ in found]
measure.report(build_s=min(cpu for cpu, _, _ in found), costs=costs, rate_hz=rate, peak_mb=found[0][2])
