"""The machine map and what is lost on it, against what the host of sPyNNaker 7.4.1 chose."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_spinnaker import SpinnakerBackend
from nrp_brain_spinnaker.host.weights import binomial_quantile
from nrp_brain_spinnaker.host.wiring import slots_available, slots_used
from nrp_brain_spinnaker.loader import lay_out
from nrp_brain_spinnaker.mapping import fidelity, plan
from nrp_brain_spinnaker.mapping.fidelity import Fidelity, share_above
from nrp_brain_spinnaker.mapping.plan import MachineMap
from nrp_brain_spinnaker.options import SpinnakerOptions

from nrp_core.findings import Finding
from nrp_core.network.data import Network, Origin, Population, Projection
from nrp_core.network.pynn import builder

OWN = Path(__file__).parent / "oracles" / "spinnaker_mapping.json"
OPTIONS = SpinnakerOptions()
FINE = "0.1 ms"
Maker = Callable[..., Population]
Connect = Callable[..., Projection]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Check each network of the file here, and of all that are given, in a test of its own."""
    if "reference" in metafunc.fixturenames:
        given = [path for path in metafunc.config.getoption("oracle") if path.suffix == ".json"]
        documents = [(path, json.loads(path.read_text())) for path in [OWN, *given]]
        entries = [
            pytest.param(entry, id=f"{path.stem}-{entry['name']}")
            for path, document in documents
            if isinstance(document, list)
            for entry in document
        ]
        metafunc.parametrize("reference", entries)


def network_of(*parts: Population | Projection) -> Network:
    populations = {part.label: part for part in parts if isinstance(part, Population)}
    return Network(populations, tuple(part for part in parts if isinstance(part, Projection)))


def map_network(network: Network, options: SpinnakerOptions) -> MachineMap:
    cells, wires, _ = lay_out(network, options)
    return plan.map_network(network, cells, wires, options)


def weigh(network: Network, options: SpinnakerOptions) -> Fidelity:
    return fidelity.weigh(network, lay_out(network, options)[1], options)


def all_to_all(n_pre: int, n_post: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(n_pre) for j in range(n_post)]


def randomly(pre: Population, post: Population, weight: float, delay: float) -> Projection:
    """Connect each pair with a probability of 0.1."""
    chosen = np.random.default_rng(1).random((pre.size, post.size)) < 0.1
    i, j = (index.astype(np.int32) for index in np.nonzero(chosen))
    return Projection(
        f"{pre.label}-{post.label}", pre.label, post.label, "excitatory" if weight > 0 else "inhibitory",
        i, j, np.full(len(i), weight), np.full(len(i), delay),
        origin=Origin("FixedProbabilityConnector", {"p_connect": 0.1}, weight, delay),
    )  # fmt: skip


@pytest.fixture
def networks(cells: Maker, spike_source: Maker, connect: Connect) -> dict[str, Network]:
    """Return the networks of the reference."""
    one, many, ten = (
        spike_source("src", []),
        spike_source("src", *[[]] * 100),
        spike_source("src", *[[]] * 10),
    )
    rate = {"rate": np.full(100, 20.0), "start": np.zeros(100), "duration": np.full(100, np.inf)}
    poisson = Population("src", 100, "SpikeSourcePoisson", rate)
    fast = {"rate": np.full(1000, 100.0), "start": np.zeros(1000), "duration": np.full(1000, np.inf)}
    ext = Population("ext", 1000, "SpikeSourcePoisson", fast)
    exc, inh = cells("exc", "IF_curr_exp", 800), cells("inh", "IF_curr_exp", 200)
    full = all_to_all(100, 100)
    return {
        "one_to_one_w5": network_of(one, cells("n", "IF_curr_exp"), connect("src", "n", 5.0)),
        "all_to_all_const_delay": network_of(
            many, cells("n", "IF_curr_exp", 100), connect("src", "n", 0.05, pairs=full)
        ),
        "cond_weights": network_of(
            poisson, cells("n", "IF_cond_exp", 100),
            connect("src", "n", 0.004, pairs=full),
            connect("src", "n", 0.05, 2.0, pairs=full, receptor="inhibitory"),
        ),
        "long_delays": network_of(
            ten, cells("n", "IF_curr_exp", 10), cells("m", "IF_curr_exp", 256),
            connect("src", "n", 1.0, 100.0, pairs=[(i, i) for i in range(10)]),
            connect("src", "m", 0.05, 100.0, pairs=all_to_all(10, 256)),
        ),
        "balanced_1000": network_of(
            exc, inh, ext,
            randomly(ext, exc, 0.1, 1.0), randomly(exc, exc, 0.1, 2.0), randomly(exc, inh, 0.1, 2.0),
            randomly(inh, exc, -0.5, 2.0), randomly(inh, inh, -0.5, 2.0),
        ),
    }  # fmt: skip


def described(reference: dict[str, Any], networks: dict[str, Network]) -> Network:
    """Return the network of a reference, whose file has it in words only."""
    if reference["name"] not in networks:
        pytest.skip(f"no network is built here for '{reference['name']}': {reference.get('network')}")
    return networks[reference["name"]]


def test_cores_keys_shifts_and_slots_are_the_hosts(
    reference: dict[str, Any], networks: dict[str, Network]
) -> None:
    seen, expected = map_network(described(reference, networks), OPTIONS), reference
    assert seen.application_cores == expected["n_app_cores"]
    assert seen.system_cores == expected["n_system_cores"]
    assert seen.chips == len(expected["app_chips"])
    assert seen.router_entries == expected["router_entries"]["0,0"]
    by_label = {vertex.label: vertex for vertex in seen.vertices}
    for population in expected["populations"]:
        vertex = by_label[population["label"]]
        assert [
            {"lo": core.first, "hi": core.last - 1, "core": core.core, "key": core.key, "mask": core.mask}
            for core in vertex.cores
        ] == [
            {"lo": core["lo"], "hi": core["hi"], "core": core["placed"][2],
             "key": core.get("key"), "mask": core.get("mask")}
            for core in population["cores"]
        ]  # fmt: skip
        if "left_shifts" in population:
            assert list(vertex.left_shifts) == population["left_shifts"]
            slots = (population["max_delay_slots"], population["delay_slots_used"])
            assert vertex.delay_slots == slots


def test_memory_is_close_to_what_the_host_takes(
    reference: dict[str, Any], networks: dict[str, Network]
) -> None:
    vertices = map_network(described(reference, networks), OPTIONS).vertices
    by_label = {vertex.label: vertex for vertex in vertices}
    for population in reference["populations"]:
        needed = population["cores"][0]["sdram_fixed_bytes"]
        allowed = 0.12 if reference["name"] == "balanced_1000" else 0.01
        assert by_label[population["label"]].sdram_bytes == pytest.approx(needed, rel=allowed)


@pytest.mark.parametrize(("on_core", "available"), [(1, 4096), (2, 4096), (64, 128), (128, 64), (256, 32)])
def test_slots_by_neurons_on_a_core(on_core: int, available: int) -> None:
    assert slots_available(on_core) == available
    assert slots_used(on_core, 10 * available) == available


def test_a_large_network_fills_chips_and_boards(cells: Maker) -> None:
    seen = map_network(network_of(cells("n", "IF_curr_exp", 256 * 800)), OPTIONS)
    assert (seen.application_cores, seen.chips, seen.boards) == (800, 51, 2)
    assert {core.core for core in seen.vertices[0].cores if core.chip == 0} == set(range(3, 18))
    assert {core.core for core in seen.vertices[0].cores if core.chip == 1} == set(range(2, 18))
    assert seen.power_w > 2 * 26.84


def test_below_a_millisecond_a_step_synapses_have_cores_of_their_own(cells: Maker) -> None:
    source, target = cells("s", "IF_curr_exp", 3000), cells("n", "IF_curr_exp", 300)
    network = network_of(source, target, randomly(source, target, 0.1, 1.0))
    row = binomial_quantile(256, 0.1, 1 - 1e-4 / (3000 * 300))
    beside = math.ceil(row * 3000 * 30.0 / 13e6)
    assert beside == 1
    for step, rate, expected in (("1 ms", 30.0, 0), (FINE, 30.0, beside), (FINE, 300.0, row * 9e5 / 13e6)):
        options = SpinnakerOptions.model_validate({"timestep": step, "spikes_per_second": rate})
        senders, receivers = (seen := map_network(network, options)).vertices
        assert (senders.synapse_cores, receivers.synapse_cores) == (0, math.ceil(expected))
        assert [core.has_synapses_alone for core in receivers.cores] == (
            2 * [*[True] * receivers.synapse_cores, False]
        )
        assert len({(core.chip, core.core) for core in receivers.cores}) == len(receivers.cores)
        chips = [[core.chip for core in receivers.cores if core.first == first] for first in (0, 256)]
        assert all(len(set(together)) == 1 for together in chips)
        assert seen.application_cores == 12 + 2 * (1 + receivers.synapse_cores)


def test_more_cores_for_synapses_than_a_chip_has_are_reported(cells: Maker) -> None:
    source, target = cells("s", "IF_curr_exp", 3000), cells("n", "IF_curr_exp", 300)
    network = network_of(source, target, randomly(source, target, 0.1, 1.0))
    options = SpinnakerOptions.model_validate({"timestep": FINE, "spikes_per_second": 3000.0})
    seen = map_network(network, options)
    assert any(
        "cores for the synapses of each core of neurons; a chip has 15" in line for line in seen.advice
    )


def test_a_network_that_is_too_slow_for_real_time_is_reported(cells: Maker) -> None:
    rate = {"rate": np.full(2000, 500.0), "start": np.zeros(2000), "duration": np.full(2000, np.inf)}
    source, target = Population("fast", 2000, "SpikeSourcePoisson", rate), cells("n", "IF_curr_exp", 256)
    seen = map_network(network_of(source, target, randomly(source, target, 0.1, 1.0)), OPTIONS)
    assert any("1000 spikes in a time step; a core can queue 256" in line for line in seen.advice)
    assert any("busy for" in line and "times slower" in line for line in seen.advice)
    busy = seen.vertices[1]
    assert busy.utilisation > 1
    assert busy.late == pytest.approx(1 - 1 / busy.utilisation)
    assert seen.slowdown >= busy.utilisation
    assert seen.joules_per_simulated_s == seen.power_w * seen.slowdown


def test_an_extension_is_named_in_the_map(cells: Maker) -> None:
    seen = map_network(network_of(cells("n", "IF_cond_alpha", 8)), OPTIONS)
    assert seen.advice == (
        "population 'n': sPyNNaker has no IF_cond_alpha cells; the load is a rough estimate",
    )


def test_weights_that_vanish_are_counted_and_explained(
    cells: Maker, spike_source: Maker, connect: Connect
) -> None:
    network = network_of(
        spike_source("s", []), cells("n", "IF_curr_exp"),
        connect("s", "n", 900.0, label="strong"), connect("s", "n", 0.005, label="weak"),
    )  # fmt: skip
    strong, weak = (seen := weigh(network, OPTIONS)).projections
    assert (strong.left_shift, strong.vanished, strong.quantum) == (10, 0, 2**-5)
    assert (weak.vanished, weak.synapses) == (1, 1)
    (loss,) = seen.losses
    assert loss.message.startswith(
        "projection 'weak': 1 of 1 weights become 0 (in steps of 0.0312); 'strong' sets"
    )
    assert seen.advice == ()


def test_conductances_rounded_by_the_machine_can_be_kept_by_the_host(
    cells: Maker, spike_source: Maker, connect: Connect, golden: Golden
) -> None:
    plain = connect("s", "n", 1e-5)
    generated = Projection(
        "tiny", "s", "n", "excitatory", plain.pre_index, plain.post_index, plain.weight, plain.delay_ms,
        origin=Origin("AllToAllConnector", {}, 1e-5, 1.0),
    )  # fmt: skip
    network = network_of(spike_source("s", []), cells("n", "IF_cond_exp"), generated)
    golden(weigh(network, OPTIONS).losses[0].message)
    kept = weigh(network, SpinnakerOptions(weights="host")).projections[0]
    assert (kept.vanished, kept.mean_error < 0.01) == (0, True)


def test_moved_delays_are_counted(cells: Maker, spike_source: Maker, connect: Connect) -> None:
    parts = spike_source("s", []), cells("n", "IF_curr_exp"), connect("s", "n", 1.0, 2.3)
    (seen,) = weigh(network_of(*parts), OPTIONS).projections
    assert (seen.moved_delays, seen.largest_move_ms) == (1, pytest.approx(0.3))


def test_weights_that_wrap_are_counted(cells: Maker, spike_source: Maker, connect: Connect) -> None:
    drawn = connect("s", "n", [1.0, 40.0, 50.0], pairs=[(0, 0)] * 3, label="wild")
    origin = Origin("AllToAllConnector", {}, "uniform(low=0, high=2)", 1.0)
    network = network_of(spike_source("s", []), cells("n", "IF_curr_exp"), replace(drawn, origin=origin))
    seen = weigh(network, OPTIONS)
    assert (seen.projections[0].wrapped, seen.projections[0].vanished) == (2, 0)
    assert seen.losses[0].message.startswith("projection 'wild': 2 of 3 weights wrap around")


def test_the_share_of_steps_that_saturate_is_that_of_a_poisson_sum(cells: Maker, connect: Connect) -> None:
    rate = {"rate": np.full(1000, 100.0), "start": np.zeros(1000), "duration": np.full(1000, np.inf)}
    fast = Population("fast", 1000, "SpikeSourcePoisson", rate)
    # each neuron gets 10 spikes in a step
    spread = [(i, i % 10) for i in range(1000)]
    network = network_of(fast, cells("n", "IF_curr_exp", 10), connect("fast", "n", 1.0, pairs=spread))
    (seen,) = weigh(network, OPTIONS).receptors
    assert seen.mean_sum == pytest.approx(10.0)
    assert seen.deviation == pytest.approx(10**0.5)
    assert seen.saturating == pytest.approx(poisson_share_above(seen.largest_sum, 10.0), abs=1e-12)
    for limit in (8.0, 12.5, 20.0):
        assert share_above(limit, 10.0, 10.0) == pytest.approx(poisson_share_above(limit, 10.0))


def poisson_share_above(limit: float, mean: float) -> float:
    draws = np.arange(int(limit) + 1, 400)
    logs = draws * np.log(mean) - mean - np.array([math.lgamma(k + 1) for k in draws])
    return float(np.exp(logs).sum())


def test_saturation_is_reported_with_a_remedy(cells: Maker, connect: Connect) -> None:
    rate = {"rate": np.full(100, 3000.0), "start": np.zeros(100), "duration": np.full(100, np.inf)}
    fast = Population("fast", 100, "SpikeSourcePoisson", rate)
    network = network_of(fast, cells("n", "IF_curr_exp"), connect("fast", "n", 1.0, pairs=all_to_all(100, 1)))
    (advice,) = weigh(network, OPTIONS).advice  # the host expects one spike of each source at most, 3 come
    assert "population 'n': its excitatory input is cut off in 99." in advice
    assert "300 is expected" in advice
    assert weigh(network, SpinnakerOptions(spikes_per_second=5000)).advice == ()


def test_the_backend_reports_everything_as_plain_values(
    cells: Maker, spike_source: Maker, connect: Connect
) -> None:
    network = network_of(
        spike_source("s", [1.0]), cells("n", "IF_curr_exp"), cells("m", "IF_cond_exp"),
        connect("s", "n", 900.0, label="strong"), connect("s", "n", 0.005, 2.3, label="weak"),
        connect("s", "m", 0.01),
    )  # fmt: skip
    machine, kept = (report.as_dict() for report in SpinnakerBackend().reports(network, OPTIONS))
    assert json.loads(json.dumps([machine, kept])) == [machine, kept]
    assert machine["facts"]["application_cores"] == 3
    assert [row["population"] for row in machine["tables"]["populations"]] == ["s", "n", "m"]
    assert machine["tables"]["populations"][0]["utilisation"] is None
    assert [row["key"] is None for row in machine["tables"]["cores"]] == [False, True, True]
    assert [row["vanished"] for row in kept["tables"]["projections"]] == [0, 1, 0]
    assert kept["warnings"][0]["subject"] == "weak"
    assert "delays become whole time steps" in kept["advice"][0]
    assert Finding.from_dict(kept["warnings"][0]) in SpinnakerBackend().warnings(network, OPTIONS)


def learning(a_plus: float, a_minus: float, rule: str = "AdditiveWeightDependence") -> Network:
    """Return cells that are made to fire 2 ms after each spike through a plastic synapse."""
    sim = builder()
    sim.setup(timestep=1.0)
    pre = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0, 20.0, 30.0]), label="pre")
    driver = sim.Population(1, sim.SpikeSourceArray(spike_times=[12.0, 22.0]), label="driver")
    post = sim.Population(1, sim.IF_curr_exp(tau_syn_E=0.5), label="post")
    synapse = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(A_plus=a_plus, A_minus=a_minus),
        weight_dependence=getattr(sim, rule)(w_max=0.5), weight=0.125,
    )  # fmt: skip
    sim.Projection(pre, post, sim.AllToAllConnector(), synapse, label="learning")
    sim.Projection(driver, post, sim.AllToAllConnector(), sim.StaticSynapse(weight=60.0), label="driving")
    network: Network = sim.network()
    return network


@pytest.mark.parametrize("rule", ["AdditiveWeightDependence", "MultiplicativeWeightDependence"])
def test_changes_of_plastic_weights_that_are_less_than_a_step_are_reported(rule: str) -> None:
    kept = weigh(learning(1e-5, 1e-5, rule), OPTIONS)
    (advice,) = kept.advice
    assert advice.startswith("projection 'learning': its weights are stored in steps of 0.00195: ")
    assert "a pair of spikes adds at most 5e-06, which is rounded to 0" in advice
    assert "should subtract at most 5e-06, but subtracts a whole step" in advice
    assert not weigh(learning(0.01, 0.01, rule), OPTIONS).advice


@pytest.mark.parametrize("a_plus", [0.001, 0.1])
def test_a_plastic_weight_grows_exactly_unless_its_limit_is_declared(a_plus: float) -> None:
    network = learning(a_plus, 0.0)
    told = any("which is rounded to 0" in line for line in weigh(network, OPTIONS).advice)
    with SpinnakerBackend().open(network, seed=1, options=OPTIONS) as brain:
        brain.run_until(60_000_000)
        (weight,) = brain.read_weights("learning")
    assert (weight > 0.125) != told
