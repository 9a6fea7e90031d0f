"""Lines of a script, and values of an experiment, that have no effect on the network are told."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.network.files.script import load_network
from nrp_core.network.picking import with_views

IN_VAIN = {
    "sim.Projection(a, a, sim.AllToAllConnector(), rule, source='axon', label='p')":
        "'source' of the projection 'p' is 'axon' and has no effect: cells are points",
    "a.record('v', to_file='v.pkl')": "the data of 'a' are not written to 'v.pkl': the script only builds",
    "import nrp_core; net = nrp_core.Network({})":
        "the network 'net' has no effect: that of a script is called 'network'",
}  # fmt: skip
AS_MEANT = [
    "sim.Projection(a, a, sim.AllToAllConnector(), rule, source=None, label='p')",
    "rule.note = 'strong'; sim.Projection(a, a, sim.AllToAllConnector(), rule, label='p')",
    "rule = stdp(); sim.Projection(a, a, sim.AllToAllConnector(), rule, label='p')",
    "sim.Projection(a, a, sim.AllToAllConnector(), rule, label='p').set(weight=0.02)",
    "a.record('v')",
    "circuit = a",
    "circuit = {'a': a, 'half': a[:1], 'all': a + sim.Population(1, sim.IF_cond_exp())}",
    "def circuit(): pass",
    "import math as circuit",
]
SCRIPT = """\
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
a = sim.Population(2, sim.IF_cond_exp(), label="a")
rule = sim.StaticSynapse(weight=0.01, delay=1.0)
stdp = lambda: sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(), weight_dependence=sim.AdditiveWeightDependence(), weight=0.01
)
"""


@pytest.mark.parametrize("line", [*IN_VAIN, *AS_MEANT])
def test_a_line_of_a_script_without_effect_is_reported(line: str, tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(SCRIPT + line + "\n")
    assert load_network(path).remarks == ((IN_VAIN[line],) if line in IN_VAIN else ())


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, ()),
        ({"gain": 2.0}, ()),
        ({"gian": 2.0}, ("no parameter 'gian', so its value has no effect; did you mean 'gain'?",)),
    ],
)
def test_a_value_for_an_undeclared_parameter_is_reported(
    given: dict[str, float], told: tuple[str, ...], tmp_path: Path
) -> None:
    path = tmp_path / "brain.py"
    path.write_text(SCRIPT + "gain = sim.parameter('gain', 1.0)\n")
    found = load_network(path, parameters=given).remarks
    assert [one.removeprefix("the script declares ") for one in found] == list(told)


@pytest.mark.parametrize(
    ("populations", "told"),
    [
        ({"first": "0:1"}, 0),
        ({"a": "0:1"}, 1),  # the label of two cells
        ({"a": "0:2"}, 0),
        ({"pair": "1:2"}, 1),  # the name of a variable
        ({"pair": "0:2"}, 0),
    ],
)
def test_a_selection_that_hides_other_cells_of_its_name_is_reported(
    populations: dict[str, str], told: int, tmp_path: Path
) -> None:
    path = tmp_path / "brain.py"
    path.write_text(SCRIPT + "circuit = pair = a\n")
    name = next(iter(populations))
    for network in (
        load_network(path, populations=populations),
        with_views(load_network(path), populations),
    ):
        assert [one.startswith(f"the population '{name}' of the exp") for one in network.remarks] == [
            True
        ] * told
