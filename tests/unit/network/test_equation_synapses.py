"""Synapse laws given as equations: mistakes with their line, scripts, files, other backends."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from golden import Golden

from nrp_core import read_network, save_network
from nrp_core.brain import builder
from nrp_core.brain.backends import brains
from nrp_core.errors import CapabilityError, NetworkError

EQUATIONS = """
dx/dt = (1 - x)/tau : 1 (event-driven)    # a comment
dy/dt = -y/tau_y : mV
"""
SHARE: dict[str, Any] = {
    "equations": EQUATIONS,
    "on_pre": "share = x; x *= 0.5",
    "parameters": {"tau": "20 ms", "tau_y": "5 ms", "w_max": "1 nA"},
    "initial": {"x": 1},
}
PLASTIC = {
    **SHARE,
    "on_pre": "y += 1*mV",
    "on_post": "weight = clip(weight + w_max*y/mV, 0*nA, w_max)",
    "weight_unit": "nA",
}


def with_line(line: str) -> dict[str, str]:
    return {"equations": EQUATIONS + line + "\n"}


MISTAKES = {
    "unknown name": ({"equations": EQUATIONS.replace("/tau_y", "/tau_z")}, "line 2.*'tau_z'.*mean 'tau_y'"),
    "rate": ({"equations": EQUATIONS.replace("/tau_y", "")}, "line 2.*is in V, but dy/dt is in V/s"),
    "clock": ({"equations": EQUATIONS.replace("event-d", "clock-d")}, "'clock-driven'.*valid: event-driven"),
    "refractory": (with_line("dz/dt = -z/tau : 1 (unless refractory)"), "'unless refractory'.*valid: ev"),
    "curved": (with_line("dz/dt = -z*z/tau : 1"), "line 3.*not linear in the state variables.*closed form"),
    "two variables": (with_line("dz/dt = x*y/mV/tau : 1"), "line 3.*not linear"),
    "driven by what is driven": (with_line("dz/dt = (x - z)/tau : 1"), "'x' does not only decay; between"),
    "time": (with_line("dz/dt = t/second/tau : 1"), "line 3.*depends on the time"),
    "weight in a rate": (with_line("dz/dt = weight/tau : 1"), "'weight' is only known where a"),
    "no unit": (with_line("dz/dt = -z/tau"), "line 3.*unit is missing"),
    "taken": (with_line("dw/dt = -w/tau : 1"), "line 3.*'w' is reserved.*the weight is 'weight'"),
    "parameter share": ({"parameters": {**SHARE["parameters"], "share": 1}}, "'share' is reserved"),
    "parameter quantity": ({"parameters": {"tau": "fast"}}, "parameters, 'tau: fast'.*a number with a unit"),
    "no effect": ({"on_pre": "x *= 0.5"}, "on_pre.*no effect; a spike arrives with 'share = ...'"),
    "statement": ({"on_pre": "share = x\nx == 1"}, "on_pre, line 2.*not an assignment"),
    "statement unit": ({"on_pre": "share = y"}, "on_pre, 'share = y'.*is in V, but 'share' is a"),
    "state unit": ({"on_pre": "share = x; x += y"}, "adds 'x'.*and 'y', which is in V"),
    "parameter changes": ({"on_pre": "share = x; tau = 1*ms"}, "'tau' is not a state variable"),
    "unknown target": ({"on_pre": "share = x; xx = 1"}, "unknown name 'xx'"),
    "share too late": ({"on_pre": "x *= share; share = x"}, "'share' is used before it has a value"),
    "share of a weight": ({"on_pre": "share = x*weight"}, "does not depend on 'weight'"),
    "share and weight": ({"on_pre": "share = x; weight += 1"}, "share .*or changes the weight, not both"),
    "share and on_post": ({"on_post": "x += 1"}, "in laws that change the weight, not"),
    "share in on_post": ({**PLASTIC, "on_post": "share = x"}, "on_post.*so it stands in on_pre"),
    "weight unit": ({**PLASTIC, "weight_unit": "1"}, "on_post.*adds 'weight'.*w_max.*in A"),
    "unknown weight unit": ({"weight_unit": "nAmp"}, "weight_unit, 'nAmp'.*did you mean 'namp'"),
    "initial name": ({"initial": {"z": 1}}, "initial, 'z: 1'.*no state variable 'z'"),
    "initial unit": ({"initial": {"y": "1 nA"}}, "'y' is in V, not in A"),
    "random": ({"on_pre": "share = int(rand() < x)"}, "'rand' is random"),
    "argument": ({"on_prae": "share = x"}, "no argument 'on_prae'; did you mean 'on_pre'"),
    "no dictionary": ({"parameters": ["tau"]}, "parameters is a dictionary, .*, not .'tau'"),
    "not a text": ({"on_pre": None}, "on_pre is a text, e.g. 'share = x; x .= 0.5'"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_error_with_its_place(name: str) -> None:
    changed, message = MISTAKES[name]
    builder().EquationSynapse(**SHARE)
    with pytest.raises(NetworkError, match=f"^EquationSynapse.*(?:{message})") as caught:
        builder().EquationSynapse(**{**SHARE, **changed})
    assert "\n" not in str(caught.value)


def network(law: dict[str, Any], kind: str = "IF_curr_exp", **values: Any) -> Any:
    sim = builder()
    cells = sim.Population(3, getattr(sim, kind)())
    synapse = sim.EquationSynapse(**law)(weight=0.5, delay=1.0, **values)
    sim.Projection(cells, cells, sim.AllToAllConnector(allow_self_connections=False), synapse, label="p")
    return sim.network()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tua": 3.0}, "EquationSynapse.*'tua'.*'tau'"),
        ({"tau": 0.0}, "'p': dx/dt.*= 0"),
        ({"tau": np.inf}, "'p'"),
        ({"kind": "IF_cond_exp"}, "'weight'.*uS"),
    ],
)
def test_values_that_a_law_cannot_have_are_refused(
    arguments: dict[str, Any], message: str, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=message):
        network(PLASTIC, **arguments)


def test_names_have_the_meaning_of_the_equations_and_not_of_pynn() -> None:
    law = {"equations": "", "on_pre": "share = U", "parameters": {"U": 3.0, "w_min": "1 mV", "w_max": "0 mV"}}
    (projection,) = network(law).projections
    assert projection.synapse_parameters["U"].tolist() == [3.0] * 6
    assert not projection.is_plastic
    assert network(PLASTIC).projections[0].is_plastic


def test_a_file_keeps_the_equations_and_the_digest_depends_on_them(tmp_path: Path) -> None:
    saved = network(PLASTIC, tau=7.0)
    save_network(saved, tmp_path / "net.nrpnet")
    read = read_network(tmp_path / "net.nrpnet")
    assert read.projections[0].equations == saved.projections[0].equations
    with h5py.File(tmp_path / "net.nrpnet") as file:
        assert file.attrs["version"] == 4  # which older readers refuse
    assert read.digest == saved.digest != network({**PLASTIC, "initial": {"x": 0.5}}, tau=7.0).digest


def test_a_backend_without_such_laws_refuses_them_by_name(golden: Golden) -> None:
    loaded = brains().load("spinnaker")
    with golden.raises(CapabilityError, match="'p'.; 'event'"):
        loaded.capabilities(loaded.options()).require(network(SHARE), "spinnaker")


def test_a_missing_delay_is_the_shortest_and_any_name_leaves_the_simulator_as_it_is() -> None:
    sim = builder()
    sim.setup(timestep=0.5)
    law = sim.EquationSynapse(**SHARE, name="StaticSynapse")
    assert law(weight=1.0).delay == 0.5
    a, b = sim.Population(1, sim.SpikeSourcePoisson()), sim.Population(1, sim.IF_curr_exp())
    sim.Projection(a, b, sim.OneToOneConnector())
    assert sim.network().projections[0].synapse_type == "static"
