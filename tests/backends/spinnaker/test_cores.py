"""The cores and keys of networks, against those that sPyNNaker 7.4.1 chose on its virtual board."""

from types import ModuleType
from typing import Any

import pytest
from nrp_brain_spinnaker import SpinnakerOptions
from nrp_brain_spinnaker.loader import lay_out
from nrp_brain_spinnaker.mapping import plan

from nrp_core.network.pynn import builder

DIRECT = """
poisson = sim.Population(300, sim.SpikeSourcePoisson(rate=10.0), label="poisson")
other = sim.Population(300, sim.SpikeSourcePoisson(rate=10.0), label="other")
cells = sim.Population(300, sim.IF_curr_exp(), label="cells")
sim.Projection(poisson, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay={delay}))
sim.Projection(other, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=1.0))
"""
ALONE = """
poisson = sim.Population(300, sim.SpikeSourcePoisson(rate=10.0), label="poisson")
cells = sim.Population(300, sim.IF_curr_exp(), label="cells")
sim.Projection(poisson, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=0.1))
"""
LONG = """
ring = [sim.Population(600, sim.IF_curr_exp(), label=label) for label in "ab"]
for pre, post in (ring, ring[::-1]):
    sim.Projection(pre, post, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=40.0))
"""
MANY = """
other = sim.Population(500, sim.SpikeSourcePoisson(rate=10.0), label="other")
cells = sim.Population(600, sim.IF_curr_exp(), label="cells")
for _ in range(5):
    sim.Projection(other, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=1.0))
"""


def mapped(script: str, timestep_ms: float) -> Any:
    sim: ModuleType = builder()
    sim.setup(timestep=timestep_ms)
    exec(script, {"sim": sim})
    network, options = sim.network(), SpinnakerOptions(timestep=f"{timestep_ms} ms")
    cells, wires, _ = lay_out(network, options)
    return {v.label: v for v in plan.map_network(network, cells, wires, options).vertices}


def cores(vertex: Any) -> list[tuple[int, int, int, int | None, int | None]]:
    return [(c.first, c.last, c.core, c.key, c.mask) for c in vertex.cores]


def test_poisson_sources_of_one_population_are_beside_its_cores_and_have_no_key() -> None:
    of = mapped(DIRECT.format(delay=0.1), 0.1)
    assert cores(of["other"]) == [(0, 300, 3, 0, 0xFFFFE000)]
    assert cores(of["poisson"]) == [(0, 256, 5, None, None), (256, 300, 8, None, None)]
    assert [c[:3] for c in cores(of["cells"])] == [(0, 256, 4), (0, 256, 6), (256, 300, 7), (256, 300, 9)]
    assert [c.has_synapses_alone for c in of["cells"].cores] == [True, False, True, False]
    assert of["poisson"].packets_per_s == 0.0


@pytest.mark.parametrize(
    ("script", "timestep_ms", "expected"),
    [
        (ALONE, 0.1, [(0, 256, 4), (256, 300, 5)]),  # without other input there are no synapse-only cores
        (DIRECT.format(delay=1.0), 1.0, [(0, 256, 5), (256, 300, 6)]),
    ],
)
def test_other_poisson_sources_have_cores_and_a_key_of_their_own(
    script: str, timestep_ms: float, expected: list[tuple[int, int, int]]
) -> None:
    of = mapped(script, timestep_ms)
    assert cores(of["poisson"]) == [(0, 300, 3, 0, 0xFFFFE000)]
    assert [c[:3] for c in cores(of["cells"])] == expected


def test_a_poisson_source_with_a_longer_delay_or_a_further_target_has_a_key() -> None:
    further = DIRECT.format(delay=0.1) + (
        "sim.Projection(poisson, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=0.1))"
    )
    for script in (DIRECT.format(delay=0.2), further):
        assert cores(mapped(script, 0.1)["poisson"]) == [(0, 300, 3, 0, 0xFFFFE000)]


def test_the_cores_of_synapses_come_before_that_of_their_neurons() -> None:
    of = mapped(MANY, 0.1)
    alone = [core.has_synapses_alone for core in of["cells"].cores]
    n = alone.index(False)
    assert n > 0
    assert alone == [*[True] * n, False] * 3


def test_a_ring_with_one_stage_of_delays_needs_no_bit_for_it_in_its_keys() -> None:
    of = mapped(LONG, 1.0)
    keys = {label: [(core.core, core.key, core.mask) for core in each.cores] for label, each in of.items()}
    mask = 0xFFFFF000
    assert keys == {
        "a": [(3, 0x0, mask), (4, 0x1000, mask), (5, 0x2000, mask)],
        "b": [(6, 0x4000, mask), (7, 0x5000, mask), (8, 0x6000, mask)],
        "a_delayed": [(9, 0x8000, mask), (10, 0x9000, mask), (11, 0xA000, mask)],
        "b_delayed": [(12, 0xC000, mask), (13, 0xD000, mask), (14, 0xE000, mask)],
    }


def test_a_population_without_input_has_one_delay_slot() -> None:
    of = mapped(
        "a, b = (sim.Population(20, sim.IF_curr_exp(), label=label) for label in 'ab')\n"
        "sim.Projection(a, b, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=5.0))\n",
        1.0,
    )
    assert (of["a"].delay_slots[1], of["b"].delay_slots[1]) == (1, 8)
