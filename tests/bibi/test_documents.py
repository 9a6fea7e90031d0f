"""What is written is read again as the same; what is read need not be written like that."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from lxml import etree
from nrp_bibi import Bibi, bibi_text, parse_bibi, read_bibi
from nrp_bibi.model.channels import DeviceType, Local
from nrp_bibi.model.expressions import ArgumentReference, Call, Constant, ConstantString
from nrp_bibi.model.functions import (
    BodyModel,
    BrainModel,
    Configuration,
    Neuron2Robot,
    PythonTransferFunction,
)
from nrp_bibi.model.selectors import Index, List, Population, Range
from nrp_bibi.model.values import dedented
from nrp_bibi.schema import SCHEMA, schema_text

from nrp_core.errors import ExperimentError

XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
SLOW = settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])


FIRST = """<?xml version="1.0"?>
<!-- the first schema: the brain is a text, files are imports -->
<bibi xmlns="http://schemas.humanbrainproject.eu/SP10/2014/BIBI"
      xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
      xsi:schemaLocation="http://schemas.humanbrainproject.eu/SP10/2014/BIBI ../bibi_configuration.xsd">
  <brainModel>
    brain_model/braitenberg.h5
  </brainModel>
  <bodyModel>husky_model/model.sdf</bodyModel>
  <transferFunctionImport src="grab_image.py"/>
  <transferFunction xsi:type="Neuron2Robot" name="wheels">
    <device name="left" type="LeakyIntegratorAlpha">
      <neurons xsi:type="Index" population="actors" index="0"/>
    </device>
    <topic name="out" topic="/husky/empty" type="std_msgs.msg.Empty">
      <body xsi:type="Call" type="std_msgs.msg.Empty"/>
    </topic>
  </transferFunction>
</bibi>
"""
LAST = """<?xml version="1.0" encoding="utf-8"?>
<ns1:bibi xmlns:ns1="http://schemas.humanbrainproject.eu/SP10/2014/BIBI"
          xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <ns1:transferFunction active="false" priority="3" src="a.py" xsi:type="ns1:PythonTransferFunction"/>
  <ns1:bodyModel robotId="left">model.sdf</ns1:bodyModel>
  <ns1:bodyModel robotId="right" model="husky" isCustom="true">model.sdf</ns1:bodyModel>
  <ns1:configuration type="retina" src="retina.py"/>
  <ns1:mode>SynchronousNestSimulation</ns1:mode>
  <ns1:timestep>20</ns1:timestep>
</ns1:bibi>
"""


def read(inner: str, attributes: str = "") -> Bibi:
    return parse_bibi(f"<bibi {XSI} {attributes}>{inner}</bibi>")


def function(inner: str, kind: str = "Neuron2Robot") -> Neuron2Robot:
    found = read(f'<transferFunction xsi:type="{kind}" name="f">{inner}</transferFunction>')
    return found.transfer_function[0]  # type: ignore[return-value]


def refusal(inner: str) -> str:
    with pytest.raises(ExperimentError) as refused:
        parse_bibi(f"<bibi {XSI}>\n{inner}\n</bibi>", Path("m.bibi"))
    return str(refused.value)


@given(data=st.data())
@SLOW
def test_every_model_is_read_as_it_was_written(documents: SearchStrategy[Bibi], data: st.DataObject) -> None:
    model = data.draw(documents)
    text = bibi_text(model)
    again = parse_bibi(text)
    assert again == model
    assert bibi_text(again) == text


@given(data=st.data())
@SLOW
def test_the_schema_accepts_every_document_that_is_written(
    documents: SearchStrategy[Bibi], data: st.DataObject
) -> None:
    text = bibi_text(data.draw(documents))
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.fromstring(text.encode()))


@pytest.mark.parametrize("text", [FIRST, LAST])
def test_the_schema_accepts_documents_of_old(text: str) -> None:
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.fromstring(text.encode()))


@pytest.mark.parametrize(
    ("given", "broken"),
    [('index="0"', 'index="-1"'), ("LeakyIntegratorAlpha", "Leaky"), ('src="grab', 'scr="grab')],
)
def test_the_schema_refuses_what_the_reader_does(given: str, broken: str) -> None:
    text = FIRST.replace(given, broken)
    assert not etree.XMLSchema(etree.parse(SCHEMA)).validate(etree.fromstring(text.encode()))
    with pytest.raises(ExperimentError):
        parse_bibi(text)


def test_the_shipped_schema_is_that_of_the_metamodel() -> None:
    assert SCHEMA.read_text(encoding="utf-8") == schema_text()


def test_a_body_that_has_two_operands_too_few_is_refused() -> None:
    assert "m.bibi:2: <body> needs at least 2 <operand>" in refusal(
        '<transferFunction xsi:type="Neuron2Robot" name="f"><local name="x"><body xsi:type="Add"/></local>'
        "</transferFunction>"
    )


def test_a_document_of_the_first_schema_is_read() -> None:
    model = parse_bibi(FIRST)
    assert model.brain_model == BrainModel(file="brain_model/braitenberg.h5")
    assert model.body_model == (BodyModel(file="husky_model/model.sdf"),)
    file, block = model.transfer_function
    assert file == PythonTransferFunction(src="grab_image.py")
    assert isinstance(block, Neuron2Robot)
    assert [device.neurons for device in block.device] == [Index(population="actors", index=0)]
    assert block.topic[0].body == Call(type="std_msgs.msg.Empty")


def test_a_document_of_the_last_schema_is_read() -> None:
    model = parse_bibi(LAST)
    assert (model.timestep, model.mode) == (20, "SynchronousNestSimulation")
    assert [body.robot_id for body in model.body_model] == ["left", "right"]
    assert model.body_model[1] == BodyModel(robot_id="right", model="husky", is_custom=True, file="model.sdf")
    assert model.configuration == (Configuration(type="retina", src="retina.py"),)
    last = PythonTransferFunction(src="a.py", active=False, priority=3)
    assert model.transfer_function == (last,)


@pytest.mark.parametrize("year", [2014, 2015])
@pytest.mark.parametrize("prefix", ["", "ns1:"])
def test_prefixes_and_name_spaces_do_not_matter(year: int, prefix: str) -> None:
    space = f"xmlns{':' + prefix[:-1] if prefix else ''}"
    uri = f"http://schemas.humanbrainproject.eu/SP10/{year}/BIBI"
    text = f'<{prefix}bibi {space}="{uri}"><{prefix}timestep>20</{prefix}timestep></{prefix}bibi>'
    assert parse_bibi(text).timestep == 20


def test_a_byte_order_mark_and_windows_line_ends_are_read() -> None:
    assert parse_bibi(b"\xef\xbb\xbf<?xml version='1.0'?>\r\n<bibi>\r\n<mode>M</mode>\r\n</bibi>").mode == "M"


def test_elements_stand_in_any_order() -> None:
    text = (
        '<transferFunction src="a.py"/><bodyModel>b.sdf</bodyModel><brainModel><file>c.py</file></brainModel>'
    )
    model = read(text)
    assert model.body_model == (BodyModel(file="b.sdf"),)
    assert model.brain_model == BrainModel(file="c.py")
    assert model.transfer_function == (PythonTransferFunction(src="a.py"),)


def test_the_first_schema_s_brain_is_the_name_of_a_file() -> None:
    assert read("<brainModel>braitenberg.h5</brainModel>").brain_model == BrainModel(file="braitenberg.h5")


def test_a_reference_of_old_names_its_property_behind_a_dot() -> None:
    body = '<body xsi:type="ArgumentReference" name="left.voltage"/>'
    made = function(f'<returnValue topic="/a" type="std_msgs.msg.Float64">{body}</returnValue>')
    assert made.return_value is not None
    assert made.return_value.body == ArgumentReference(name="left", property="voltage")


def test_neuron_groups_are_populations() -> None:
    group = '<neuronGroup xsi:type="Range" population="sensors" from="0" to="5"/>'
    brain = read(f"<brainModel><file>b.py</file>{group}</brainModel>").brain_model
    assert brain is not None
    assert brain.populations == (Range(population="sensors", from_=0, to=5),)


@pytest.mark.parametrize("tag", ["transferFunctionImport", "transferFunctionInline"])
def test_imports_and_inline_code_of_old_are_python(tag: str) -> None:
    found = read(f"<{tag}>\n      x = 1\n      y = 2\n    </{tag}>").transfer_function
    assert found == (PythonTransferFunction(code="x = 1\ny = 2"),)


def test_code_whose_first_line_stands_elsewhere_is_moved_together() -> None:
    code = "<![CDATA[@nrp.Robot2Neuron()\n        def f(t):\n            pass\n]]>"
    found = read(f"<transferFunctionInline>{code}</transferFunctionInline>").transfer_function
    assert found == (PythonTransferFunction(code="@nrp.Robot2Neuron()\ndef f(t):\n    pass"),)


@pytest.mark.parametrize(
    ("given", "selector"),
    [
        ('index="3"', Index(population="p", index=3)),
        ('from="1" to="4" step="2"', Range(population="p", from_=1, to=4, step=2)),
        ("", Population(population="p")),
    ],
)
def test_a_selector_without_a_type_is_known_by_what_it_has(given: str, selector: object) -> None:
    device = f'<device name="d" type="Poisson"><neurons population="p" {given}/></device>'
    assert function(device).device[0].neurons == selector


@pytest.mark.parametrize("text", ["SpikeRecorder", "spike_recorder", "spikerecorder"])
def test_device_types_are_read_in_both_spellings(text: str) -> None:
    device = f'<device name="d" type="{text}"><neurons population="p" index="0"/></device>'
    assert function(device).device[0].type is DeviceType.SPIKE_RECORDER


def test_xmi_documents_are_read() -> None:
    model = parse_bibi(
        '<xmi:XMI xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" xmlns:b="http://x/BIBI">'
        '<b:BIBIConfiguration xmi:id="_1" timestep="20"><brainModel file="b.py">'
        '<populations xmi:type="b:List" population="p" element="1 2 3"/></brainModel>'
        '<bodyModel value="r.sdf"/><transferFunction xmi:type="b:Neuron2Robot"><name>f</name>'
        '<local name="x"><body xmi:type="b:Constant" value="2"/></local>'
        "</transferFunction></b:BIBIConfiguration></xmi:XMI>"
    )
    assert model.timestep == 20
    assert model.brain_model == BrainModel(
        file="b.py", populations=(List(population="p", element=(1, 2, 3)),)
    )
    assert model.body_model == (BodyModel(file="r.sdf"),)
    assert model.transfer_function[0].local[0].body == Constant(value=2)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ("<bodyModl>x</bodyModl>", "m.bibi:2: <bibi> has no element <bodyModl>; did you mean 'bodyModel'?"),
        ("<timestep>0</timestep>", "<timestep> cannot be '0'; it must be a whole number, 1 or more"),
        ("<timestep>20</timestep><timestep>10</timestep>", "<bibi> has 'timestep' more than once"),
        ("text", "<bibi> cannot contain text, such as 'text'"),
        ('<transferFunction xsi:type="Neuron2Robt"/>', "did you mean 'Neuron2Robot'?"),
        ('<bodyModel xsi:type="BodyModl"/>', "m.bibi:2: <bodyModel> cannot have xsi:type 'BodyModl'; did"),
        ('<bodyModel xsi:type="Robot"/>', "'Robot'; valid: BodyModel"),
        ('<mode xsi:type="Wrd">M</mode>', "<mode> cannot have xsi:type 'Wrd'; did you mean 'Word'?"),
        ('<mode name="M">M</mode>', "<mode> has no attribute 'name': it holds a text"),
        ('<transferFunction name="f"/>', "<transferFunction> needs xsi:type; valid: Neuron2Monitor"),
        ('<configuration type="x"/>', '<configuration> needs an attribute src="..."'),
        ('<transferFunction xsi:type="Neuron2Robot" name="a b"/>', "'name' of <transferFunction> cannot be"),
        ("<bodyModel/", "not well-formed"),
    ],
)  # fmt: skip
def test_a_meaningless_element_is_refused_with_line_and_hint(inner: str, message: str) -> None:
    assert message in refusal(inner)


@pytest.mark.parametrize(
    "inner",
    [
        '<bodyModel xsi:type="BodyModel">r.sdf</bodyModel>',
        '<mode xsi:type="ns1:Word">M</mode>',
        '<mode xsi:type="xs:token" xml:space="preserve">M</mode>',
        '<timestep xsi:type="xs:string">20</timestep>',
    ],
)
def test_an_element_may_state_the_one_type_that_it_can_have(inner: str) -> None:
    assert read(inner, 'xsi:type="BIBIConfiguration"') == read(re.sub(' xsi:type="[^"]*"', "", inner))


@pytest.mark.parametrize("value", ["nan", "inf", "1,5", "0x10", ""])
def test_only_finite_numbers_are_constants(value: str) -> None:
    assert "it must be a finite number" in refusal(
        f'<transferFunction xsi:type="Neuron2Robot" name="f"><local name="x"><body xsi:type="Constant" '
        f'value="{value}"/></local></transferFunction>'
    )


@pytest.mark.parametrize(("text", "kind"), [("20", int), ("20.0", float), ("2e1", float)])
def test_whole_numbers_stay_whole(text: str, kind: type) -> None:
    body = f'<local name="x"><body xsi:type="Constant" value="{text}"/></local>'
    constant = function(body).local[0].body
    assert isinstance(constant, Constant)
    assert (constant.value, type(constant.value)) == (20, kind)


def test_a_character_that_xml_cannot_hold_is_refused_when_writing(golden: Golden) -> None:
    with golden.raises(ExperimentError, match="XML"):
        bibi_text(Bibi(mode="a\x00"))


@pytest.mark.parametrize("encoding", ["no-such", "utf-99"])
def test_an_encoding_that_cannot_be_read_is_refused(encoding: str, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        parse_bibi(f'<?xml version="1.0" encoding="{encoding}"?><bibi/>')


def test_a_missing_file_names_a_similar_one(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "braitenberg.bibi").write_text("<bibi/>")
    with golden.raises(ExperimentError, match="'braitenberg.bibi'"):
        read_bibi(tmp_path / "braitenbreg.bibi")


def test_texts_keep_their_white_space() -> None:
    text = ConstantString(value=" a\n\tb\r ")
    model = Bibi(transfer_function=(Neuron2Robot(name="f", local=(Local(name="x", body=text),)),))
    assert parse_bibi(bibi_text(model)) == model


def test_a_comment_around_code_may_be_less_deep_than_the_code() -> None:
    assert dedented("\n    #\n    def f(t):\n        pass\n  #") == "#\ndef f(t):\n    pass\n#"
