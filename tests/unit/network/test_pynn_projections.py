"""Projections keep PyNN's meaning of weights and delays, and where they come from."""

from types import ModuleType
from typing import Any

import numpy as np
import pyNN.mock
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from pyNN import errors
from pyNN.parameters import LazyArray

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Projection
from nrp_core.network.pynn import builder
from nrp_core.network.rewiring import Neuromodulation


@pytest.fixture
def sim() -> ModuleType:
    sim = builder(seed=1)
    sim.setup(timestep=0.5)
    return sim


def cells(sim: ModuleType, n: int = 3, label: str = "cells", model: str = "IF_cond_exp") -> Any:
    return sim.Population(n, getattr(sim, model)(), label=label)


def connect(
    sim: ModuleType, synapse: Any, connector: Any = None, model: str = "IF_cond_exp", **options: Any
) -> Any:
    connector = connector or sim.AllToAllConnector()
    return sim.Projection(cells(sim, 2, "a"), cells(sim, 3, "b", model), connector, synapse, **options)


def only(sim: ModuleType) -> Projection:
    (projection,) = sim.network().projections
    return projection


def test_a_projection_is_named_after_its_populations_or_as_the_script_says(sim: ModuleType) -> None:
    connect(sim, sim.StaticSynapse(weight=0.1))
    connect(sim, sim.StaticSynapse(weight=0.1))
    connect(sim, sim.StaticSynapse(weight=0.1), label="wiring")
    labels = [projection.label for projection in sim.network().projections]
    assert labels == ["a→b", "a→b 2", "wiring"]


@pytest.mark.parametrize(("min_delay", "expected"), [("auto", 0.5), (2.0, 2.0)])
def test_a_delay_that_is_not_given_is_the_smallest(min_delay: Any, expected: float) -> None:
    sim = builder()
    sim.setup(timestep=0.5, min_delay=min_delay)
    connect(sim, sim.StaticSynapse(weight=0.1))
    connect(sim, sim.TsodyksMarkramSynapse(weight=0.1))
    assert sim.get_min_delay() == expected
    for projection in sim.network().projections:
        assert set(projection.delay_ms) == {expected}
        assert projection.origin.delay == expected


@pytest.mark.parametrize(
    ("given", "origin"),
    [
        ({"weight": 0.5, "delay": 1.5}, (0.5, 1.5)),
        ({"weight": "0.1*d + 0.2"}, ("0.1*d + 0.2", 0.5)),
        ({"weight": np.full((2, 3), 0.3)}, (None, 0.5)),
    ],
)
def test_the_origin_holds_connector_weight_and_delay_as_given(
    sim: ModuleType, given: Any, origin: Any
) -> None:
    connect(sim, sim.StaticSynapse(**given), sim.FixedProbabilityConnector(0.8))
    found = only(sim).origin
    assert found.connector == "FixedProbabilityConnector"
    assert found.parameters == {"allow_self_connections": True, "p_connect": 0.8}
    assert (found.weight, found.delay) == origin


def test_the_origin_describes_a_distribution_in_words_and_the_projection_has_its_draws(
    sim: ModuleType,
) -> None:
    weight = sim.RandomDistribution("normal", (0.5, 0.01))
    connect(sim, sim.StaticSynapse(weight=weight))
    projection = only(sim)
    assert projection.origin.weight == "normal(mu=0.5, sigma=0.01)"
    assert len(set(projection.weight)) == 6
    assert projection.weight == pytest.approx(0.5, abs=0.1)


def test_the_origin_follows_what_the_script_sets_later(sim: ModuleType) -> None:
    connect(sim, sim.StaticSynapse(weight=0.5)).set(weight=0.7)
    assert only(sim).origin.weight == 0.7
    connect(sim, sim.StaticSynapse(weight=0.5))[2].weight = 0.7
    assert sim.network().projections[1].origin.weight is None


def test_a_list_has_no_common_weight(sim: ModuleType) -> None:
    connect(sim, sim.StaticSynapse(), sim.FromListConnector([(0, 1, 0.1, 1.0), (1, 2, 0.2, 2.0)]))
    origin = only(sim).origin
    assert (origin.parameters, origin.weight, origin.delay) == ({"conn_list": None}, None, None)


def test_tsodyks_markram_synapses_keep_their_parameters(sim: ModuleType) -> None:
    connect(
        sim, sim.TsodyksMarkramSynapse(weight=0.1, U=0.2, tau_rec=300.0, tau_facil=[[1.0] * 3, [2.0] * 3])
    )
    projection = only(sim)
    assert projection.synapse_type == "tsodyks_markram"
    assert set(projection.synapse_parameters) == {"U", "tau_rec", "tau_facil"}
    assert projection.synapse_parameters["U"].tolist() == [0.2] * 6
    assert projection.synapse_parameters["tau_facil"].tolist() == [1.0, 2.0] * 3


@pytest.mark.parametrize("rule", ["AdditiveWeightDependence", "MultiplicativeWeightDependence"])
def test_plastic_synapses_name_their_rules_and_keep_their_parameters(sim: ModuleType, rule: str) -> None:
    synapse = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(tau_plus=15.0, A_plus=0.02),
        weight_dependence=getattr(sim, rule)(w_max=0.05),
        weight=0.01, delay=2.0, dendritic_delay_fraction=0.5,
    )  # fmt: skip
    connect(sim, synapse)
    projection = only(sim)
    assert projection.synapse_type == "stdp"
    assert projection.plasticity == {"timing_dependence": "SpikePairRule", "weight_dependence": rule}
    assert {name: values[0] for name, values in projection.synapse_parameters.items()} == {
        "tau_plus": 15.0, "tau_minus": 20.0, "A_plus": 0.02, "A_minus": 0.01,
        "w_min": 0.0, "w_max": 0.05, "dendritic_delay_fraction": 0.5,
    }  # fmt: skip
    assert (projection.weight[0], projection.delay_ms[0]) == (0.01, 2.0)


def test_half_a_plasticity_rule_is_refused(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(NetworkError, match="timing_dependence.*weight_dependence"):
        sim.STDPMechanism(timing_dependence=sim.SpikePairRule())


def test_synapses_between_views_and_assemblies_end_on_the_cells_of_their_populations(sim: ModuleType) -> None:
    a, b = cells(sim, 4, "a"), cells(sim, 3, "b")
    sim.Projection(a[[1, 3]], b[1:], sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1))
    sim.Projection(
        b[2:] + a[:1], a[2:] + b, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1), label="x"
    )
    first, *parts = sim.network().projections
    assert list(zip(first.pre_index, first.post_index, strict=True)) == [(1, 1), (3, 2)]
    found = {
        (p.pre, int(i), p.post, int(j)) for p in parts for i, j in zip(p.pre_index, p.post_index, strict=True)
    }
    sources, targets = [("b", 2), ("a", 0)], [("a", 2), ("a", 3), ("b", 0), ("b", 1), ("b", 2)]
    assert found == {(*source, *target) for source in sources for target in targets}
    assert sum(part.size for part in parts) == 10
    assert [part.label for part in parts] == ["x (b→a)", "x (b→b)", "x (a→a)", "x (a→b)"]
    assert all(part.weight.strides == (0,) for part in parts)


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_parts_of_an_assembly_keep_each_synapse_with_its_values(data: st.DataObject) -> None:
    sim = builder()
    populations = [cells(sim, n, str(n)) for n in (2, 3, 4)]
    pre, post = (sim.Assembly(*data.draw(st.permutations(populations))) for _ in range(2))
    pairs = data.draw(st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=1, max_size=20))
    rows = [(i, j, 0.001 * k, 1.0 + k) for k, (i, j) in enumerate(pairs)]
    sim.Projection(pre, post, sim.FromListConnector(rows), sim.StaticSynapse())
    network = sim.network()
    found = sorted(
        (int(network.ids_of(p.pre)[i]), int(network.ids_of(p.post)[j]), w, d)
        for p in network.projections
        for i, j, w, d in zip(p.pre_index, p.post_index, p.weight, p.delay_ms, strict=True)
    )
    assert found == sorted((int(pre[i]), int(post[j]), w, d) for i, j, w, d in rows)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.3, [0.3] * 6),
        ("0.1 + 0.01*d", [0.1, 0.11, 0.11, 0.1, 0.12, 0.11]),
        (np.arange(6.0).reshape(2, 3), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]),
        ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]),
    ],
    ids=["number", "distance", "matrix", "list"],
)
def test_weights_can_be_set_in_each_form_of_pynn(sim: ModuleType, value: Any, expected: list[float]) -> None:
    projection = connect(sim, sim.StaticSynapse(weight=0.9))
    projection.set(weight=value)
    assert only(sim).weight == pytest.approx(expected)
    assert only(sim).delay_ms.tolist() == [0.5] * 6


@pytest.mark.parametrize("name", ["uniform", "normal_clipped"])
def test_random_weights_that_are_set_later_are_those_of_pynn(name: str) -> None:
    values = {"uniform": (0.1, 0.2), "normal_clipped": (0.0, 1.0, 0.1, 0.5)}[name]
    sim = builder()
    a, b = (sim.Population(n, sim.IF_cond_exp()) for n in (5, 4))
    some = sim.FixedProbabilityConnector(0.6, rng=sim.NumpyRNG(1))
    projection = sim.Projection(a, b, some, sim.StaticSynapse(weight=0.1))
    projection.set(weight=sim.RandomDistribution(name, values, rng=sim.NumpyRNG(2)))
    given = pyNN.mock.RandomDistribution(name, values, rng=pyNN.mock.NumpyRNG(2))
    expected = LazyArray(given, shape=(5, 4)).evaluate()  # as pyNN.nest and pyNN.neuron do
    weights = projection.get("weight", format="array")
    np.testing.assert_array_equal(weights, np.where(np.isnan(weights), np.nan, expected))


def test_a_list_that_leaves_delays_to_chance_has_those_of_pynn() -> None:
    def delays_of(simulator: Any) -> Any:
        simulator.setup()
        a, b = (simulator.Population(n, simulator.IF_cond_exp()) for n in (5, 4))
        pairs = [(0, 1, 0.5), (2, 1, 0.25), (1, 3, 0.5), (4, 0, 0.75)]
        by_chance = simulator.RandomDistribution("uniform", (1.0, 2.0), rng=simulator.NumpyRNG(3))
        listed = simulator.FromListConnector(pairs, column_names=["weight"])
        projection = simulator.Projection(a, b, listed, simulator.StaticSynapse(delay=by_chance))
        return projection.get(["weight", "delay"], format="array")

    np.testing.assert_array_equal(delays_of(builder()), delays_of(pyNN.mock))


def test_synapses_can_be_read_and_set_one_by_one(sim: ModuleType, golden: Golden) -> None:
    projection = connect(sim, sim.StaticSynapse(weight=0.9))
    projection[1].weight = 0.25
    assert [synapse.weight for synapse in projection] == [0.9, 0.25, 0.9, 0.9, 0.9, 0.9]
    assert (projection[1].presynaptic_index, projection[1].postsynaptic_index) == (1, 0)
    assert projection[1].as_tuple("weight", "delay") == (0.25, 0.5)
    with golden.raises(AttributeError, match="'wheight'"):
        _ = projection[1].wheight


@pytest.mark.parametrize("several", ["sum", "last", "first", "min", "max"])
def test_a_matrix_of_weights_is_that_of_pynn(sim: ModuleType, several: str) -> None:
    rows = [(0, 1, 0.5, 1.0), (0, 1, 0.25, 1.0), (1, 2, 0.125, 1.0), (0, 1, 0.75, 1.0)]
    matrices = []
    for each in (pyNN.mock, sim):
        each.setup()
        projection = connect(each, each.StaticSynapse(), each.FromListConnector(rows))
        matrices.append(projection.get("weight", "array", multiple_synapses=several))
    np.testing.assert_array_equal(*matrices)


@pytest.mark.parametrize(
    ("model", "options", "weight", "says"),
    [
        (
            "IF_cond_exp",
            {},
            [[0.1] * 3, [0.1, 0.1, -0.2]],
            r"synapse 5 \(1 -> 2\) is -0.2; .* conductance-based",
        ),
        (
            "IF_curr_exp",
            {"receptor_type": "inhibitory"},
            0.1,
            "is 0.1; it must be 0 or less on the inhibitory",
        ),
        (
            "IF_curr_exp",
            {"receptor_type": "excitatory"},
            -0.1,
            "is -0.1; it must be 0 or more on the excitatory",
        ),
        ("Izhikevich", {"receptor_type": "inhibitory"}, 0.1, "is 0.1; it must be 0 or less"),
    ],
)
def test_a_weight_of_the_wrong_sign_is_refused(
    sim: ModuleType, model: str, options: Any, weight: Any, says: str, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=f"'a→b'.*{says}"):
        connect(sim, sim.StaticSynapse(weight=weight), model=model, **options)


def test_a_connector_that_is_not_safe_lets_currents_have_any_sign(sim: ModuleType) -> None:
    connector = sim.AllToAllConnector(safe=False)
    connect(sim, sim.StaticSynapse(weight=-0.1), connector, "IF_curr_exp", receptor_type="excitatory")
    assert set(only(sim).weight) == {-0.1}
    with pytest.raises(NetworkError, match="conductance-based"):
        connect(sim, sim.StaticSynapse(weight=-0.1), connector, "IF_cond_exp", receptor_type="excitatory")


def test_the_receptor_follows_from_the_sign_where_it_is_not_given(sim: ModuleType) -> None:
    connect(sim, sim.StaticSynapse(weight=-0.1), model="IF_curr_exp")
    connect(sim, sim.StaticSynapse(weight=0.1), model="IF_curr_exp")
    assert [projection.receptor for projection in sim.network().projections] == ["inhibitory", "excitatory"]


def test_a_negative_delay_an_unknown_receptor_and_a_source_as_target_are_refused(
    sim: ModuleType, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=r"'a→b'.*0 \(0 -> 0\).*-1"):
        connect(sim, sim.StaticSynapse(delay=-1.0))
    with golden.raises(errors.ConnectionError, match="'a→b'.*'b'.*'NMDA'"):
        connect(sim, sim.StaticSynapse(), receptor_type="NMDA")
    with golden.raises(NetworkError, match="'b'"):
        connect(sim, sim.StaticSynapse(), model="SpikeSourcePoisson")


def test_an_impossible_projection_is_refused(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(CapabilityError, match="location_selector"):
        connect(sim, sim.StaticSynapse(), sim.AllToAllConnector(location_selector="soma"))
    with golden.raises(NetworkError, match="'u'"):
        connect(sim, sim.StaticSynapse()).initialize(u=0.5)
    with golden.raises(NetworkError, match="'y2'.*'y'"):
        connect(sim, sim.TsodyksMarkramSynapse()).initialize(y2=0.5)


def test_the_share_in_use_is_a_share_and_sites_are_filled_up_to_their_number(
    sim: ModuleType, golden: Golden
) -> None:
    sites = connect(sim, sim.MultiQuantalSynapse(n=3, weight=0.1))
    sites.initialize(a=3, u=1.0)
    assert set(only(sim).initial_values["empty"]) == {0.0}
    with golden.raises(NetworkError):
        sites.initialize(a=4)
    sites.initialize(u=1.5)
    with golden.raises(NetworkError):
        sim.network()


def test_a_projection_without_synapses_is_fine(sim: ModuleType) -> None:
    connect(sim, sim.StaticSynapse(weight=0.1), sim.FixedProbabilityConnector(0.0))
    assert only(sim).size == 0


def test_the_old_function_connects_cells_and_groups_of_them(sim: ModuleType) -> None:
    group = cells(sim)
    with pytest.warns(DeprecationWarning, match="connect"):
        sim.connect(group[0], group, weight=0.1, delay=1.0)
    assert only(sim).post_index.tolist() == [0, 1, 2]


def test_a_weight_for_each_cell_instead_of_each_pair_is_refused_with_both_sizes(
    sim: ModuleType, golden: Golden
) -> None:
    with golden.raises(errors.InvalidParameterValueError):
        connect(sim, sim.StaticSynapse(weight=[0.1, 0.2]))


def test_weights_of_both_signs_are_counted_and_need_two_projections(sim: ModuleType, golden: Golden) -> None:
    weights = np.array([[0.1, -0.2, 0.3], [0.1, 0.2, 0.3]])
    with golden.raises(NetworkError):
        connect(sim, sim.StaticSynapse(weight=weights), model="IF_curr_exp")


def test_rewards_have_their_own_receptor_and_a_delay_of_a_step(sim: ModuleType, golden: Golden) -> None:
    connect(sim, sim.Neuromodulation(0.05, tau_c=90.0), receptor_type="reward", model="IF_curr_exp")
    reward = only(sim)
    assert reward.receptor == "reward"
    assert reward.neuromodulation == Neuromodulation(tau_c=90.0)
    assert set(reward.weight) == {0.05}
    assert set(reward.delay_ms) == {0.5}
    with golden.raises(NetworkError):
        connect(sim, sim.Neuromodulation(), receptor_type="excitatory")
    with pytest.raises(NetworkError, match="tau_x"):
        sim.Neuromodulation(tau_x=1.0)
