"""Synapse types of packages, which scripts use by name."""

from __future__ import annotations

from pathlib import Path

import pytest
from experiment_fixtures import Install
from golden import Golden

from nrp_core import load_network, read_network, save_network
from nrp_core.brain import builder
from nrp_core.errors import BackendLoadError, NetworkError

LAWS = """
from nrp_core.network.pynn.equation_models import equation_synapse

Depressing = equation_synapse(
    "dD/dt = (1 - D)/tau_D : 1 (event-driven)", on_pre="share = D; D *= depression",
    parameters={"tau_D": "300 ms", "depression": 0.4}, initial={"D": 1},
)
NUMBER = 3
"""
ENTRY_POINTS = """[nrp_core.synapses]
DepressingSynapse = lab_synapses:Depressing
NoSynapse = lab_synapses:NUMBER
MissingSynapse = lab_nothing:Law
"""
BRAIN = """
{imports}
setup(timestep=0.1)
a = Population(2, SpikeSourcePoisson())
b = Population(3, IF_curr_exp())
Projection(a, b, AllToAllConnector(), DepressingSynapse(weight=1.0, tau_D=100.0))
"""


@pytest.fixture(autouse=True)
def lab(install: Install) -> None:
    install("lab_synapses", ENTRY_POINTS, LAWS)


@pytest.mark.parametrize(
    "imports",
    [
        "from pyNN.nest import *",
        "from nrp_core.pynn import *",
        "from pyNN.neuron import (setup, Population, SpikeSourcePoisson, IF_curr_exp, Projection,\n"
        "    AllToAllConnector, DepressingSynapse)",
    ],
)
def test_a_script_uses_it_however_it_imports_the_simulator(imports: str, tmp_path: Path) -> None:
    script = tmp_path / "brain.py"
    script.write_text(BRAIN.format(imports=imports))
    network = load_network(script)
    (projection,) = network.projections
    assert projection.synapse_parameters["tau_D"].tolist() == [100.0] * 6
    assert projection.delay_ms.tolist() == [0.1] * 6
    save_network(network, tmp_path / "net.nrpnet")
    assert read_network(tmp_path / "net.nrpnet").digest == network.digest


def test_a_simulator_has_one_class_of_it_with_its_name_in_messages(golden: Golden) -> None:
    one, other = builder(), builder()
    for sim, timestep in ((one, 0.1), (other, 0.5)):
        sim.setup(timestep=timestep)
        assert sim.DepressingSynapse is sim.DepressingSynapse
        assert sim.DepressingSynapse(weight=1.0).delay == timestep
    assert one.DepressingSynapse is not other.DepressingSynapse
    with golden.raises(NetworkError, match="'tau'.*'tau_D'"):
        one.DepressingSynapse(tau=3.0)
    with golden.raises(AttributeError, match="'DepresingSynapse'.*'DepressingSynapse'"):
        _ = one.DepresingSynapse


def test_one_that_cannot_be_used_is_an_error_at_its_name_and_nowhere_else(golden: Golden) -> None:
    sim = builder()
    with golden.raises(BackendLoadError, match="'MissingSynapse' of lab_synapses"):
        _ = sim.MissingSynapse
    with golden.raises(BackendLoadError, match="'NoSynapse' of lab_synapses"):
        _ = sim.NoSynapse
    names: dict[str, object] = {}
    exec("from nrp_core.pynn import *", names)
    assert "DepressingSynapse" in names
    assert not names.keys() & {"NoSynapse", "MissingSynapse"}
