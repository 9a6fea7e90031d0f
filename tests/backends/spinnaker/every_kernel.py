"""Run every kernel of the spinnaker backend for a while and print a digest of all its state."""

import hashlib
import pickle
from dataclasses import replace

import numpy as np
from nrp_brain_spinnaker import SpinnakerBackend, SpinnakerOptions

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.network.cells import CELLS as TYPES
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.rewiring import Neuromodulation, Rewiring
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

LEAKY = {
    "v_rest": -65.0, "cm": 1.0, "tau_m": 20.0, "tau_refrac": 2.0, "v_reset": -65.0, "v_thresh": -50.0,
    "tau_syn_E": 5.0, "tau_syn_I": 7.0, "e_rev_E": 0.0, "e_rev_I": -70.0, "i_offset": 1.5,
}  # fmt: skip
ADAPTIVE = LEAKY | {"v_spike": -40.0, "delta_T": 2.0, "a": 4.0, "b": 0.08, "tau_w": 144.0}
HODGKIN_HUXLEY = {
    "gbar_Na": 20.0, "gbar_K": 6.0, "g_leak": 0.01, "cm": 0.2, "v_offset": -63.0, "e_rev_Na": 50.0,
    "e_rev_K": -90.0, "e_rev_leak": -65.0, "i_offset": 0.9,
}  # fmt: skip
IZHIKEVICH = {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "i_offset": 0.02}
CELLS = {
    **dict.fromkeys(("IF_curr_exp", "IF_cond_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_alpha"), LEAKY),
    "Izhikevich": IZHIKEVICH,
    "IZK_cond_exp": IZHIKEVICH | {"i_offset": 20.0},
    "EIF_cond_alpha_isfa_ista": ADAPTIVE,
    "HH_cond_exp": HODGKIN_HUXLEY,
}
SIZE = 3
RULE = {"tau_plus": 20.0, "tau_minus": 20.0, "A_plus": 0.1, "A_minus": 0.12, "w_min": 0.0, "w_max": 1.0}
VOGELS = {"tau": 20.0, "eta": 0.05, "rho": 3.0, "w_min": 0.0, "w_max": 1.0}
SHORT_TERM = {"U": 0.5, "tau_rec": 100.0, "tau_facil": 50.0}


def population(cell_type: str, parameters: dict[str, float]) -> Population:
    initial = {"v": np.full(SIZE, -65.0)}
    defaults = {name: each.default for name, each in TYPES[cell_type].parameters.items()}
    values = {name: np.full(SIZE, float(parameters.get(name, value))) for name, value in defaults.items()}
    return Population(cell_type, SIZE, cell_type, values, initial)


def projection(
    pre: str, post: str, weight: float, kind: str, parameters: dict[str, float], rule: str = "",
    timing: str = "SpikePairRule",
) -> Projection:  # fmt: skip
    index = np.arange(SIZE * SIZE, dtype=np.int32)
    n = len(index)
    return Projection(
        f"{pre}-{post}-{kind}-{rule}-{weight}", pre, post, "excitatory" if weight > 0 else "inhibitory",
        index // SIZE, index % SIZE, np.linspace(weight, weight / 2, n), np.linspace(1, 9, n), kind,
        {name: np.full(n, value) for name, value in parameters.items()}, {"t": timing, "w": rule},
    )  # fmt: skip


def network() -> Network:
    trains = tuple(np.arange(1.0 + i, 60.0, 5.0 + i) for i in range(SIZE))
    rates = {"rate": [5.0, 300.0, 20000.0], "start": [0.0] * SIZE, "duration": [np.inf] * SIZE}
    populations = {
        "array": Population("array", SIZE, "SpikeSourceArray", {}, {}, trains),
        "poisson": Population(
            "poisson", SIZE, "SpikeSourcePoisson", {k: np.array(v) for k, v in rates.items()}
        ),
        **{cell_type: population(cell_type, parameters) for cell_type, parameters in CELLS.items()},
    }
    projections = []
    for post in CELLS:
        weight = 0.002 if "cond" in post else 0.5
        projections += [
            projection("array", post, weight, STATIC, {}),
            projection("poisson", post, weight / 20, TSODYKS_MARKRAM, SHORT_TERM),
        ]
    for rule in ("AdditiveWeightDependence", "MultiplicativeWeightDependence"):
        projections.append(projection("array", "IF_curr_exp", 0.5, STDP, RULE, rule))
    projections.append(projection("IF_curr_exp", "IF_curr_alpha", -0.5, STATIC, {}))
    additive = "AdditiveWeightDependence"
    projections.append(projection("array", "IF_curr_alpha", 0.5, STDP, VOGELS, additive, "Vogels2011Rule"))
    triplets = {"tau_x": 100.0, "tau_y": 120.0, "A3_plus": 0.02, "A3_minus": 0.03}
    for post, timing in (
        ("IF_curr_delta", "SpikeNearestPairRule"),
        ("IZK_cond_exp", "PfisterSpikeTripletRule"),
    ):
        projections.append(projection("array", post, 0.5, STDP, RULE | triplets, additive, timing))
    reward = projection("IF_curr_delta", "IF_curr_exp", 0.5, STATIC, {}, "reward")
    projections.append(
        replace(reward, receptor="reward", delay_ms=np.ones(reward.size), neuromodulation=Neuromodulation())
    )
    for partner in ("RandomSelection", "LastNeuronSelection"):
        rewiring = Rewiring(partner, prob_elim_potentiated=0.5, initial_weight=0.002, p_form_forward=0.9)
        post = "IF_cond_exp" if partner == "RandomSelection" else "IF_cond_alpha"
        one = projection("array", post, 0.001, STATIC, {}, partner)
        projections.append(replace(one, rewiring=rewiring))
    return Network(populations, tuple(projections))


def main() -> None:
    digest, model = hashlib.blake2b(digest_size=16), network()
    for semantics in ("pynn", "released"):
        options = SpinnakerOptions.model_validate({"poisson": "machine", "semantics": semantics})
        brain = SpinnakerBackend().open(model, seed=3, options=options)
        brain.add_source(PoissonSource(rate=300.0, weight=0.01), np.arange(6, 9), name="device")
        recorder = brain.add_sink(SpikeRecorder(), np.arange(model.size), name="all")
        brain.run_until(30_000_000)
        spikes = recorder.spikes()
        digest.update(spikes.neurons.tobytes() + spikes.times_ms.tobytes())
        digest.update(pickle.dumps(brain._do_save()))
        fired = {model.label_of(int(neuron))[0] for neuron in np.unique(spikes.neurons)} & CELLS.keys()
        print(semantics, len(spikes), f"{len(fired)} cell types fired", digest.hexdigest())


main()
