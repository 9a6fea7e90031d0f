"""Cells given as equations: units, mistakes with their line, what scripts and files keep."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core import read_network, save_network
from nrp_core.brain import builder
from nrp_core.brain.network.equations.linear import coefficients_of, linear_part
from nrp_core.brain.network.equations.units import NONE, described, quantity, times, unit_of, units
from nrp_core.brain.network.implausible import implausible
from nrp_core.errors import NetworkError

MEMBRANE = """
dv/dt = (v_rest - v + R*(ge + i_offset))/tau : mV (unless refractory)   # a comment
dge/dt = -ge/tau_syn : nA
"""
TEXTS: dict[str, Any] = {
    "equations": MEMBRANE,
    "threshold": "v > v_thresh",
    "reset": "v = v_rest",
    "refractory": "tau_refrac",
    "receptors": {"excitatory": "ge += weight"},
    "parameters": {
        "v_rest": "-65 mV", "v_thresh": "-50 mV", "R": "20 Mohm", "tau": "20 ms", "tau_syn": "5*ms",
        "tau_refrac": "2 ms", "i_offset": "0.1 nA",
    },
    "initial": {"v": "-0.06 volt"},
}  # fmt: skip


def cell(sim: Any = None, **changed: Any) -> Any:
    return (sim or builder()).EquationCell(**{**TEXTS, **changed})


def with_line(line: str) -> str:
    return MEMBRANE + line + "\n"


def with_parameter(**values: str) -> dict[str, Any]:
    return {"parameters": {**TEXTS["parameters"], **values}}


MISTAKES = {
    "unknown time": ({"refractory": "t_ref"}, "unknown name 't_ref'; (?!did you mean 'metre')"),
    "unknown unit": ({"threshold": "v > -50*mvolts"}, "unknown name 'mvolts'; did you mean 'mvolt'"),
    "other case": ({"threshold": "V > -50*mV"}, "unknown name 'V'; did you mean 'v'"),
    "unknown name": ({"equations": MEMBRANE.replace("/tau ", "/taum ")}, "line 1.*'taum'.*mean 'tau'"),
    "sum of units": ({"equations": MEMBRANE.replace("R*", "")}, "line 1.*'v_rest - v', which is in V.*in A"),
    "rate": ({"equations": MEMBRANE.replace("-ge/tau_syn", "-ge")}, "line 2.*is in A, but dge/dt is in A/s"),
    "no unit": ({"equations": with_line("dx/dt = -x/tau")}, "line 3.*unit is missing"),
    "unit": ({"equations": with_line("dx/dt = -x/tau : mvolts")}, "line 3.*'mvolts'.*did you mean 'mvolt'"),
    "letters": ({"equations": MEMBRANE.replace("tau_syn", "τ")}, "line 2.*'τ' is not an ASCII"),
    "reserved": ({"equations": with_line("t = 3*mV : mV")}, "line 3.*'t' is reserved"),
    "keyword": (with_parameter(**{"lambda": "1"}), "'lambda' cannot be a name"),
    "circle": ({"equations": with_line("x = 2*y : mV\ny = x : mV")}, "line 3.*'x' needs its own value"),
    "twice": ({"equations": with_line("dv/dt = 0*mV/ms : mV")}, "line 3.*'v' is defined twice"),
    "argument": ({"equations": with_line("y = exp(v) : 1")}, "line 3.*exp takes a number without a unit"),
    "noise": ({"equations": with_line("dx/dt = xi/ms : 1")}, "line 3.*'xi' is random"),
    "power": ({"equations": with_line("y = v^2 : mV**2")}, "line 3.*a power is written with"),
    "flag": ({"equations": with_line("dx/dt = -x/tau : 1 (summed)")}, "line 3.*'summed'.*unless refractory"),
    "no value": ({"equations": with_line("g : nS")}, "line 3.*'g' has no value.*'g': '20 nS'"),
    "nothing": ({"equations": ""}, "no state variable"),
    "no threshold": ({"threshold": ""}, "needs a threshold"),
    "no condition": ({"threshold": "v"}, "threshold, 'v'.*but a threshold is a condition"),
    "one =": ({"threshold": "v = v_thresh"}, "equality is written =="),
    "compared": ({"threshold": "v > 3"}, "'v', which is in V, and '3', which is a number without a unit"),
    "reset": ({"reset": "v == 3*mV"}, "reset, 'v == 3.mV'.*not an assignment"),
    "reset unit": ({"reset": "v = 1*nA"}, "is in A, but 'v' is in V"),
    "second reset": ({"reset": "v = v_rest\nu += 1*mV"}, "reset, line 2.*unknown name 'u'"),
    "reset parameter": ({"reset": "v_rest = v"}, "'v_rest' is not a state variable.*dv_rest/dt"),
    "negative": ({"refractory": "-2 ms"}, "refractory.*0 or more"),
    "negative parameter": (with_parameter(tau_refrac="-2 ms"), "'tau_refrac', is -2 ms"),
    "refractory unit": ({"refractory": "2 mV"}, "is a time, e.g. '2 ms', not in V"),
    "receptor": ({"receptors": {"excitatry": "ge"}}, "no receptor 'excitatry'; did you mean 'excitatory'"),
    "nonlinear": ({"receptors": {"excitatory": "ge += weight*v/mV"}}, "in proportion to its weight"),
    "not exact": ({"equations": with_line("dx/dt = x*x/ms : 1"), "method": "exact"}, "line 3.*not linear"),
    "method": ({"method": "euler"}, "no method 'euler'; valid: exact, runge_kutta"),
    "current": (with_parameter(i_offset="1 mV"), "'i_offset' is the injected current"),
    "whole": ({"equations": MEMBRANE.replace("/tau ", "//tau ")}, "counts by //.*is in V, and 'tau'"),
    "endless": ({"reset": "v = v_thresh + 1*mV"}, "still meets the threshold"),
    "initial": ({"initial": {"u": "3 mV"}}, "initial has no state variable 'u'"),
    "initial unit": ({"initial": {"v": "3 nA"}}, "'v' is in mV"),
    "no derivative": ({"equations": MEMBRANE.replace("dv/dt", "v")}, "line 1.*begins with its derivative"),
    "no dictionary": ({"parameters": ["tau"]}, "parameters is a dictionary, .*, not .'tau'"),
    "a number": ({"refractory": 2.0}, "refractory is a text, e.g. '2 ms'"),
    "loose parameter": ({"tau_m": "20 ms"}, "no argument 'tau_m'.*parameters="),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_error_with_its_place(name: str) -> None:
    changed, message = MISTAKES[name]
    with pytest.raises(NetworkError, match=f"(?s){message}") as caught:
        cell(**changed)
    assert "\n" not in str(caught.value)


SLOW = "da/dt = -a/(20*second) : nA\n"
SPIKE = "v = v_rest; a += 0.01*nA"
HELD = MEMBRANE.replace("(ge", "(ge - a") + "da/dt = -a/(20*ms) : nA\n"
SLOWED = HELD.replace(" (unless refractory)", "")
FLAG = MEMBRANE + "dn/dt = 0/ms : 1\n"
ADAPTING = MEMBRANE + "dtheta/dt = (v_thresh + 0.3*(v - v_rest) - theta)/(50*ms) : mV\n"
CURVED = MEMBRANE.replace("R*", "2*mV*exp((v + 50*mV)/(2*mV)) + R*")
DOUBTS = {
    "none": ({}, None),
    "initial": (with_parameter(v_init="3 mV"), None),
    "maximum": ({"threshold": "v > v_thresh and ge < 1*nA", "reset": ""}, None),
    "parameter": (with_parameter(extra="3 mV"), "the parameter 'extra' is not used"),
    "expression": ({"equations": with_line("x = v/mV : 1")}, "'x' is not used"),
    "receptor": ({"equations": MEMBRANE.replace("(ge + i", "(i")}, "receptor 'excitatory' never change when"),
    "negative": (with_parameter(tau_syn="-5 ms"), "tau_syn is -5 ms: a time is more than 0"),
    "grows": ({"equations": MEMBRANE.replace("-ge/tau", "ge/tau")}, "a cell grows by a factor of e in 5 ms"),
    "volts": (with_parameter(v_rest="-65 volt"), "v_rest is 65000 mV; is it in another unit"),
    "threshold": ({"threshold": "v > 1*volt"}, "the threshold, 'v > 1.volt', is 1000 mV"),
    "at once": ({"initial": {"v": "-40 mV"}}, "meet the threshold, 'v > v_thresh', from the start"),
    "no reset": ({"reset": ""}, "the reset changes nothing"),
    "held": ({"equations": HELD, "reset": "a += 1*nA"}, "the reset does not change v, which the refr"),
    "held threshold": ({"equations": HELD, "threshold": "v > v_thresh + a*Mohm", "reset": "a += 5*nA"}, None),
    "not held": ({"equations": SLOWED, "reset": "a += 1*nA"}, None),
    "no change": ({"reset": "v = v"}, "the reset changes nothing"),
    "long": ({"refractory": "2 second"}, "the refractory period is 2 s"),
    "always": ({"refractory": "v > -100*mV"}, "cells are refractory from the start"),
    "limits": ({"equations": MEMBRANE.replace("(ge +", "(clip(ge, 1*nA, 0*nA) +")}, "limits of clip are r"),
    "slow adaptation": ({"equations": MEMBRANE.replace("(ge", "(ge - a") + SLOW, "reset": SPIKE}, None),
    "seconds": (with_parameter(tau="20 second"), "v changes with a time constant of 2e+04 ms; is it in"),
    "synaptic seconds": (with_parameter(tau_syn="20*second"), "ge changes with a time constant of 2e+04 ms"),
    "microseconds": (with_parameter(tau="20 usecond"), "v changes with a time constant of 0.02 ms"),
    "in the text": ({"equations": MEMBRANE.replace("/tau ", "/(20*second) ")}, "time constant of 2e+04 ms"),
    "curved": ({"equations": CURVED, **with_parameter(tau="20 second")}, "v changes with a time constant of"),
    "microvolts": (with_parameter(v_thresh="-50 uV"), "the threshold, 'v > v_thresh', is -0.05 mV; is it"),
    "from 0": (with_parameter(v_rest="0 mV", v_thresh="15 uV"), "'v > v_thresh', is 0.015 mV; is it in"),
    "far": (with_parameter(v_thresh="500 mV"), "is 500 mV, and v is reset to -65 mV; is one in another un"),
    "far start": ({"initial": {"v": "-650 mV"}}, "is -50 mV, and v begins at -650 mV; is one in another"),
    "tiny rest": ({"reset": "v = -65*mV", **with_parameter(v_rest="-65 uV")}, "v_rest is -0.065 mV; is"),
    "tiny start": ({"initial": {"v": "-0.065 mV"}}, "v is -0.065 mV; is it in another unit"),
    "injected": (with_parameter(i_offset="100 nA"), "i_offset is 100 nA; is it in another unit"),
    "against": ({"equations": MEMBRANE.replace("+ i_", "- i_")}, "positive i_offset takes v away from"),
    "idle": ({"equations": MEMBRANE + SLOW, "reset": SPIKE}, "'a' never changes when a cell fires: no equat"),
    "short": ({"refractory": "2 usecond"}, "period is 0.002 ms, shorter than the time step of 0.1 ms"),
    "ohms": (with_parameter(R="20 ohm"), "R is 2e-05 Mohm; is it in another unit"),
    "reset adds": ({"reset": "v += v_rest"}, "the reset takes v 55 mV beyond where it begins"),
    "to threshold": ({"reset": "v = v_thresh"}, "the reset takes v to its threshold, 'v > v_thresh'"),
    "beyond threshold": ({"reset": "v += 5*mV"}, "the reset takes v beyond its threshold, 'v > v_thresh'"),
    "no synapse": ({"receptors": {"excitatory": "v += weight"}}, "'ge' stays at 0: no spike or input"),
    "equality": ({"threshold": "v == v_thresh"}, "'v == v_thresh', which a value that changes"),
    "flag": (
        {"threshold": "v > v_thresh and n == 0", "equations": FLAG, "reset": "v = v_rest; n += 1"}, None
    ),
    "turned round": ({"equations": ADAPTING, "threshold": "theta < v", "reset": "v = v_rest; theta += d",
                      "initial": {"v": "-65 mV", "theta": "-50 mV"}, **with_parameter(d="-0.05 mV")}, None),
    "a step": (with_parameter(tau_refrac="0.1 ms"), None),
    "added rest": ({"equations": MEMBRANE.replace("v_rest - v", "-v_rest - v")}, "v is drawn to 65 mV, the"),
    "subtracted": (
        {"equations": MEMBRANE.replace("v_rest - v", "0*v_rest - v - a"), **with_parameter(a="65 mV")}, None
    ),
    "product": ({"equations": MEMBRANE.replace("v_rest - v", "(v - v_rest)*(v - v_thresh)/(9*mV)")}, None),
}  # fmt: skip


@pytest.mark.parametrize("name", DOUBTS)
def test_equations_that_are_probably_not_meant_are_reported(name: str) -> None:
    changed, words = DOUBTS[name]
    sim = builder()
    sim.setup(timestep=0.1)
    sim.Population(2, cell(sim, **changed)(), label="cells")
    found = [one for one in implausible(sim.network()) if words is None or words in one.replace("1*v", "1.v")]
    assert bool(found) == (words is not None)
    assert all(one.startswith("the equations of the population 'cells': ") for one in found)


CONDUCTANCE = """
dv/dt = (v_rest - v)/tau + (ge*(e_exc - v) + gi*(e_inh - v))/(1*nF) : mV
dge/dt = -ge/tau_syn : uS
dx/dt = -x/tau_syn : uS
dgi/dt = (x - gi)/tau_syn : uS
"""
REVERSED = {
    "conductances": ({}, 0.01, None),
    "between rest and threshold": ({"e_inh": "-55 mV"}, 0.01, None),
    "inhibitory reversal": (
        {"e_inh": "80 mV"},
        0.01,
        "inhibitory spikes take v above its threshold: is a si",
    ),
    "excitatory reversal": ({"e_exc": "-80 mV"}, 0.01, "excitatory spikes take v away from its threshold"),
}


@pytest.mark.parametrize("name", REVERSED)
def test_synapses_against_the_name_of_their_receptor_are_reported(name: str) -> None:
    changed, weight, words = REVERSED[name]
    values = {"v_rest": "-65 mV", "tau": "20 ms", "tau_syn": "5 ms", "e_exc": "0 mV", "e_inh": "-80 mV"}
    receptors = {"excitatory": "ge", "inhibitory": "x"}
    texts = {
        "equations": CONDUCTANCE,
        "threshold": "v > -50*mV",
        "refractory": "2 ms",
        "receptors": receptors,
    }
    weights = {"excitatory": weight, "inhibitory": weight}
    found = doubts_of_pair({**texts, "parameters": values | changed}, weights)
    assert [words in one for one in found] == ([True] if words else [])


@pytest.mark.parametrize(
    ("sign", "weight", "words"),
    [("-", 0.1, None), ("+", -0.1, None), ("+", 0.1, "above its thr"), ("-", -0.1, "above its threshold")],
)
def test_currents_inhibit_by_the_equation_or_by_the_weight(sign: str, weight: float, words: str) -> None:
    equations = MEMBRANE.replace("(ge", f"(ge {sign} gi") + "dgi/dt = -gi/tau_syn : nA\n"
    receptors = {"excitatory": "ge", "inhibitory": "gi"}
    found = doubts_of_pair(
        {"equations": equations, "receptors": receptors}, {"excitatory": 0.1, "inhibitory": weight}
    )
    assert [words in one for one in found] == ([True] if words else [])


@pytest.mark.parametrize(("effect", "is_reported"), [("ge -= weight", False), ("ge += weight", True)])
def test_spikes_inhibit_by_what_they_subtract(effect: str, *, is_reported: bool) -> None:
    changed = {"receptors": {"excitatory": "ge += weight", "inhibitory": effect}}
    found = doubts_of_pair(changed, {"excitatory": 0.1, "inhibitory": 0.1})
    assert ["inhibitory spikes take v above" in one for one in found] == [True] * is_reported


EXPONENTIAL = """
dv/dt = (v_rest - v + delta*exp((v - v_t)/delta))/tau + (ge*(e_exc - v) + gi*(e_inh - v))/cm : mV
dge/dt = -ge/tau_syn : nS
dgi/dt = -gi/tau_syn : nS
"""


@pytest.mark.parametrize(
    ("e_inh", "peak", "is_reported"),
    [
        ("-80 mV", "0 mV", False), ("-60 mV", "0 mV", False), ("-60 mV", "20 mV", False),
        ("0 mV", "0 mV", True), ("10 mV", "0 mV", True), ("10 mV", "20 mV", True),
    ],
)  # fmt: skip
def test_inhibition_is_judged_before_the_upstroke_of_a_spike(
    e_inh: str, peak: str, *, is_reported: bool
) -> None:
    values = {"v_rest": "-70 mV", "delta": "2 mV", "v_t": "-50 mV", "tau": "9 ms", "cm": "0.28 nF"}
    reversals = {"e_exc": "30 mV", "e_inh": e_inh, "tau_syn": "5 ms", "peak": peak}
    changed = {
        "equations": EXPONENTIAL, "threshold": "v > peak", "reset": "v = v_rest", "refractory": "2 ms",
        "parameters": values | reversals, "initial": {"v": "-70 mV"},
        "receptors": {"excitatory": "ge", "inhibitory": "gi"},
    }  # fmt: skip
    found = doubts_of_pair(changed, {"excitatory": 5.0, "inhibitory": 5.0})
    assert ["inhibitory spikes take v above" in one for one in found] == [True] * is_reported


def doubts_of_pair(changed: dict[str, Any], weights: dict[str, float]) -> list[str]:
    """Return the doubts about a source that is connected to the receptors of a cell with these weights."""
    sim = builder()
    source, cells = sim.Population(1, sim.SpikeSourcePoisson()), sim.Population(1, cell(sim, **changed))
    for receptor, weight in weights.items():
        sim.Projection(
            source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight), receptor_type=receptor
        )
    return [one for one in implausible(sim.network()) if "equations" in one]


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (with_parameter(tau="0 ms"), "population 'cells': dv/dt of cell 0 is not finite at time 0 .tau = 0"),
        ({"threshold": "v > -100*mV", "reset": "v = v_rest; ge += 0.1*nA"}, "so it would fire without end"),
    ],
)
def test_cells_that_cannot_run_are_refused(changed: dict[str, Any], words: str) -> None:
    sim = builder()

    def build() -> None:
        sim.Population(2, cell(sim, **changed)(), label="cells")
        sim.network()

    with pytest.raises(NetworkError, match=words):
        build()


def test_a_script_sees_a_cell_type_with_units() -> None:
    kind = cell()
    assert kind.default_parameters["tau_syn"] == 5.0
    assert kind.default_initial_values == {"v": pytest.approx(-60.0), "ge": 0.0}
    assert (kind.units["R"], kind.units["v"]) == ("Mohm", "mV")
    assert kind.recordable == ["spikes", "v", "ge"]
    assert kind.receptor_types == ("excitatory",)
    assert not kind.conductance_based
    with pytest.raises(NetworkError, match="no parameter 'taum'; did you mean 'tau'"):
        kind(taum=3.0)


def test_names_have_the_meaning_of_the_equations_and_not_of_pynn() -> None:
    sim = builder()
    own = cell(
        sim, equations=with_line("dn/dt = -n/tau : 1"), parameters={**TEXTS["parameters"], "rate": "-3"}
    )
    cells = sim.Population(2, own(tau=[10.0, 20.0]), initial_values={"n": 7.0}, label="cells")
    assert sim.network().populations["cells"].initial_values["n"].tolist() == [7.0, 7.0]
    with pytest.raises(NetworkError, match="refractory period of cell 1, 'tau_refrac', is -1 ms"):
        cells.set(tau_refrac=[1.0, -1.0])


def test_a_projection_needs_a_receptor_of_the_equations() -> None:
    sim = builder()
    cells, source = sim.Population(1, cell(sim), label="cells"), sim.Population(1, sim.SpikeSourceArray())
    with pytest.raises(NetworkError, match="have no receptor 'inhibitory'"):
        sim.Projection(source, cells, sim.AllToAllConnector(), receptor_type="inhibitory")
    sim.Projection(source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=-1.0))


def test_a_file_keeps_the_equations_and_the_digest_depends_on_them(tmp_path: Path) -> None:
    networks = []
    for reset in ("v = v_rest", "v -= 10*mV"):
        sim = builder()
        sim.Population(3, cell(sim, reset=reset), label="cells")
        networks.append(sim.network())
    assert networks[0].digest != networks[1].digest
    save_network(networks[1], tmp_path / "net.nrpnet")
    read = read_network(tmp_path / "net.nrpnet")
    assert read.digest == networks[1].digest
    assert read.populations["cells"].equations == networks[1].populations["cells"].equations


def test_an_injected_current_is_in_the_unit_of_the_parameter() -> None:
    sim = builder()
    kind = cell(sim, **with_parameter(i_offset="100 pA"))
    cells = sim.Population(1, kind, label="cells")
    sim.DCSource(amplitude=0.5).inject_into(cells)
    assert sim.network().populations["cells"].parameters["i_offset"][0] == pytest.approx(600.0)


@given(st.sampled_from(sorted(units())), st.sampled_from(sorted(units())))
def test_a_dimension_is_described_by_a_unit_that_has_it(first: str, second: str) -> None:
    of = times(units()[first].dimension, units()[second].dimension, -1)
    text = described(of)
    assert " " in text or "^" in text or unit_of(text).dimension == of


@given(st.floats(-1e6, 1e6), st.sampled_from(["mV", "1/ms", "uF/cm**2"]))
def test_a_quantity_is_read_as_it_is_written(number: float, unit: str) -> None:
    for text in (f"{number!r} {unit}", f"{number!r}*{unit}"):
        assert quantity(text) == (number, unit_of(unit))
    assert quantity("3.5")[1].dimension == NONE
    assert unit_of("\u00b5s") == unit_of("\u03bcs") == unit_of("us")


@given(st.lists(st.sampled_from(["v", "u", "a", "2.5", "-v", "(u - a)"]), min_size=1, max_size=5), st.data())
def test_coefficients_of_a_linear_expression_give_its_value(terms: list[str], data: st.DataObject) -> None:
    node = ast.parse(" + ".join(f"a*{term}/b" for term in terms), mode="eval").body
    coefficients = coefficients_of(node, {"v", "u"}, {})
    values = {name: data.draw(st.floats(0.5, 2.0)) for name in ("v", "u", "a", "b")}
    expected = eval(ast.unparse(node), {}, values)
    has_square = any(term == "a" for term in terms)
    assert coefficients is not None or has_square
    found = sum(
        eval(ast.unparse(part), {}, values) * values.get(name, 1.0) for name, part in coefficients.items()
    )
    assert np.isclose(found, expected)
    assert coefficients_of(ast.parse("v*u", mode="eval").body, {"v", "u"}, {}) is None


def test_the_linear_part_of_equations_stands_alone() -> None:
    """A voltage is not linear, nor is what depends on it, on the time, or is held by a refractory cell."""
    kind = cell(
        equations="""
        dv/dt = (v_rest - v + R*i_offset + R*b*ge)/tau + k*v**2/mV/tau : mV
        dw/dt = (c*v - w)/tau : mV
        ds/dt = -s*(t/tau_refrac)/tau_syn : 1
        dh/dt = -h/tau_syn : 1 (unless refractory)
        dge/dt = (b*x - ge)/tau_syn : nA
        dx/dt = (i_offset - x)/tau_syn : nA
        """,
        parameters={**TEXTS["parameters"], "k": "0.1", "c": "0.5", "b": "2"},
    )
    part = linear_part(kind().equations.model)
    assert list(part.variables) == ["ge", "x"]
    assert list(linear_part(cell()().equations.model).variables) == ["ge"]
