"""Weights that are too small to make any cell fire are reported, and are not where anything is unknown."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.network_summary import summary_of
from nrp_core.checks.synaptic_effects import NOT_EXCITED, too_weak, unreached_thresholds
from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code
from nrp_core.network.data import Network
from nrp_core.network.pynn import builder

EXPERIMENT = """
name: crossed
duration: 1 s
timestep: 20 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: floor.sdf}
transfer_functions: [functions.py]
"""
BRAIN = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
eyes = sim.Population(2, sim.IF_curr_exp(tau_refrac=2.0), label="eyes")
wheels = sim.Population(2, sim.IF_curr_exp(tau_refrac=2.0), label="wheels")
sim.Projection(eyes, wheels, sim.OneToOneConnector(), sim.StaticSynapse(weight={weight}, delay=1.0))
"""
FUNCTIONS = """
import hbp_nrp_client.tf_framework as nrp

@nrp.MapSpikeSource("eye", nrp.brain.eyes, nrp.poisson, weight=20.0)
@nrp.Robot2Neuron()
def see(t, eye):
    eye.rate = 100.0

{drive}@nrp.MapSpikeSink("wheel", nrp.brain.wheels, nrp.population_rate)
@nrp.Neuron2Robot()
def drive(t, wheel{name}):
    print(wheel.rate)
"""
FLOOR = """<sdf version="1.6"><world name="floor"><model name="ground"><static>true</static><link name="link">
  <collision name="all"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model></world></sdf>"""


def weakly_excited(network: Network) -> list[str]:
    """Return the populations whose synapses are too weak, without those that nothing excites."""
    return [label for label, why in unreached_thresholds(network).items() if why != NOT_EXCITED]


def codes(folder: Path, weight: float, drive: str = "", name: str = "") -> list[Code]:
    (folder / "experiment.yaml").write_text(EXPERIMENT)
    (folder / "brain.py").write_text(BRAIN.format(weight=weight))
    (folder / "functions.py").write_text(FUNCTIONS.format(drive=drive, name=name))
    (folder / "floor.sdf").write_text(FLOOR)
    found = validate_file(folder / "experiment.yaml")
    return [one.code for one in found if one.code in (Code.NRP377, Code.NRP208, Code.NRP210)]


@pytest.mark.heavy
def test_a_weight_1000_times_too_small_is_reported(tmp_path: Path) -> None:
    assert codes(tmp_path, 20.0) == []
    assert codes(tmp_path, 0.02) == [Code.NRP377]


def test_cells_that_a_device_drives_too_are_not_reported(tmp_path: Path) -> None:
    drive = '@nrp.MapSpikeSource("push", nrp.brain.wheels, nrp.poisson, weight=20.0)\n'
    assert codes(tmp_path, 0.02, drive, ", push") == []


@pytest.mark.parametrize(
    ("source", "n", "weight", "is_reported"),
    [
        ("IF_curr_exp(tau_refrac=2.0)", 1, 0.02, True),  # at most 2 * 1 mV + 10 * 0.063 mV of 15 mV
        ("IF_curr_exp(tau_refrac=2.0)", 1, 1.0, False),
        ("IF_curr_exp(tau_refrac=2.0)", 100, 0.02, False),
        ("SpikeSourcePoisson(rate=10.0)", 1, 0.02, True),
        ("SpikeSourcePoisson(rate=2e4)", 1, 0.02, False),  # stands for thousands of neurons
        ("SpikeSourceArray(spike_times=[1.0, 101.0])", 1, 0.02, True),
        ("SpikeSourceArray(spike_times=[1.0, 101.0])", 1, 0.5, False),
        ("SpikeSourceGamma(alpha=2.0, beta=1.0)", 1, 0.02, False),  # of unknown rate
    ],
)
def test_the_rates_and_numbers_of_sources_decide(
    source: str, n: int, weight: float, is_reported: bool
) -> None:
    sim = builder()
    pre = eval(f"sim.Population({n}, sim.{source}, label='pre')", {"sim": sim})
    post = sim.Population(1, sim.IF_curr_exp(), label="post")
    sim.Projection(pre, post, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight))
    assert weakly_excited(sim.network()) == ["post"] * is_reported


def test_inhibition_does_not_excite() -> None:
    sim = builder()
    pre, post = (sim.Population(1, sim.IF_curr_exp(), label=name) for name in ("pre", "post"))
    sim.Projection(
        pre, post, sim.AllToAllConnector(), sim.StaticSynapse(weight=-0.02), receptor_type="inhibitory"
    )
    assert unreached_thresholds(sim.network()) == {"pre": NOT_EXCITED, "post": NOT_EXCITED}


def test_weights_that_may_grow_and_cells_that_fire_by_themselves_are_not_reported() -> None:
    sim = builder()
    pre = sim.Population(1, sim.IF_curr_exp(), label="pre")
    grows = sim.Population(1, sim.IF_curr_exp(), label="grows")
    fires = sim.Population(1, sim.IF_curr_exp(i_offset=1.0), label="fires")
    rule = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(), weight_dependence=sim.AdditiveWeightDependence(w_max=5.0),
        weight=0.02,
    )  # fmt: skip
    sim.Projection(pre, grows, sim.AllToAllConnector(), rule)
    sim.Projection(pre, fires, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.02))
    assert weakly_excited(sim.network()) == []


@pytest.mark.parametrize(("weight", "is_weak"), [(1e-6, True), (0.01, False)])
def test_a_device_is_judged_by_the_highest_rate_of_devices(weight: float, is_weak: bool) -> None:
    """100 kHz of 1 fA for 5 ms, on 20 Mohm, give 0.01 mV."""
    sim = builder()
    sim.Population(1, sim.IF_curr_exp(), label="cells")
    assert bool(too_weak(weight, sim.network().populations["cells"])) == is_weak


@pytest.mark.parametrize("threshold_mv", [1e6, 1e10, float("inf")])
def test_cells_that_are_meant_never_to_fire_are_not_reported(threshold_mv: float) -> None:
    sim = builder()
    source = sim.Population(1, sim.SpikeSourcePoisson(rate=10.0), label="source")
    cells = sim.Population(1, sim.IF_curr_exp(v_thresh=threshold_mv), label="cells")
    sim.Projection(source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.02))
    assert weakly_excited(sim.network()) == []
    assert not too_weak(1e-3, sim.network().populations["cells"])


def test_cells_that_act_by_their_voltages_are_not_reported() -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    one, two, three = (
        sim.Population(1, sim.IF_curr_exp(v_thresh=1e3), label=name) for name in ("1", "2", "3")
    )
    source = sim.Population(1, sim.SpikeSourcePoisson(rate=10.0), label="source")
    sim.Projection(source, two, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.02))
    sim.Projection(
        one, two, sim.OneToOneConnector(), sim.GradedSynapse(weight=-0.02), receptor_type="inhibitory"
    )
    sim.Projection(two, three, sim.OneToOneConnector(), sim.ElectricalSynapse(weight=0.02))
    summary = summary_of(sim.network())
    assert summary.unreached == {}
    assert {("2", "3"), ("3", "2")} < set(summary.joined)
    assert ("2", "1") not in summary.joined
