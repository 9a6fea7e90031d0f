"""Values that are valid, but that no neuron has, are reported with the unit that was probably meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pyNN import errors
from pyNN.space import Line

from nrp_core.brain.files.script import load_network
from nrp_core.brain.network.implausible import implausible
from nrp_core.brain.pynn import builder
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment, shipped
from nrp_core.findings import Code

WRONG_UNITS = [
    ({"tau_m": 0.02}, "tau_m of the population 'cells' is 0.02 ms; is it meant in s?"),
    ({"tau_m": 20_000.0}, "tau_m of the population 'cells' is 20000 ms; is it meant in us?"),
    ({"tau_syn_E": 0.005}, "tau_syn_E of the population 'cells' is 0.005 ms; is it meant in s?"),
    ({"tau_refrac": 0.002}, "tau_refrac of the population 'cells' is 0.002 ms; is it meant in s?"),
    ({"cm": 0.00025}, "cm of the population 'cells' is 0.00025 nF; is it meant in uF?"),
    ({"cm": 250.0}, "cm of the population 'cells' is 250 nF; is it meant in pF?"),
    ({"i_offset": 300.0}, "i_offset of the population 'cells' is 300 nA; is it meant in pA?"),
    (
        {"i_offset": 0.0002},
        "i_offset of the population 'cells' is 0.0002 nA, which moves a cell by 0.004 mV; is it meant in uA?",
    ),
    ({"v_rest": -0.065}, "v_rest of the population 'cells' is -0.065 mV; is it meant in V?"),
    (
        {"e_rev_E": -70.0, "e_rev_I": 0.0},
        "e_rev_I of the population 'cells' is 0 mV, above e_rev_E, -70 mV: are they swapped?",
    ),
    ({"v_rest": -60.0, "v": -0.06}, "the initial v of the population 'cells' is -0.06 mV; is it meant in V?"),
    (
        {"v": -40.0},
        "3 of 3 cells of the population 'cells' begin at or above their threshold and fire at once: v is "
        "-40 mV, and v_thresh is -50 mV",
    ),
    (
        {"e_rev_E": -66.0, "e_rev_I": -80.0},
        "e_rev_E of the population 'cells' is -66 mV, and v_rest -65 mV: excitatory input inhibits",
    ),
    (
        {"e_rev_I": -10.0},
        "e_rev_I of the population 'cells' is -10 mV, and v_thresh -50 mV: inhibitory input makes cells fire",
    ),
    (
        {"v_thresh": 50.0, "e_rev_E": 60.0},
        "v_thresh of the population 'cells' is 50 mV, 115 mV above v_rest: is a sign wrong?",
    ),
    (
        {"v_thresh": 5.0, "v_rest": 0.0, "v_reset": 0.0, "e_rev_E": 2.0, "v": 0.0},
        "e_rev_E of the population 'cells' is 2 mV, and v_thresh 5 mV: no excitatory input takes a cell to "
        "its threshold",
    ),
    ({"e_rev_I": -70_000.0}, "e_rev_I of the population 'cells' is -70000 mV; is it meant in uV?"),
]


@pytest.mark.parametrize(("parameters", "sentence"), WRONG_UNITS, ids=lambda one: str(one)[:30])
def test_a_parameter_in_another_unit_is_reported_with_that_unit(
    parameters: dict[str, float], sentence: str
) -> None:
    sim = builder()
    begins = {"v": parameters["v"]} if "v" in parameters else {}
    values = {name: value for name, value in parameters.items() if name != "v"}
    sim.Population(3, sim.IF_cond_exp(**values), initial_values=begins, label="cells")
    assert implausible(sim.network()) == [sentence]


@pytest.mark.parametrize(
    "parameters",
    [
        {"v_thresh": 15.0, "v_rest": 0.0, "v_reset": 10.0, "e_rev_E": 70.0, "e_rev_I": -10.0},
        {"v_thresh": -20.0},
    ],
)
def test_other_scales_of_the_voltage_and_high_thresholds_are_not_reported(
    parameters: dict[str, float],
) -> None:
    sim = builder()
    begins = {"v": parameters.get("v_rest", -65.0)}
    sim.Population(3, sim.IF_cond_exp(**parameters), initial_values=begins, label="cells")
    assert implausible(sim.network()) == []


@pytest.mark.parametrize(
    ("parameters", "n_remarks"),
    [
        ({"tau_m": 1e15, "i_offset": 0.1}, 0),
        ({"tau_m": 1e9, "i_offset": 0.1}, 2),
        ({"tau_syn_E": 1e15}, 0),
        ({"v_thresh": np.inf, "i_offset": 0.0002}, 0),
    ],
)
def test_cells_without_a_leak_or_a_threshold_are_not_reported(
    parameters: dict[str, float], n_remarks: int
) -> None:
    sim = builder()
    inputs = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0]))
    cells = sim.Population(1, sim.IF_curr_exp(**parameters), label="cells")
    sim.Projection(inputs, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.5, delay=1.0))
    assert len(implausible(sim.network())) == n_remarks


@pytest.mark.parametrize(
    ("cell", "values", "words"),
    [
        (
            "EIF_cond_exp_isfa_ista",
            {"a": 4000.0},
            "a of the population 'cells' is 4000 nS; is it meant in pS?",
        ),
        ("EIF_cond_exp_isfa_ista", {"a": -11.0}, ""),
        ("HH_cond_exp", {"gbar_Na": 0.0}, "gbar_Na of the population 'cells' is 0: its cells cannot fire"),
        ("HH_cond_exp", {"gbar_K": 0.0}, ""),
    ],
)
def test_conductances_of_cells_are_judged(cell: str, values: dict[str, float], words: str) -> None:
    sim = builder()
    sim.Population(2, getattr(sim, cell)(**values), label="cells")
    assert implausible(sim.network()) == [words] * bool(words)


@pytest.mark.parametrize(
    ("limits", "amplitudes", "words"),
    [
        ((0.0, 0.02), (0.01, 0.0), ""),
        ((0.0, 0.02), (0.0, 0.0), "A_plus and A_minus are 0"),
        ((0.01, 0.01), (0.01, 0.01), "w_min and w_max are both 0.01"),
        ((0.01, 0.010001), (0.01, 0.01), ""),
    ],
)
def test_a_rule_that_changes_no_weight_is_reported(
    limits: tuple[float, float], amplitudes: tuple[float, float], words: str
) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    rule = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(A_plus=amplitudes[0], A_minus=amplitudes[1]),
        weight_dependence=sim.AdditiveWeightDependence(w_min=limits[0], w_max=limits[1]),
        weight=0.01,
        delay=1.0,
    )
    sim.Projection(cells, cells, sim.AllToAllConnector(), rule, label="p")
    expected = f"the weights of the projection 'p' cannot change: {words}"
    assert implausible(sim.network()) == [expected] * bool(words)


@pytest.mark.parametrize(
    ("step_ms", "words"), [(0.0001, "s"), (200.0, "us"), (0.001, "s"), (0.002, ""), (20.0, "")]
)
def test_a_step_in_another_unit_is_reported(step_ms: float, words: str) -> None:
    sim = builder()
    sim.setup(timestep=step_ms)
    expected = [f"timestep of setup is {step_ms:g} ms; is it meant in {words}?"] if words else []
    assert implausible(sim.network()) == expected


def test_cells_with_the_default_values_of_pynn_are_plausible() -> None:
    sim = builder()
    for name in ("IF_cond_exp", "IF_cond_alpha", "IF_curr_exp", "IF_curr_alpha", "EIF_cond_exp_isfa_ista"):
        cells = sim.Population(2, getattr(sim, name)(), label=name)
        weight = 0.05 if "cond" in name else 5.0
        sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight, delay=1.0))
    assert implausible(sim.network()) == []


def test_a_model_without_units_is_plausible() -> None:
    sim = builder()
    cells = sim.IF_curr_exp(v_rest=0.0, v_reset=0.0, v_thresh=1.0, tau_m=100.0)
    sim.Population(2, cells, initial_values={"v": -0.05}, label="cells")
    # cells that rest above their threshold fire by themselves
    cells = sim.IF_curr_exp(v_rest=-50.0, v_reset=-60.0, v_thresh=-55.0)
    sim.Population(2, cells, initial_values={"v": -50.0}, label="pacemakers")
    assert implausible(sim.network()) == []


def test_sources_in_another_unit_are_reported() -> None:
    sim = builder()
    sim.Population(1, sim.SpikeSourcePoisson(rate=1e6), label="noise")
    sim.Population(1, sim.SpikeSourceArray(spike_times=[0.5, 0.7]), label="train")
    random = np.sort(np.random.default_rng(1).uniform(0.0, 1000.0, (10, 50)))  # the nearest are 0.02 ms apart
    sim.Population(10, sim.SpikeSourceArray(spike_times=random.tolist()), label="random")
    sim.Population(2, sim.SpikeSourcePoisson(rate=100.0, duration=0.5), label="burst")
    sim.Population(2, sim.SpikeSourcePoisson(rate=100.0, duration=50.0), label="long burst")
    sim.Population(10, sim.SpikeSourcePoisson(rate=100.0, duration=2.0), label="short")
    sim.Population(10, sim.SpikeSourcePoisson(rate=500.0, duration=2.0), label="volley")
    sim.Population(10, sim.SpikeSourcePoisson(rate=1.0, duration=200.0), label="sparse")
    assert implausible(sim.network()) == [
        "rate of the population 'noise' is 1e+06 Hz; is it meant in mHz?",
        "spikes of the population 'train' follow each other after 0.2 ms; is it meant in s?",
        "the population 'burst' fires 0.1 spikes in all: the duration is 0.5 ms; is it meant in s?",
        "the population 'short' fires 2 spikes in all: the duration is 2 ms; is it meant in s?",
    ]


def test_cells_of_other_models_in_another_unit_or_order_are_reported() -> None:
    sim = builder()
    sim.Population(2, sim.Izhikevich(a=-65.0, b=0.2, c=0.02, d=8.0), label="cells")
    sim.Population(2, sim.EIF_cond_exp_isfa_ista(tau_w=0.144, delta_T=0.002, b=80.5), label="adapting")
    sim.Population(2, sim.Izhikevich(i_offset=0.02), label="published")
    sim.Population(2, sim.Izhikevich(i_offset=10.0), label="driven")
    sim.Population(2, sim.HH_cond_exp(gbar_Na=20_000.0), label="channels")
    assert implausible(sim.network()) == [
        "a of the population 'cells' is -65 /ms, and c is 0.02 mV: u does not recover; are they swapped?",
        "tau_w of the population 'adapting' is 0.144 ms; is it meant in s?",
        "delta_T of the population 'adapting' is 0.002 mV; is it meant in V?",
        "b of the population 'adapting' is 80.5 nA; is it meant in pA?",
        "i_offset of the population 'driven' is 10 nA; is it meant in pA?",
        "gbar_Na of the population 'channels' is 20000 uS; is it meant in nS?",
    ]


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ({"delay": 0.001}, "a delay of the projection 'loop' is 0.001 ms; is it meant in s?"),
        ({"delay": 1000.0}, "a delay of the projection 'loop' is 1000 ms; is it meant in us?"),
        ({"delay": 1.0, "U": 0.0}, "U of the projection 'loop' is 0: its synapses never transmit"),
        ({"delay": 1.0, "weight": 0.0}, "all weights of the projection 'loop' are 0: it has no effect"),
        ({"delay": 1.0, "tau_rec": 0.01}, "tau_rec of the projection 'loop' is 0.01 ms; is it meant in s?"),
    ],
)
def test_times_of_synapses_in_another_unit_are_reported(law: dict[str, float], words: str) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    synapse = sim.TsodyksMarkramSynapse(**{"weight": 0.001, **law})
    sim.Projection(cells, cells, sim.AllToAllConnector(), synapse, label="loop")
    assert implausible(sim.network()) == [words]


@pytest.mark.parametrize(
    ("cell", "weight", "words"),
    [("IF_cond_exp", 5.0, "5 uS, 100 times the leak of a cell; is it meant in nS?"),
     ("IF_cond_exp", 60.0, "60 uS, 1.2e+03 times the leak of a cell; is it meant in nS?"),
     ("IF_curr_exp", 80.0, "80 nA, which leads to 1.6e+03 mV; is it meant in pA?"),
     ("IF_curr_exp_frozen", 1375.0, "1375 mV; is it meant in uV?")],
)  # fmt: skip
def test_a_weight_in_another_unit_is_reported_with_its_effect(cell: str, weight: float, words: str) -> None:
    sim = builder()
    cells = sim.Population(2, getattr(sim, cell)(), label="cells")
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(cells, cells, sim.AllToAllConnector(), synapse, label="loop")
    assert implausible(sim.network()) == [f"a weight of the projection 'loop' is {words}"]


@pytest.mark.parametrize(
    ("step", "words"), [(0.01, []), (1.0, []), (10.0, ["A_plus of the projection 'loop' is 10"])]
)
def test_a_pair_of_spikes_that_exceeds_the_range_of_the_weights_is_reported(
    step: float, words: list[str]
) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_curr_exp(), label="cells")
    rule = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=step, A_minus=0.01),
        weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0), weight=0.5, delay=1.0,
    )  # fmt: skip
    sim.Projection(cells, cells, sim.AllToAllConnector(), rule, label="loop")
    assert [one.partition(":")[0] for one in implausible(sim.network())] == words


def test_weights_that_begin_outside_the_limits_of_their_plasticity_are_counted() -> None:
    sim = builder()
    cells = sim.Population(3, sim.IF_cond_exp(), label="cells")
    law = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(),
        weight_dependence=sim.AdditiveWeightDependence(w_min=0.001, w_max=0.01),
        weight=0.005,
    )
    loop = sim.Projection(cells, cells, sim.OneToOneConnector(), law, label="loop")
    loop.set(weight=np.diag([0.0005, 0.005, 0.02]))
    assert implausible(sim.network()) == [
        "1 of 3 weights of the projection 'loop' begin above w_max: 0.02, and w_max is 0.01",
        "1 of 3 weights of the projection 'loop' begin below w_min: 0.0005, and w_min is 0.001",
    ]


def test_groups_of_two_sizes_that_are_connected_one_to_one_are_reported() -> None:
    sim = builder()
    small, large = (sim.Population(n, sim.IF_cond_exp(), label=f"{n} cells") for n in (2, 5))
    pairs, synapse = sim.OneToOneConnector(), sim.StaticSynapse(weight=0.01)
    sim.Projection(small, large, pairs, synapse, label="pairs")
    sim.Projection(small, large[1:3], pairs, synapse, label="as many")
    sim.Projection(large[0:3], large[3:5], pairs, synapse, label="views")
    first, second = sim.network().remarks
    assert first == (
        "the projection 'pairs' is one to one, but '2 cells' has 2 cells and '5 cells' has 5: "
        "the remaining cells are not connected"
    )
    assert second.startswith("the projection 'views' is one to one")
    assert implausible(sim.network()) == []


@pytest.mark.parametrize(
    ("rows", "extra", "is_told"),
    [
        ([(1, 1), (2, 2), (3, 4), (3, 3)], None, True),
        ([(1, 1), (2, 2), (3, 3)], None, False),  # not all others of the larger group
        ([(0, 1), (1, 2), (2, 3), (3, 4)], None, False),
        ([(1, 1), (2, 2), (3, 4), (3, 3)], [(0, 0)], False),  # the first cell has a part of its own
        ([], None, False),
    ],
)
def test_a_list_that_is_numbered_from_1_is_reported(
    rows: list[tuple[int, int]], extra: list[tuple[int, int]] | None, is_told: bool
) -> None:
    sim = builder()
    pre, post = (sim.Population(n, sim.IF_curr_exp(), label=f"{n} cells") for n in (4, 5))
    for label, pairs in (("list", rows), ("extra", extra)):
        if pairs is not None:
            sim.Projection(
                pre, post, sim.FromListConnector(pairs), sim.StaticSynapse(weight=0.5), label=label
            )
    told = "the list of the projection 'list' has all cells of '4 cells' and '5 cells' but the first"
    assert [one.startswith(told) for one in sim.network().remarks] == [True] * is_told


@pytest.mark.parametrize(("expression", "highest"), [("exp(-d)", ""), ("d < 3", ""), ("5 * exp(-d)", "5")])
def test_probabilities_above_1_are_reported(expression: str, highest: str) -> None:
    sim = builder()
    cells = sim.Population(40, sim.IF_cond_exp(), structure=Line())
    connector = sim.DistanceDependentProbabilityConnector(expression)
    sim.Projection(cells, cells, connector, sim.StaticSynapse(weight=0.01), label="near")
    assert sim.network().remarks == (
        "the DistanceDependentProbabilityConnector of the projection 'near' gives probabilities up to "
        f"{highest}; above 1 it connects every pair",
    ) * bool(highest)


@pytest.mark.parametrize(("cell", "weight"), [("IF_cond_exp", 0.01), ("IF_curr_alpha", 1.0)])
@pytest.mark.parametrize(("cm", "is_reported"), [(0.25, False), (45.0, True)])
def test_a_projection_that_no_cell_notices_is_reported(
    cell: str, weight: float, cm: float, is_reported: bool
) -> None:
    sim = builder()
    cells = sim.Population(2, getattr(sim, cell)(cm=cm, tau_syn_E=0.5), label="cells")
    cells[1:2].set(v_thresh=-65.1, v_reset=-70.0)  # a pacemaker
    synapse = sim.StaticSynapse(weight=weight)
    sim.Projection(cells, cells, sim.OneToOneConnector(), synapse, label="loop")
    assert ["the projection 'loop' together move a cell by" in one for one in implausible(sim.network())] == [
        True
    ] * is_reported


@pytest.mark.parametrize(("weight", "is_reported"), [(0.04, False), (275e-6, True)])
def test_voltages_that_no_cell_notices_are_reported(weight: float, is_reported: bool) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_curr_exp_frozen(v_rest=-52.0, v_thresh=-45.0, cm=0.02), label="cells")
    sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight), label="loop")
    words = "'loop' together move a cell by 0.00055 mV at most, and its threshold is 7 mV above"
    assert [words in one for one in implausible(sim.network())] == [True] * is_reported


@pytest.mark.parametrize("name", sorted({name.partition("/")[0] for name in shipped()}))
def test_the_values_of_shipped_networks_are_plausible(name: str) -> None:
    plan = prepare(load_experiment(name))
    assert [finding for finding in plan.warnings if finding.code is Code.NRP297] == []


def test_random_numbers_of_a_script_follow_from_the_seed(tmp_path: Path) -> None:
    script = tmp_path / "brain.py"
    script.write_text(
        "import random\nimport numpy as np\nimport nrp_core.pynn as sim\n"
        "cells = sim.Population(2, sim.IF_cond_exp(tau_m=10 + np.random.rand(), cm=1 + random.random()))\n"
    )
    digests = [load_network(script, seed=seed).digest for seed in (1, 1, 2)]
    assert digests[0] == digests[1] != digests[2]


def test_a_label_that_is_used_twice_is_reported_with_its_new_name() -> None:
    sim = builder()
    cells = [sim.Population(2, sim.IF_cond_exp(), label="cells") for _ in range(2)]
    for _ in range(2):
        sim.Projection(*cells, sim.OneToOneConnector(), label="go")
    assert sim.network().remarks == (
        "two populations have the label 'cells'; the later one is called 'cells 2'",
        "two projections from 'cells' to 'cells' have the label 'go'; the later one is called 'go 2'",
    )


def test_a_label_may_stand_for_projections_between_different_cells() -> None:
    sim = builder()
    one, other = (sim.Population(2, sim.IF_cond_exp(), label=label) for label in ("one", "other"))
    for pre, post in ((one, other), (other, one)):
        sim.Projection(pre, post, sim.OneToOneConnector(), label="go")
    assert sim.network().remarks == ()


def test_projections_without_labels_between_the_same_cells_are_not_reported() -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_cond_exp())
    for receptor in ("excitatory", "inhibitory"):
        sim.Projection(cells, cells, sim.OneToOneConnector(), receptor_type=receptor)
    assert sim.network().remarks == ()


def test_a_current_source_that_is_never_injected_is_reported() -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_cond_exp())
    sim.DCSource(amplitude=0.1, start=0.0, stop=1e12).inject_into(cells)
    cells.inject(sim.DCSource(amplitude=0.2, start=0.0, stop=1e12))
    sim.DCSource(amplitude=0.3)
    assert sim.network().remarks == (
        "a DCSource (the current source 3 of 3) is never injected: call its inject_into(cells)",
    )


@pytest.mark.parametrize(
    ("delay_ms", "words"),
    [(0.2, "is 0.2 ms, and min_delay of setup is 0.5 ms"), (0.5, ""), (4.0, "")],
)
def test_a_delay_beyond_the_limits_of_setup_is_reported(delay_ms: float, words: str) -> None:
    sim = builder()
    sim.setup(timestep=0.1, min_delay=0.5, max_delay=4.0)
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    synapse = sim.StaticSynapse(weight=0.01, delay=delay_ms)
    sim.Projection(cells, cells, sim.OneToOneConnector(), synapse, label="go")
    expected = (f"a delay of the projection 'go' {words}",) if words else ()
    assert sim.network().remarks == expected


def test_a_delay_above_that_of_setup_is_refused_as_by_pynn() -> None:
    sim = builder()
    sim.setup(timestep=0.1, max_delay=4.0)
    cells = sim.Population(2, sim.IF_cond_exp(), label="cells")
    synapse = sim.StaticSynapse(weight=0.01, delay=9.0)
    with pytest.raises(errors.ConnectionError, match=r"delay.* 9.* max_delay of setup, 4 ms"):
        sim.Projection(cells, cells, sim.OneToOneConnector(), synapse, label="go")
    made = sim.Projection(cells, cells, sim.OneToOneConnector(), sim.StaticSynapse(delay=0.1 * 40))
    with pytest.raises(errors.ConnectionError, match="max_delay of setup, 4 ms"):
        made.set(delay=4.1)


@pytest.mark.parametrize(
    ("plus", "minus", "is_reported"), [(0.01, -0.012, True), (0.01, 0.012, False), (-0.01, -0.012, False)]
)
def test_a_depression_with_the_sign_of_other_notations_is_reported(
    plus: float, minus: float, is_reported: bool
) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_curr_exp(), label="cells")
    law = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=plus, A_minus=minus),
        weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0),
        weight=0.5,
        delay=1.0,
    )
    sim.Projection(cells, cells, sim.AllToAllConnector(), law, label="loop")
    words = "A_minus of the projection 'loop' is -0.012: PyNN subtracts it"
    assert any(words in one for one in implausible(sim.network())) == is_reported


def test_a_view_that_an_assembly_cannot_take_is_reported() -> None:
    sim = builder()
    cells = sim.Population(6, sim.IF_curr_exp(), label="cells")
    sim.Assembly(cells[0:2], cells[2:4], label="apart")
    assert not any("assembly" in one for one in sim.network().remarks)
    sim.Assembly(cells[0:4], cells[2:6], label="both")
    (remark,) = [one for one in sim.network().remarks if "assembly" in one]
    assert "is not added to the assembly 'both', which has some of its cells already" in remark


@pytest.mark.parametrize(("weight", "is_reported"), [(0.01, False), (1e-5, True)])
def test_many_cells_do_not_hide_that_none_notices_a_projection(weight: float, is_reported: bool) -> None:
    sim = builder()
    cells = sim.Population(400, sim.IF_curr_exp(cm=0.25, tau_m=20.0), label="cells")
    sim.Projection(cells, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=weight), label="loop")
    assert any("together move a cell by" in one for one in implausible(sim.network())) is is_reported


def test_spike_times_may_be_the_rows_of_an_array() -> None:
    sim = builder()
    sim.Population(2, sim.SpikeSourceArray(spike_times=np.array([[1.0, 2.0], [3.0, 4.0]])), label="s")
    trains = sim.network().populations["s"].spike_times_ms
    assert [train.tolist() for train in trains] == [[1.0, 2.0], [3.0, 4.0]]
