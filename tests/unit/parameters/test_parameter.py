"""Parameters: their values, units and ranges, and how declarations are read."""

import ast
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.parameters import BRAIN, FUNCTIONS, GivenParameters, Parameter, read_parameters
from nrp_core.units import factor


@pytest.mark.parametrize(
    ("default", "unit", "given", "value"),
    [
        (1.0, "mV", "1.5 mV", 1.5),
        (1.0, "mV", "0.0015 V", 1.5),
        (1.0, "mV", "1500 uV", 1.5),
        (1.0, "mV", "1500 µV", 1.5),
        (1.0, "mV", 2, 2.0),
        (1.0, "mV", "2", 2.0),
        (1.0, "Hz/mV", "2 kHz/V", 2.0),
        (1.0, "m/s", "36 km/h", 10.0),
        (1.0, "m/s^2", "981 cm/s^2", 9.81),
        (1.0, "ms", "1 min", 60_000.0),
        (0.5, "rad", "180 deg", 3.141592653589793),
        (1.0, "spikes", "3 spikes", 3.0),
        (8, None, 9, 9),
        (8, "ms", "0.002 s", 2),
        (True, None, False, False),
        ("left", None, "right", "right"),
        ([1.0, 2.0], "mV", ["1 V", 2], [1000.0, 2.0]),
        ([1, 2], None, [3], [3]),
    ],
)
def test_a_value_is_converted_to_the_declared_type_and_unit(default, unit, given, value):
    found = Parameter("p", default, unit).value(given)
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("parameter", "given", "message"),
    [
        (Parameter("p", 1.0, "mV"), "1 mA", "'mA' cannot be converted to 'mV'"),
        (Parameter("p", 1.0, "mV"), "1 mVolt", "'mVolt' is not a unit that can be converted"),
        (Parameter("p", 1.0), "1 mV", "p is '1 mV'; it has no unit"),
        (Parameter("p", 1.0, "mV", 0, 5), 5.5, "p is 5.5; it must be 0..5 mV"),
        (Parameter("p", 1.0, "mV", 0, 5), "6000 uV", "it must be 0..5 mV"),
        (Parameter("p", 1.0, None, 0), -1, "it must be 0 or more"),
        (Parameter("p", 1.0), True, "it must be a number"),
        (Parameter("p", 1.0), float("inf"), "it must be a number"),
        (Parameter("p", 1.0), "fast", "it must be a number"),
        (Parameter("p", 8), 8.5, "it must be a whole number"),
        (Parameter("p", True), 1, "it must be true or false"),
        (Parameter("p", "left"), 1, "it must be a text"),
        (Parameter("p", [1.0]), 1.0, "it must be a list of numbers"),
        (Parameter("p", [1.0], None, 0, 1), [0.5, 2], "p is 2; it must be 0..1"),
        (Parameter("p", [1.0]), [True], "it must be a list of numbers"),
    ],
)
def test_a_value_that_does_not_fit_is_refused(parameter, given, message):
    with pytest.raises(ValueError, match=r"p is") as caught:
        parameter.value(given)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("2p", 1.0), "must be an identifier"),
        (("p", None), "its default is None"),
        (("p", {"a": 1}), "its default is {'a': 1}"),
        (("p", 1.0, None, 5, 0), "low, 5, is above high, 0"),
        (("p", 7.0, None, 0, 5), "its default is out of range"),
        (("p", 1.0, "An"), "its unit 'An' is not known; did you mean 'nA'?"),
        (("p", "left", "mV"), "are for numbers"),
        (("p", True, None, 0), "are for numbers"),
        (("p", float("nan")), "must be finite"),
        (("p", ["a"]), "must be finite"),
        (("p", 1.0, None, "0 mV"), "low and high must be finite numbers"),
    ],
)
def test_a_declaration_that_contradicts_itself_is_refused(arguments, message, golden: Golden):
    with golden.raises(ExperimentError, match="'2?p'") as caught:
        Parameter(*arguments)
    assert message in str(caught.value)


def test_units_of_different_dimension_are_not_converted(golden: Golden):
    with golden.raises(ValueError):
        factor("Hz/mV", "Hz*mV")
    assert factor("S", "uS") == 10**6
    assert factor("nA", "pA") == 1000


@pytest.mark.parametrize("unit", ["N m", "N*m", "Nm", "N\u00b7m", "J", "kg m^2/s^2"])
def test_products_of_units_have_a_space_a_dot_or_a_star(unit, golden: Golden):
    assert Parameter("p", 1.0, unit).value("500 mN m") == 0.5
    with golden.raises(ValueError):
        factor(f"{unit}/kg K", "J/kg/K")  # ambiguous


def declared(tmp_path: Path, text: str, dialect=BRAIN):
    file = tmp_path / "script.py"
    file.write_text(text)
    return read_parameters(file, dialect)


@pytest.mark.parametrize(
    "text",
    [
        "import nrp_core.pynn as sim\nsim.parameter('g', 1.0)",
        "import nrp_core.pynn\nnrp_core.pynn.parameter('g', 1.0)",
        "from nrp_core import pynn as p\np.parameter('g', 1.0)",
        "from nrp_core.pynn import parameter as par\npar('g', default=1.0)",
        "import pyNN.nest as p\nx = 2 * p.parameter('g', 1.0)",
        "from pyNN.utility import get_simulator\np, options = get_simulator()\np.parameter('g', 1.0)",
        "def build(sim):\n    return sim.parameter('g', 1.0)",
    ],
)
def test_parameters_are_found_however_the_simulator_is_imported(tmp_path, text):
    found = declared(tmp_path, text)
    assert (list(found.parameters), found.mistakes) == (["g"], [])
    assert found.parameters["g"].line == text.count("\n") + 1


def test_a_method_of_the_same_name_of_something_else_is_not_a_parameter(tmp_path):
    found = declared(tmp_path, "import model\nm = model.Model()\nm.parameter(x, y)\n")
    assert (found.parameters, found.mistakes) == ({}, [])


def test_parameters_of_modules_beside_a_script_are_its_own(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "eyes.py").write_text("import nrp_core.pynn as sim\nsim.parameter('eyes', 2)\n")
    (tmp_path / "wheels.py").write_text("import parts.eyes, wheels\ndef f(sim):\n    sim.parameter('w', 1)\n")
    assert list(declared(tmp_path, "from wheels import f\n").parameters) == ["w", "eyes"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("sim.parameter('g', N)", "the default of a parameter must be a literal, not 'N'"),
        ("sim.parameter(f'g{1}', 1.0)", "the name of a parameter must be a literal"),
        ("sim.parameter('g', 1.0, unit=U)", "the unit of a parameter must be a literal"),
        ("sim.parameter('g', 1.0, 'mV')", "takes name, default, and by name unit, low, high, doc"),
        ("sim.parameter('g', 1.0, minimum=0)", "not 'minimum'"),
        ("sim.parameter('g', **options)", "not '**'"),
        ("sim.parameter('g')", "needs default"),
        ("sim.parameter('g', 1.0, doc=3)", "the doc of a parameter must be a text"),
        ("sim.parameter('g', 1.0, low=2)", "its default is out of range"),
    ],
)
def test_a_declaration_that_cannot_be_read_is_a_mistake_with_its_line(tmp_path, call, message):
    found = declared(tmp_path, f"import nrp_core.pynn as sim\n{call}\n")
    (mistake,) = found.mistakes
    assert message in str(mistake)
    assert (mistake.path, mistake.line) == (tmp_path / "script.py", 2)


def test_two_declarations_of_one_name_must_be_equal(tmp_path, golden: Golden):
    same = "sim.parameter('g', 1.0, low=0)\n"
    assert not declared(tmp_path, same + same).mistakes
    (mistake,) = declared(tmp_path, same + "sim.parameter('g', 2.0)\n").mistakes
    assert "script.py:1" in mistake.message
    golden(mistake.message)
    sim = GivenParameters()
    sim.parameter("g", 1.0)
    with golden.raises(ExperimentError):
        sim.parameter("g", 2.0)


def test_the_declaration_read_from_the_code_is_the_one_that_runs(tmp_path):
    """The declaration that is read from a call equals the one that the call makes."""
    call = "sim.parameter('gain', -1.5, unit='mV', low=-2, high=5, doc='how ' 'much')"
    (read,) = declared(tmp_path, call).parameters.values()
    sim = GivenParameters()
    eval(compile(ast.parse(call, mode="eval"), "call", "eval"), {"sim": sim})
    assert sim._declared == {"gain": read}


def test_functions_declare_theirs_with_nrp(tmp_path):
    assert list(declared(tmp_path, "nrp.parameter('g', 1.0)", FUNCTIONS).parameters) == ["g"]
    assert not declared(tmp_path, "nrp.parameter('g', 1.0)", BRAIN).parameters


@pytest.mark.parametrize(
    ("text", "unused"),
    [
        ("g = sim.parameter('g', 1.0)\n", ["g"]),
        ("sim.parameter('g', 1.0)\n", ["g"]),
        ("g: float = sim.parameter('g', 1.0)\ng = 2\n", ["g"]),
        ("g = sim.parameter('g', 1.0)\nsim.setup(g)\n", []),
        ("g = sim.parameter('g', 1.0)\ng = 2\nsim.setup(g)\n", ["g"]),
        ("g = sim.parameter('g', 1.0)\ng = 2 * g\nsim.setup(g)\n", []),
        ("def f():\n    return g\ng = sim.parameter('g', 1.0)\ng = f()\nsim.setup(g)\n", []),
        ("g = sim.parameter('g', 1.0)\nif len('a'):\n    g = 2\nsim.setup(g)\n", []),
        ("g = sim.parameter('g', 1.0)\ndef f():\n    return g\n", []),
        ("g = sim.parameter('g', 1.0)\nprint(globals()['g'])\n", []),
        ("sim.setup(sim.parameter('g', 1.0))\n", []),
    ],
)
def test_a_parameter_that_no_code_reads_is_unused(tmp_path, text, unused):
    assert [one.name for one in declared(tmp_path, text).unused] == unused


def test_a_parameter_of_a_module_may_be_read_by_the_script(tmp_path):
    (tmp_path / "parts.py").write_text("import nrp_core.pynn as sim\ng = sim.parameter('g', 1)\n")
    assert not declared(tmp_path, "import parts\nprint(parts.g)\n").unused
    assert not declared(tmp_path, "from parts import g as gain\n").unused
    assert [one.name for one in declared(tmp_path, "import parts\n").unused] == ["g"]


@pytest.mark.parametrize("unit", ["Pa", "spikes", "nA", "Hz/mV", "a.u.", "%"])
def test_a_unit_of_ones_own_is_kept(unit):
    assert Parameter("p", 1.0, unit).unit == unit
