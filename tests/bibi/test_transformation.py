"""The Python that models stand for: the listings, every construct, and what it means."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import reduce
from math import isclose, isnan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import nrp_experiments.braitenberg_husky as experiment
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from nrp_bibi import Bibi, generate, parse_bibi, read_bibi
from nrp_bibi.generation.expressions import as_python, literal
from nrp_bibi.generation.selectors import selection
from nrp_bibi.model.channels import Local
from nrp_bibi.model.expressions import (
    Add,
    Argument,
    ArgumentReference,
    Call,
    Constant,
    ConstantString,
    Divide,
    FlowExpression,
    Max,
    Min,
    Multiply,
    Operator,
    Scale,
    SimulationStep,
    Subtract,
)  # fmt: skip
from nrp_bibi.model.functions import Robot2Neuron
from nrp_bibi.model.selectors import (
    Box,
    ChainSelector,
    Index,
    IndexTemplate,
    List,
    ListTemplate,
    MapSelector,
    Nearest,
    Population,
    Range,
    RangeTemplate,
    Sphere,
)  # fmt: skip

from nrp_core.errors import ExperimentError

FOLDER = Path(experiment.__file__).parent
PATH = Path("model.bibi")
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'

Expressions = Callable[..., SearchStrategy[FlowExpression]]
NAMES = {"a": 0.5, "b": -2.0, "t": 0.02, "device": SimpleNamespace(voltage=3.25)}
REFERENCES: list[FlowExpression] = [
    ArgumentReference(name="a"), ArgumentReference(name="b"), SimulationStep(),
    ArgumentReference(name="device", property="voltage"),
]  # fmt: skip


def value_of(expression: FlowExpression) -> float:
    """Evaluate a model, without Python."""
    match expression:
        case Constant(value=value):
            return value
        case SimulationStep():
            return NAMES["t"]  # type: ignore[return-value]
        case ArgumentReference(name=name, property=path):
            return NAMES[name] if path is None else getattr(NAMES[name], path)  # type: ignore[return-value]
        case Scale(factor=factor, inner=inner):
            return factor * value_of(inner)
        case Call(argument=(argument,)):
            return abs(value_of(argument.value))
        case Operator(operand=operands):
            return reduce(_OPERATIONS[type(expression)], map(value_of, operands))
    raise AssertionError(expression)


_OPERATIONS: dict[type[Operator], Any] = {
    Add: lambda x, y: x + y, Subtract: lambda x, y: x - y, Multiply: lambda x, y: x * y,
    Divide: lambda x, y: x / y, Min: min, Max: max,
}  # fmt: skip


def outcome(evaluate: Any) -> float | str:
    try:
        return float(evaluate())
    except (ZeroDivisionError, OverflowError) as error:
        return type(error).__name__


def tree(code: str) -> str:
    return ast.dump(ast.parse(code))


def from_xml(inner: str) -> str:
    return generate(parse_bibi(f"<bibi {XSI}>{inner}</bibi>", PATH), PATH, with_imports=False)


def test_a_model_of_listing_1_generates_listing_1() -> None:
    path = FOLDER / "listing1.bibi"
    assert tree(generate(read_bibi(path), path)) == tree((FOLDER / "listing1.py").read_text())


def test_a_model_of_listing_2_generates_listing_2() -> None:
    path = FOLDER / "listing2.bibi"
    generated = generate(read_bibi(path), path, with_imports=False)
    assert tree(generated) == tree((FOLDER / "listing2.py").read_text())


@given(data=st.data())
@settings(deadline=None, max_examples=100)
def test_generated_python_evaluates_to_what_the_model_does(
    expressions: Expressions, data: st.DataObject
) -> None:
    expression = data.draw(expressions(st.sampled_from(REFERENCES)))
    code = ast.unparse(as_python(expression))
    python, model = outcome(lambda: eval(code, {}, dict(NAMES))), outcome(lambda: value_of(expression))
    assert python == model or (isinstance(model, float) and isnan(model))


@given(st.text())
def test_strings_are_quoted_so_that_python_reads_them(text: str) -> None:
    assert ast.literal_eval(literal(text)) == text


@pytest.mark.parametrize(
    ("selector", "python"),
    [
        (Index(population="p", index=3), "nrp.brain.p[3]"),
        (Range(population="p", from_=0, to=3), "nrp.brain.p[0:3]"),
        (Range(population="p", from_=0, to=3, step=2), "nrp.brain.p[0:3:2]"),
        (List(population="p", element=(0, 2)), "nrp.brain.p[0, 2]"),
        (List(population="p", element=(4,)), "nrp.brain.p[[4]]"),
        (Population(population="p"), "nrp.brain.p"),
        (
            Box(population="p", low=(0, -5), high=(100, 50.5)),
            "nrp.brain.p.within(nrp.Box((0, -5), (100, 50.5)))",
        ),
        (
            Sphere(population="p", center=(0, 0, 10), radius=50),
            "nrp.brain.p.within(nrp.Sphere((0, 0, 10), 50))",
        ),
        (Nearest(population="p", center=(1, 2)), "nrp.brain.p.nearest((1, 2))"),
        (Nearest(population="p", center=(1, 2), count=3), "nrp.brain.p.nearest((1, 2), 3)"),
        (
            MapSelector(count=600, pattern=IndexTemplate(population="p", index="i")),
            "nrp.map_neurons(range(600), lambda i: nrp.brain.p[i])",
        ),
        (
            MapSelector(
                source=Range(from_=0, to=9, step=3),
                pattern=RangeTemplate(population="p", from_="2 * i", to="2 * i + 2"),
            ),
            "nrp.map_neurons(range(0, 9, 3), lambda i: nrp.brain.p[2 * i:2 * i + 2])",
        ),
        (
            MapSelector(
                source=List(element=(1, 5)), pattern=ListTemplate(population="p", element=("i", "7"))
            ),
            "nrp.map_neurons([1, 5], lambda i: nrp.brain.p[i, 7])",
        ),
        (
            MapSelector(source=Population(population="q"), pattern=IndexTemplate(population="p", index="i")),
            "nrp.map_neurons(nrp.brain.q.size, lambda i: nrp.brain.p[i])",
        ),
        (
            ChainSelector(neurons=(Population(population="p"), Index(population="q", index=0))),
            "nrp.chain_neurons(nrp.brain.p, nrp.brain.q[0])",
        ),
    ],
)
def test_selectors(selector: Any, python: str) -> None:
    assert selection(selector) == python


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("ACSource", "amplitude"), ("DCSource", "amplitude"), ("FixedFrequency", "rate"),
        ("LeakyIntegratorAlpha", "voltage"), ("LeakyIntegratorExp", "voltage"), ("NCSource", "mean"),
        ("Poisson", "rate"), ("SpikeRecorder", "times"), ("PopulationRate", "rate"),
    ],
)  # fmt: skip
def test_a_body_is_written_to_the_default_property_of_its_device(kind: str, name: str) -> None:
    assert f"    d.{name} = 2\n" in from_xml(
        f'<transferFunction xsi:type="Robot2Neuron" name="f"><device name="d" type="{kind}"><neurons '
        'population="p" index="0"/><body xsi:type="Constant" value="2"/></device></transferFunction>'
    )


@pytest.mark.parametrize(
    ("inside", "keywords"),
    [
        ('<connector xsi:type="OneToOneConnector" weights="0.5" delays="1.0"/>', "weight=0.5, delay=1.0"),
        ('<connector xsi:type="AllToAllConnector" weights="-2"/>', "weight=-2"),
        ('<connectorRef ref="shared"/>', 'connector={"mode": "Fixed", "n": 3}, delay=1.5'),
        ("<target>Inhibitory</target>", 'receptor_type="inhibitory"'),
        (
            '<synapseDynamicsRef ref="tm"/>',
            'synapse_type={"type": "TsodyksMarkram", "U": 1.0, "tau_rec": 2, "tau_facil": 3}',
        ),
    ],
)
def test_connectors_and_synapses_are_keyword_arguments_of_the_device(inside: str, keywords: str) -> None:
    code = from_xml(
        '<connectors xsi:type="FixedNumberPreConnector" name="shared" count="3" delays="1.5"/>'
        '<synapseDynamics xsi:type="TsodyksMarkramMechanism" name="tm" u="1.0" tau_rec="2" tau_facil="3"/>'
        '<transferFunction xsi:type="Neuron2Robot" name="f"><device name="d" type="PopulationRate">'
        f'<neurons population="p"/>{inside}</device></transferFunction>'
    )
    assert keywords in " ".join(code.split())


def test_every_kind_of_channel_in_the_order_of_the_language() -> None:
    code = from_xml(
        '<transferFunction xsi:type="Neuron2Robot" name="f" priority="2" active="false" calls="Each">'
        "<trigger>hears</trigger>"
        '<deviceGroup name="eyes" type="Poisson"><neurons xsi:type="MapSelector" count="3">'
        '<pattern population="p" index="2*i"/></neurons><body xsi:type="SimulationStep"/></deviceGroup>'
        '<device name="d" type="PopulationRate"><neurons population="p"/></device>'
        '<topic name="says" topic="/says" type="std_msgs.msg.String"><body xsi:type="Call" '
        'type="std_msgs.msg.String"><argument><value xsi:type="ConstantString" value="hi"/></argument></body>'
        '</topic><topic name="hears" topic="/hears" type="std_msgs.msg.Float64"/>'
        '<returnValue topic="/out" type="std_msgs.msg.Float64"><body xsi:type="Call" '
        'type="std_msgs.msg.Float64"><argument><value xsi:type="ArgumentReference" name="d" property="rate"/>'
        "</argument></body></returnValue></transferFunction>"
    )
    assert (
        code
        == """\
# f: model.bibi:1
@nrp.MapRobotPublisher("says", Topic("/says", std_msgs.msg.String))
@nrp.MapRobotSubscriber("hears", Topic("/hears", std_msgs.msg.Float64))
@nrp.MapSpikeSink("d", nrp.brain.p, nrp.population_rate)
@nrp.MapSpikeSource("eyes", nrp.map_neurons(range(3), lambda i: nrp.brain.p[2 * i]), nrp.poisson)
@nrp.Neuron2Robot(Topic("/out", std_msgs.msg.Float64), triggers=["hears"], priority=2, calls="each")
def f(t, says, hears, d, eyes):
    eyes.rate = t
    says.send_message(std_msgs.msg.String('hi'))
    return std_msgs.msg.Float64(d.rate)


f.active = False
"""
    )


def test_a_monitor_shows_its_device() -> None:
    assert from_xml(
        '<transferFunction xsi:type="Neuron2Monitor" name="m"><device name="d" type="SpikeRecorder">'
        '<neurons population="p" from="0" to="4"/></device></transferFunction>'
    ) == (
        "# m: model.bibi:1\n"
        "@nrp.NeuronMonitor(nrp.brain.p[0:4], nrp.spike_recorder)\n"
        "def m(t):\n"
        "    return True\n"
    )


def test_imports_follow_from_the_types_used_and_the_framework_s_old_names_are_its_own() -> None:
    inner = Call(type="hbp_nrp_cle.tf_framework.tf_lib.detect_red", argument=())
    outer = Call(type="math.sqrt", argument=(Argument(value=inner),))
    model = Bibi(transfer_function=(Robot2Neuron(name="f", local=(Local(name="x", body=outer),)),))
    assert generate(model, PATH) == (
        "import hbp_nrp_client.tf_framework as nrp\nimport math\n\n\n"
        "# f: model.bibi\n@nrp.Robot2Neuron()\ndef f(t):\n    x = math.sqrt(nrp.tf_lib.detect_red())\n"
    )


def test_a_text_is_a_constant_too() -> None:
    assert ast.unparse(as_python(ConstantString(value='say "hi"'))) == "'say \"hi\"'"


def test_nothing_is_lost_to_missing_brackets() -> None:
    a, b = ArgumentReference(name="a"), ArgumentReference(name="b")
    divided = Divide(operand=(Constant(value=1), Multiply(operand=(a, b))))
    assert ast.unparse(as_python(divided)) == "1 / (a * b)"
    assert isclose(value_of(divided), -1.0)


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        (
            '<trigger>camra</trigger><topic name="camera" topic="/camera" type="sensor_msgs.msg.Image"/>',
            "by 'camra': it reads no topic or spike recorder of this name; did you mean 'camera'?",
        ),
        (
            '<trigger>told</trigger><topic name="told" topic="/told" type="std_msgs.msg.Float64">'
            '<body xsi:type="SimulationStep"/></topic>',
            "by 'told': it reads no topic or spike recorder of this name; there are none",
        ),
        ("<trigger>t</trigger>", "by 't': it reads no topic or spike recorder of this name"),
    ],
)
def test_only_a_topic_that_a_function_reads_can_trigger_it(inner: str, message: str) -> None:
    with pytest.raises(ExperimentError) as refused:
        from_xml(f'<transferFunction xsi:type="Neuron2Robot" name="f">{inner}</transferFunction>')
    assert str(refused.value).startswith("model.bibi:1: 'f' cannot be triggered ")
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ('<local name="x"><body xsi:type="ArgumentReference" name="deviec"/></local>', "mean 'device'?"),
        ('<local name="device"><body xsi:type="SimulationStep"/></local>', "'device' is used twice"),
        ('<local name="lambda"><body xsi:type="SimulationStep"/></local>', "'lambda': it is reserved"),
        ('<local name="t"><body xsi:type="SimulationStep"/></local>', "the name 't': it is reserved"),
        (
            '<local name="math"><body xsi:type="Call" type="math.sqrt"><argument><value '
            'xsi:type="Constant" value="4"/></argument></body></local>',
            "the name 'math' hides the Python name that line 2 uses",
        ),
        (
            '<local name="min"><body xsi:type="SimulationStep"/></local><local name="x"><body xsi:type="Min">'
            '<operand xsi:type="SimulationStep"/><operand xsi:type="SimulationStep"/></body></local>',
            "the name 'min' hides the Python name",
        ),
        ('<topic topic="/x" type="a.b"/>', "a channel needs a name"),
        ('<topic name="x" topic="/x" type="a.lambda"/>', "'type' of <topic> cannot be 'a.lambda'"),
        ('<device name="d" type="Poisson"><neurons population="if"/></device>', "population name 'if'"),
        (
            '<local name="x"><body xsi:type="Call" type="f"><argument name="if"><value '
            'xsi:type="SimulationStep"/></argument></body></local>', "the argument 'if'",
        ),
        ('<device name="d" type="Poisson"><neurons population="a b"/></device>', "population name 'a b'"),
        ('<device name="d" type="Poisson"><neurons index="0"/></device>', 'needs population="..."'),
        ('<device name="d" type="Poisson"><neurons population="p"/><connectorRef ref="x"/></device>', "'x'"),
        (
            '<deviceGroup name="g" type="Poisson"><neurons xsi:type="MapSelector"><pattern population="p" '
            'index="i"/></neurons></deviceGroup>', "either a count or a source",
        ),
        (
            '<local name="x"><body xsi:type="Call" type="f"><argument name="a"><value '
            'xsi:type="SimulationStep"/></argument><argument><value xsi:type="SimulationStep"/></argument>'
            "</body></local>", "arguments without a name must come before",
        ),
    ],
)  # fmt: skip
def test_a_model_without_one_meaning_is_refused_with_its_line(inner: str, message: str) -> None:
    device = '<device name="device" type="Poisson"><neurons population="p"/></device>'
    with pytest.raises(ExperimentError) as refused:
        from_xml(f'<transferFunction xsi:type="Neuron2Robot" name="f">{device}\n{inner}</transferFunction>')
    assert message in str(refused.value)
    assert str(refused.value).startswith("model.bibi:2: ")


def test_a_function_does_not_hide_names_that_another_one_calls(golden: Golden) -> None:
    call = '<local name="x"><body xsi:type="Call" type="NAME"/></local>'
    plain = '<transferFunction xsi:type="Neuron2Robot" name="math"/>\n'
    other = f'<transferFunction xsi:type="Robot2Neuron" name="g">{call}</transferFunction>'
    with golden.raises(ExperimentError, match="model.bibi:1.*'math'"):
        from_xml(plain + other.replace("NAME", "math.sqrt"))
    from_xml(plain + other.replace("NAME", "maths.sqrt"))


def test_a_call_through_a_channel_is_a_method_of_it() -> None:
    python = from_xml(
        '<transferFunction xsi:type="Neuron2Robot" name="f"><local name="x"><body xsi:type="Call" '
        'type="state.value.level"/></local><topic name="state" topic="/x" type="own.msg.State"/>'
        "</transferFunction>"
    )
    assert "x = state.value.level()" in python


def test_a_python_transfer_function_has_a_file_or_code(golden: Golden) -> None:
    with golden.raises(ExperimentError):
        from_xml('<transferFunction xsi:type="PythonTransferFunction"/>')
