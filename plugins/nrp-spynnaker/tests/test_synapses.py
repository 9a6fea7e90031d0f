"""Synapses of sPyNNaker's scripts: kernels over grids, rules of its own, synapses that form and vanish."""

from dataclasses import replace
from math import exp
from pathlib import Path

import h5py
import numpy as np
import pytest
from golden import Golden
from nrp_brain_event.backend import EventBackend
from nrp_brain_spinnaker import SpinnakerBackend
from nrp_spynnaker.dialect import Dialect
from scipy.signal import convolve2d, correlate2d
from spynnaker_scripts import HEAD, mapped, refused, run

from nrp_core import save_network
from nrp_core.errors import CapabilityError
from nrp_core.network.files.network_file import read_network
from nrp_core.network.files.script import load_network
from nrp_core.network.pynn import builder


def test_synapses_have_the_arguments_and_results_of_sPyNNaker(tmp_path: Path) -> None:  # noqa: N802
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(3, p.IF_curr_exp())\n"
        "synapse = p.StaticSynapse(2.5, 3.0)\nown = synapse.weight, synapse.delay\n"
        "ends = p.PopulationView(cells, range(2)), p.PopulationView(cells, (0, 2))\n"
        "some = p.Projection(*ends, p.AllToAllConnector(), synapse)\n"
        "rows = [(1, 0, 0.5, 1.0), (0, 1, 2.0, 1.0), (1, 0, 3, 1)]\n"
        "twice = p.Projection(*ends, p.FromListConnector(rows))\n",
    )
    some, own = script.some, script.own
    assert own == (2.5, 3.0)
    assert some.get("weight", "list") == [(i, j, 2.5) for i in (0, 1) for j in (0, 1)]
    assert (some.get(["weight"], "list", with_address=False)[:] - 0.5 == 2.0).all()
    assert (some.get(["weight"], "array") == 2.5).all()
    assert some.get([], "list") == [(0, 0), (0, 1), (1, 0), (1, 1)]  # its test_synaptic_expander.py
    assert (some.get("weight", "nparray") == 2.5).all()  # its test_large_pop_weight_delay_retrieval.py
    weights, delays = some.get(["weight", "delay"], "array")
    assert (weights.shape, delays[1, 1]) == ((2, 2), 3.0)
    assert script.twice.get("weight", "array")[1, 0] == 3.0  # the last of two, not their sum
    assert script.twice.get("weight", "list") == [(0, 1, 2.0), (1, 0, 0.5), (1, 0, 3.0)]


LEARNS = """
late = p.Population(1, p.SpikeSourceArray([15.0]), label="late")
early = p.Population(1, p.SpikeSourceArray([10.0, 150.0]), label="early")
cell = p.Population(1, p.IF_curr_exp(tau_refrac=90.0), label="cell")
p.Projection(late, cell, p.OneToOneConnector(), p.StaticSynapse(weight=40.0, delay=1.0))
rule = p.STDPMechanism(
    p.SpikePairRule(tau_plus=100.0, A_plus=0.1, A_minus=0.0), p.AdditiveWeightDependence(w_max={w_max})
)
plastic = p.Projection(early, cell, p.OneToOneConnector(), rule, label="plastic")
"""


@pytest.mark.parametrize("w_max", [0.5, 8.0])
def test_a_rule_of_pairs_changes_weights_by_its_amplitude_wherever_it_runs(
    tmp_path: Path, w_max: float
) -> None:
    """sPyNNaker 7.4.1 does not multiply ``A_plus`` by ``w_max``, and PyNN does."""
    lines = HEAD + LEARNS.format(w_max=w_max)
    script = run(
        tmp_path, f"{lines}p.run(200)\nweights = plastic.get('weight', 'list', with_address=False)\n"
    )
    found = [script.weights[0]]
    (tmp_path / "brain.py").write_text(lines)
    network = load_network(tmp_path / "brain.py")
    for backend in (EventBackend, SpinnakerBackend):
        options = backend.options.model_validate({})
        with backend().open(network, seed=0, options=options) as brain:
            brain.run_until(200_000_000)
            found.append(brain.read_weights("plastic")[0])
    assert found == pytest.approx([0.1 * exp(-6.0 / 100.0)] * 3, rel=0.03)


def test_the_rule_of_vogels_has_its_parameters(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "rule = p.extra_models.Vogels2011Rule(alpha=0.12, tau=20.0, A_plus=0.05)\n"
        "limits = p.AdditiveWeightDependence(w_min=0.0, w_max=1.0)\n"
        "cells = p.Population(2, p.IF_curr_exp())\n"
        "law = p.STDPMechanism(timing_dependence=rule, weight_dependence=limits, weight=0.5)\n"
        "wires = p.Projection(cells, cells, p.AllToAllConnector(), law, receptor_type='inhibitory')\n"
        "(made,) = p.network().projections\np.run(10)\n",
    )  # fmt: skip
    values = {name: set(each) for name, each in script.made.synapse_parameters.items()}
    assert values["eta"] == {0.05}
    assert list(values["rho"]) == pytest.approx([3.0])  # Hz; alpha is 2 rho tau
    assert values["tau"] == {20.0}


GRIDS = """
import h5py
import numpy as np
conn = p.ConvolutionConnector({arguments})
width, height = conn.get_post_shape((7, 6))
image = p.Population(7 * 6, p.SpikeSourceArray([1.0]), structure=p.Grid2D(7 / 6), label="image")
seen = p.Population(width * height, p.IF_curr_exp(), structure=p.Grid2D(width / height), label="seen")
wires = p.Projection(image, seen, conn, p.Convolution(delay=2.0))
matrix = np.nan_to_num(wires.get("weight", "array"))
network = p.network()
"""
DRAWN = "p.RandomDistribution('uniform', low=2.0, high=9.0)"
KERNEL = [[1.0, -2.0, 3.0], [4.0, 5.0, -6.0], [7.0, 8.0, 9.0]]


@pytest.mark.parametrize("padding", [0, 1, 2])
def test_a_convolution_is_one(tmp_path: Path, padding: int) -> None:
    script = run(tmp_path, HEAD + GRIDS.format(arguments=f"{KERNEL}, padding={padding}"))
    image = np.random.default_rng(1).normal(size=(6, 7))
    whole, cut = convolve2d(image, KERNEL), 2 - padding
    expected = whole[cut : 8 - cut, cut : 9 - cut]
    assert (script.height, script.width) == expected.shape
    assert script.matrix.T @ image.ravel() == pytest.approx(expected.ravel())
    both = {one.receptor: one for one in script.network.projections}
    assert both["excitatory"].weight.min() == 1.0
    assert set(both["inhibitory"].weight) == {-2.0, -6.0}
    assert set(both["inhibitory"].delay_ms) == {2.0}


def test_delays_that_a_kernel_does_not_give_are_drawn_for_each_synapse(tmp_path: Path) -> None:
    lines = GRIDS.format(arguments=KERNEL).replace("delay=2.0", f"delay={DRAWN}")
    whole = "near = p.KernelConnector((6, 7), (6, 7), 3, np.ones((3, 3)))\n"
    further = f"near = p.Projection(image, image_cells, near, p.StaticSynapse(delay={DRAWN}))\n"
    cells = "image_cells = p.Population(7 * 6, p.IF_curr_exp())\n"
    script = run(tmp_path, HEAD + lines + cells + whole + further)
    for wires in (script.wires, script.near):
        delays = np.array(wires.get("delay", "list"))[:, 2]
        assert len(set(delays)) == len(delays) == len(wires)
        assert 2.0 <= delays.min() < 3.0 < 8.0 < delays.max() <= 9.0


def test_steps_and_pools_of_a_convolution_are_those_of_the_release(tmp_path: Path) -> None:
    arguments = f"{KERNEL}, strides=(1, 2), pool_shape=2, padding=1"
    script = run(tmp_path, HEAD + GRIDS.format(arguments=arguments))
    expected = np.zeros((7 * 6, script.width * script.height))
    for cell in range(7 * 6):
        x, y = cell % 7 // 2, cell // 7 // 2  # pooled; the kernel's middle and the padding take 1 and add 1
        for row in (0, 1, 2):
            for column in (0, 1, 2):
                at_x, at_y = x - 1 + column, y // 2 - 1 + row
                if 0 <= at_x < script.width and 0 <= at_y < script.height:
                    expected[cell, at_y * script.width + at_x] += KERNEL[row][column] / 4
    assert (script.width, script.height) == (3, 1)  # (7 // 2 - 2 + 2) // 1 and (6 // 2 - 2 + 2) // 2
    assert (script.matrix == expected).all()


def test_the_binary_point_of_a_convolution_follows_its_kernel(tmp_path: Path) -> None:
    script = run(tmp_path, HEAD + GRIDS.format(arguments=KERNEL))
    (shifts,) = (v.left_shifts for v in mapped(script.network) if v.label == "seen")
    assert tuple(shifts) == (7, 6)  # the powers of two above 9 weights of 9, and above 9 of 6


def test_a_kernel_lies_over_each_target(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "import numpy as np\n"
        "image, seen = (p.Population(7 * 6, p.IF_curr_exp(), label=label) for label in ('image', 'seen'))\n"
        "near = p.KernelConnector((6, 7), (6, 7), (3, 3), weight_kernel=np.arange(1, 10).reshape(3, 3),\n"
        "    delay_kernel=np.arange(11, 20).reshape(3, 3))\n"
        "wires = p.Projection(image, seen, near, p.StaticSynapse(weight=100.0))\n"
        "matrix = np.nan_to_num(wires.get('weight', 'array'))\n"
        "rows = wires.get(['weight', 'delay'], 'list')\n"
        "half = p.KernelConnector((6, 7), (3, 3), (1, 1), post_sample_steps_in_pre=(2, 2),\n"
        "    post_start_coords_in_pre=(1, 1))\n"
        "few = p.Population(9, p.IF_curr_exp())\n"
        "picked = p.Projection(image, few, half, p.StaticSynapse(weight=3.0)).get('weight', 'list')\n",
    )  # fmt: skip
    image = np.random.default_rng(1).normal(size=(6, 7))
    expected = correlate2d(image, np.arange(1.0, 10.0).reshape(3, 3), mode="same")
    assert script.matrix.T @ image.ravel() == pytest.approx(expected.ravel())
    assert {row[3] - row[2] for row in script.rows} == {10.0}
    places = [(1 + 2 * r) * 7 + 1 + 2 * c for r in range(3) for c in range(3)]
    assert sorted(tuple(row) for row in script.picked) == [(at, k, 3.0) for k, at in enumerate(places)]


STRUCTURAL = """
stim = p.Population(9, p.SpikeSourceArray(range(10)), label="stim")
full, gone = (p.Population(9, p.IF_curr_exp(), label=label) for label in ("full", "gone"))
rules = {"partner_selection": p.RandomSelection(), "f_rew": 1000, "s_max": 9, "seed": 0}
never = p.RandomByWeightElimination(threshold=4.0, prob_elim_depressed=0, prob_elim_potentiated=0)
always = p.RandomByWeightElimination(threshold=4.0, prob_elim_depressed=1.0, prob_elim_potentiated=1.0)
near = p.DistanceDependentFormation(grid=(3, 3), p_form_forward=1.0, sigma_form_forward=1e10)
nowhere = p.DistanceDependentFormation(grid=(3, 3), p_form_forward=0.0)
forms = p.Projection(stim, full, p.FromListConnector([]), p.StructuralMechanismStatic(
    formation=near, elimination=never, initial_weight=4.0, initial_delay=3.0, **rules))
vanishes = p.Projection(stim, gone, p.AllToAllConnector(), p.StructuralMechanismSTDP(
    formation=nowhere, elimination=always, initial_weight=2.0, initial_delay=5.0, weight=1.0, delay=1.0,
    timing_dependence=p.SpikePairRule(), weight_dependence=p.AdditiveWeightDependence(), **rules))
"""


def test_synapses_form_and_vanish_while_a_script_runs(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + STRUCTURAL + "counts = [len(vanishes.get('weight', 'list'))]\np.run(1000)\n"
        "found, counts = forms.get(['weight', 'delay'], 'list'), [*counts, len(vanishes)]\n"
        "sums = forms.get('weight', 'array', multiple_synapses='sum')\n",
    )  # fmt: skip
    assert script.counts == [81, 0]
    assert {tuple(row)[2:] for row in script.found} == {(4.0, 3.0)}
    # all places but those that the last rows without room left open
    assert 70 < len(script.found) <= 81
    assert np.nansum(script.sums) == 4.0 * len(script.found)


def test_formations_and_eliminations_of_synapses_are_recorded_as_events(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + STRUCTURAL + "full.record(['rewiring', 'spikes'])\ngone.record('rewiring')\np.run(500)\n"
        "first = full.get_data('rewiring', clear=True).segments[0].events\np.run(500)\n"
        "rest, lost = (part.get_data().segments[0].events for part in (full, gone))\n"
        "found, n = forms.get('weight', 'list'), len(full.get_data('spikes').segments[0].events)\n",
    )
    names = ["rewiring_form", "rewiring_elim"]
    assert [event.name for event in script.first] == [event.name for event in script.rest] == names
    pairs = sorted(f"{pre:.0f}_{post:.0f}_formation" for pre, post, _ in script.found)
    every = [str(label) for events in (script.first, script.rest) for label in events[0].labels]
    assert sorted(every) == pairs
    assert script.first[0].times.max() < 500.0 <= script.rest[0].times.min()
    both = sorted(f"{pre}_{post}_elimination" for pre in range(9) for post in range(9))
    assert sorted(script.lost[1].labels.tolist()) == both  # all to all; one synapse at a time
    assert (np.diff(script.lost[1].times.magnitude) >= 1.0).all()
    assert script.lost[0].size == script.n == 0
    kept = script.gone.get_data().segments[0].events  # its brain is closed
    assert kept[1].labels.tolist() == script.lost[1].labels.tolist()


def test_changes_of_synapses_are_not_those_of_a_view_or_of_other_cells(tmp_path: Path) -> None:
    lines = STRUCTURAL.strip() + "\nfull.record('rewiring'); p.run(5); full[:3].get_data('rewiring')"
    assert "'rewiring' is of all its cells" in str(refused(tmp_path, f"exec({lines!r})"))
    source = "p.Population(1, p.SpikeSourceArray()).record('rewiring')"
    assert "has no 'rewiring' to record" in str(refused(tmp_path, source))


def test_a_mechanism_of_two_populations_gives_them_one_stream_of_seeds(tmp_path: Path) -> None:
    lines = STRUCTURAL.replace('"seed": 0', '"seed": 5') + (
        "law = forms.synapse_type\nmore, last = (p.Population(9, p.IF_curr_exp(), label=x) for x in 'yz')\n"
        "for target in (last, more):\n    p.Projection(stim, target, p.FromListConnector([]), law)\n"
        "network = p.network()\n"
    )
    network = run(tmp_path, HEAD + lines).network
    save_network(network, tmp_path / "kept.nrpnet")
    for each in (network, read_network(tmp_path / "kept.nrpnet")):
        streams = {one.post: one.rewiring.stream for one in each.projections if one.rewiring}
        assert streams == {"full": "full", "gone": "", "y": "full", "z": "full"}


def test_structural_plasticity_is_kept_in_files_and_refused_by_others(tmp_path: Path, golden: Golden) -> None:
    script = run(tmp_path, f"{HEAD}{STRUCTURAL}network = p.network()\n")
    save_network(script.network, tmp_path / "kept.nrpnet")
    kept = read_network(tmp_path / "kept.nrpnet")
    assert kept.digest == script.network.digest
    assert [one.rewiring for one in kept.projections] == [one.rewiring for one in script.network.projections]
    with golden.raises(CapabilityError, match="'stim→full'"):
        EventBackend().open(script.network, seed=0, options=EventBackend.options())
    assert {v.label: v.synapse_cores for v in mapped(script.network)} == {"stim": 0, "full": 1, "gone": 1}


def test_numbers_of_numpy_are_those_of_python(tmp_path: Path) -> None:
    own = STRUCTURAL.replace('"f_rew": 1000, "s_max": 9', '"f_rew": np.float32(1000), "s_max": np.int64(9)')
    plain, numpy = (
        run(tmp_path, f"import numpy as np\n{HEAD}{lines}network = p.network()\n").network
        for lines in (STRUCTURAL, own)
    )
    assert numpy.digest == plain.digest
    save_network(numpy, tmp_path / "kept.nrpnet")
    assert read_network(tmp_path / "kept.nrpnet").digest == plain.digest


def test_structural_plasticity_between_parts_of_populations_is_refused(tmp_path: Path) -> None:
    lines = STRUCTURAL.strip().replace("Projection(stim, full,", "Projection(stim, full[:3],")
    error = refused(tmp_path, f"exec({lines!r})")
    assert "its synapses form between all cells of two populations" in str(error)


REWARDED = """
law = p.STDPMechanism(p.SpikePairRule(), p.AdditiveWeightDependence(), weight=0.5)
pre, good = (p.Population(2, p.SpikeSourceArray([1.0]), label=name) for name in ("pre", "good"))
cells = p.Population(2, p.IF_curr_exp(), label="cells")
p.Projection(pre, cells, p.AllToAllConnector(), law)
dopamine = p.extra_models.Neuromodulation(0.05, tau_c=100.0, tau_d=5.0, w_max=20.0)
p.Projection(good, cells, p.OneToOneConnector(), dopamine, receptor_type="punishment")
network = p.network()
p.run(10)
"""


def test_rewards_are_those_of_the_builder() -> None:
    sim = builder()
    assert Dialect(sim).simulator.extra_models.Neuromodulation is sim.Neuromodulation


def test_rewards_are_kept_in_files_and_refused_by_other_backends(tmp_path: Path, golden: Golden) -> None:
    network = run(tmp_path, HEAD + REWARDED).network
    save_network(network, tmp_path / "net.nrpnet")
    found = read_network(tmp_path / "net.nrpnet")
    assert found.digest == network.digest
    save_network(replace(network, projections=network.projections[:1]), tmp_path / "older.nrpnet")
    with h5py.File(tmp_path / "net.nrpnet") as new, h5py.File(tmp_path / "older.nrpnet") as older:
        assert (new.attrs["version"], older.attrs["version"]) == (6, 2)  # 2: shared trains
    reward = found.projections[1]
    assert reward.receptor == "punishment"
    assert reward.neuromodulation is not None
    assert reward.neuromodulation.data() == {"tau_c": 100.0, "tau_d": 5.0, "w_min": 0.0, "w_max": 20.0}
    without = replace(EventBackend().capabilities(EventBackend.options()), neuromodulation=False)
    with golden.raises(CapabilityError, match="'good→cells'.*'spinnaker'"):
        without.require(found, "another")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "p.Projection(p.Population(1, cell), p.Population(1, cell), p.OneToOneConnector(),"
            " p.extra_models.Neuromodulation())",
            "have no receptor 'excitatory' for Neuromodulation",
        ),
        ("p.extra_models.Neuromodulation(tau_d=0.0)", "tau_d is 0.0; it must be more than 0"),
        ("p.extra_models.Neuromodulation(w_min=2.0)", "w_min is 2; it must be at most w_max, 1"),
        ("p.STDPMechanism(p.SpikePairRule(), neuromodulation=True)", "does not say how rewards act"),
        ("p.extra_models.PfisterSpikeTriplet(16.0, 33.0)", "no default for tau_x, tau_y, A_plus, A_minus"),
        (
            "p.STDPMechanism(p.SpikePairRule(), p.extra_models.WeightDependenceAdditiveTriplet())",
            "is that of PfisterSpikeTriplet",
        ),
    ],
)
def test_a_mistake_in_a_rule_is_named(tmp_path: Path, line: str, message: str) -> None:
    assert message in str(refused(tmp_path, line))


def test_the_rules_of_triplets_and_of_nearest_pairs_have_their_parameters(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(2, p.IF_curr_exp())\n"
        "triplets = p.extra_models.PfisterSpikeTriplet(16.8, 33.7, 101.0, 125.0, 0.01, 0.02)\n"
        "limits = p.extra_models.WeightDependenceAdditiveTriplet(0.1, 2.0, A3_plus=0.3)\n"
        "law = p.STDPMechanism(triplets, limits, weight=0.5, backprop_delay=False)\n"
        "p.Projection(cells, cells, p.AllToAllConnector(), law)\n"
        "others = p.Population(2, p.IF_curr_exp())\n"
        "nearest = p.extra_models.SpikeNearestPairRule(A_plus=0.05)\n"
        "law = p.STDPMechanism(nearest, p.AdditiveWeightDependence())\n"
        "p.Projection(others, others, p.AllToAllConnector(), law)\n"
        "three, two = p.network().projections\np.run(10)\n",
    )  # fmt: skip
    given = {"tau_x": 101.0, "tau_y": 125.0, "A_minus": 0.02, "A3_plus": 0.3, "A3_minus": 0.01, "w_max": 2.0}
    values = {name: float(each[0]) for name, each in script.three.synapse_parameters.items()}
    assert {name: values[name] for name in given} == given
    assert values["dendritic_delay_fraction"] == 0.0
    assert script.two.plasticity["timing_dependence"] == "SpikeNearestPairRule"
    assert script.two.synapse_parameters["A_plus"][0] == 0.05
