"""A network of benchmarks/networks.py in NEST, for an interpreter that has it."""

from __future__ import annotations

import time
from typing import Any

import measure
import nest
import numpy as np
from graphs import Graph, Values

_MODELS = {"cuba": "iaf_psc_exp", "coba": "iaf_cond_exp", "brunel": "iaf_psc_delta"}
_PER_UNIT = {"cuba": 1e3, "coba": 1e3, "brunel": 1.0}
_STATES = {"v": ("V_m", 1.0), "gsyn_exc": ("g_ex", 1e3), "gsyn_inh": ("g_in", 1e3)}
_AT_ONCE = 5_000_000
_MOST = 100_000_000
"""Synapses of one model; NEST takes at most 2**27 in a thread."""


def build(graph: Graph) -> tuple[Any, Any]:
    nest.ResetKernel()
    nest.resolution = measure.STEP_MS
    nest.local_num_threads = chosen.threads
    cells = graph.cells
    parameters = {
        "E_L": cells["v_rest"], "V_reset": cells["v_reset"], "V_th": cells["v_thresh"],
        "t_ref": cells["tau_refrac"], "C_m": 1e3 * cells["cm"], "I_e": 1e3 * cells["i_offset"],
    }  # fmt: skip
    if graph.model == "coba":
        parameters |= {
            "g_L": 1e3 * cells["cm"] / cells["tau_m"],
            "E_ex": cells["e_rev_E"],
            "E_in": cells["e_rev_I"],
        }
    else:
        parameters["tau_m"] = cells["tau_m"]
    if graph.model != "brunel":
        parameters |= {"tau_syn_ex": cells["tau_syn_E"], "tau_syn_in": cells["tau_syn_I"]}
    neurons = nest.Create(_MODELS[graph.model], graph.n, params=parameters)
    neurons.set(**{_STATES[name][0]: values * _STATES[name][1] for name, values in graph.initial.items()})
    _connect(graph)
    rate, weight = graph.noise
    if rate:
        noise = nest.Create("poisson_generator", params={"rate": rate})
        nest.Connect(noise, neurons, syn_spec={"weight": weight, "delay": graph.delay})
    recorder = nest.Create("spike_recorder")
    nest.Connect(neurons, recorder)
    return neurons, recorder


def _connect(graph: Graph) -> None:
    per_unit = _PER_UNIT[graph.model]
    for kind, weight in enumerate(graph.weight):
        signed = weight if graph.model != "coba" or kind == 0 else -weight
        pre, post = graph.pre(kind) + 1, graph.post(kind) + 1
        alike = graph.own_weights is None and graph.own_delays is None
        spec: dict[str, Values] = {}
        if not alike:
            spec["weight"] = (
                np.full(len(pre), weight) if graph.own_weights is None else graph.own_weights[kind]
            )
            spec["delay"] = (
                np.full(len(pre), graph.delay) if graph.own_delays is None else graph.own_delays[kind]
            )
        for first in range(0, len(pre), _AT_ONCE):
            some, name = slice(first, first + _AT_ONCE), f"synapse_{kind}_{first // _MOST}"
            if first % _MOST == 0:
                common = {"weight": signed * per_unit, "delay": graph.delay}
                nest.CopyModel(
                    "static_synapse_hom_w" if alike else "static_synapse", name, common if alike else {}
                )
            values = {key: np.ravel(value)[some] for key, value in spec.items()}
            if values:
                values["weight"] = values["weight"] * per_unit
            nest.Connect(pre[some], post[some], "one_to_one", {"synapse_model": name, **values})


nest.verbosity = nest.VerbosityLevel.ERROR
chosen = measure.arguments()
graph = measure.graph_of(chosen)
began = time.process_time()
_, recorder = build(graph)
nest.Simulate(measure.STEP_MS)
build_s = time.process_time() - began
if chosen.warm_up > measure.STEP_MS:
    nest.Simulate(chosen.warm_up - measure.STEP_MS)
spikes = recorder.events
before = recorder.n_events
costs = measure.chunks(lambda: nest.Simulate(chosen.duration), chosen.chunks, chosen.duration)
rate = (recorder.n_events - before) / graph.n / (chosen.duration * max(chosen.chunks, 1) * 1e-3)
measure.report(
    build_s=build_s, costs=costs, rate_hz=rate, digest=measure.digest(spikes["senders"] - 1, spikes["times"])
)
