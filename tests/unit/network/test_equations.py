"""Cells given as equations: units, mistakes with their line, what scripts and files keep."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core import read_network, save_network
from nrp_core.brain import builder
from nrp_core.errors import NetworkError
from nrp_core.network.equations.linear import coefficients_of, linear_part
from nrp_core.units import NONE, as_unit, quantity, times, unit_of, units

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


@pytest.mark.parametrize(
    "changed",
    [
        with_parameter(tau="0 ms"),
        {"threshold": "v > -100*mV", "reset": "v = v_rest; ge += 0.1*nA"},
    ],
)
def test_cells_that_cannot_run_are_refused(changed: dict[str, Any], golden: Golden) -> None:
    sim = builder()

    def build() -> None:
        sim.Population(2, cell(sim, **changed)(), label="cells")
        sim.network()

    with golden.raises(NetworkError):
        build()


def test_a_script_sees_a_cell_type_with_units(golden: Golden) -> None:
    kind = cell()
    assert kind.default_parameters["tau_syn"] == 5.0
    assert kind.default_initial_values == {"v": pytest.approx(-60.0), "ge": 0.0}
    assert (kind.units["R"], kind.units["v"]) == ("Mohm", "mV")
    assert kind.recordable == ["spikes", "v", "ge"]
    assert kind.receptor_types == ("excitatory",)
    assert not kind.conductance_based
    with golden.raises(NetworkError, match="'taum'.*'tau'"):
        kind(taum=3.0)


def test_names_have_the_meaning_of_the_equations_and_not_of_pynn(golden: Golden) -> None:
    sim = builder()
    own = cell(
        sim, equations=with_line("dn/dt = -n/tau : 1"), parameters={**TEXTS["parameters"], "rate": "-3"}
    )
    cells = sim.Population(2, own(tau=[10.0, 20.0]), initial_values={"n": 7.0}, label="cells")
    assert sim.network().populations["cells"].initial_values["n"].tolist() == [7.0, 7.0]
    with golden.raises(NetworkError, match="1, 'tau_refrac'.*-1"):
        cells.set(tau_refrac=[1.0, -1.0])


def test_a_projection_needs_a_receptor_of_the_equations(golden: Golden) -> None:
    sim = builder()
    cells, source = sim.Population(1, cell(sim), label="cells"), sim.Population(1, sim.SpikeSourceArray())
    with golden.raises(NetworkError, match="'inhibitory'"):
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
    text = as_unit(of)
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
