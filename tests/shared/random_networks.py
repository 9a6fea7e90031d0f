"""Random networks, and their spikes on a backend or in two parts."""

from typing import Any

import numpy as np

from nrp_core.brain import Network, Population, Projection, SpikeRecorder, Spikes
from nrp_core.brain.backends import brains
from nrp_core.network.cells import CELLS
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

LABELS = ("a", "b", "c")
_VALUES: dict[str, dict[str, float]] = {
    STATIC: {},
    TSODYKS_MARKRAM: {"U": 0.4, "tau_rec": 50.0, "tau_facil": 20.0},
    STDP: {
        "A_plus": 0.05, "A_minus": 0.04, "tau_plus": 20.0, "tau_minus": 15.0, "w_min": 0.0, "w_max": 3.0,
        "dendritic_delay_fraction": 1.0,
    },
}  # fmt: skip
_RULES = {"timing_dependence": "SpikePairRule", "weight_dependence": "AdditiveWeightDependence"}


def _cells(rng: np.random.Generator, label: str) -> Population:
    n, kind = int(rng.integers(1, 6)), CELLS["IF_curr_exp"]
    parameters = {name: np.full(n, float(one.default)) for name, one in kind.parameters.items()}
    parameters["i_offset"] = rng.uniform(0.5, 1.3, n)
    return Population(label, n, "IF_curr_exp", parameters, {"v": np.full(n, -65.0)})


def _projection(
    rng: np.random.Generator, number: int, populations: dict[str, Population], law: str, step_ms: float,
    shortest: int,
) -> Projection:  # fmt: skip
    pre, post = (populations[name] for name in rng.choice([*populations], 2))
    post = post if not post.is_source else populations["a"]
    n, sign = int(rng.integers(1, 12)), -1.0 if law == STATIC and rng.random() < 0.3 else 1.0
    delays_ms = np.maximum(np.round(rng.uniform(0.0, 4.0, n) / step_ms), shortest) * step_ms
    values = {name: np.full(n, value) for name, value in _VALUES[law].items()}
    return Projection(
        f"p{number}", pre.label, post.label, "inhibitory" if sign < 0 else "excitatory",
        rng.integers(0, pre.size, n), rng.integers(0, post.size, n), sign * rng.uniform(0.2, 2.0, n),
        delays_ms, law, values, _RULES if law == STDP else {},
    )  # fmt: skip


def network(seed: int, step_ms: float, laws: tuple[str, ...] = (STATIC,), shortest: int = 1) -> Network:
    """Return a random network: three populations and a noise, and six projections between any of them.

    Args:
        seed: the seed.
        step_ms: of the delays, ms.
        laws: the synapse types of the projections, in turn.
        shortest: the shortest possible delay in steps.
    """
    rng = np.random.default_rng(seed)
    populations = {label: _cells(rng, label) for label in LABELS}
    rate = {"rate": np.full(2, 80.0), "start": np.zeros(2), "duration": np.full(2, 1e10)}
    populations["noise"] = Population("noise", 2, "SpikeSourcePoisson", rate)
    made = [_projection(rng, i, populations, laws[i % len(laws)], step_ms, shortest) for i in range(6)]
    return Network(populations, tuple(made))


def spikes_of(backend: str, network: Network, options: dict[str, Any], stops_ms: tuple[int, ...]) -> Spikes:
    """Return the spikes of a network that runs to some times."""
    found = brains().load(backend)
    with found.open(network, seed=3, options=found.options.model_validate(options)) as brain:
        sink = brain.add_sink(SpikeRecorder(), np.arange(network.size), name="all")
        for stop_ms in stops_ms:
            brain.run_until(stop_ms * 1_000_000)
        return sink.spikes()  # type: ignore[attr-defined, no-any-return]


def parts(backend: str, options: dict[str, Any], cut: set[str]) -> dict[str, Any]:
    """Return the options of a composite brain of two parts on one backend, which share an empty cut."""
    one = {"backend": backend, "options": options}
    return {"parts": {"one": {**one, "populations": sorted(cut)} if cut else one, "rest": one}}
