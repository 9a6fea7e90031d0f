"""People draw with commands: each is exact, has a way back, and is refused with a reason."""

from __future__ import annotations

from inspect import signature
from pathlib import Path

import pytest
from drawing import HUSKY, ROOT, Drawing
from golden import Golden
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from nrp_bibi import bibi_text, parse_bibi, read_bibi
from nrp_bibi.model.channels import DeviceType
from nrp_cockpit.designer.brain.document import BrainDocument
from nrp_cockpit.designer.changes import refusals
from nrp_cockpit.designer.checking import model_findings
from nrp_cockpit.designer.connecting import Connecting
from nrp_cockpit.designer.document import Document
from nrp_cockpit.designer.edit import Edit
from nrp_cockpit.designer.graph import Graph
from nrp_cockpit.designer.layout import read_layout
from nrp_cockpit.designer.metamodel import metamodel_data
from nrp_cockpit.designer.tree import walk

from nrp_core import dsl
from nrp_core.errors import ExperimentError

PAPER = ROOT / "experiments/nrp_experiments/braitenberg_husky"


def test_the_first_listing_of_the_paper_is_drawn_with_commands(drawing: Drawing) -> None:
    function = drawing.function("Neuron2Robot", "linear_twist")
    drawing.wired("population:actors", function, "left_wheel_neuron")
    drawing.wired("population:actors", function, "right_wheel_neuron")
    both = "left_wheel_neuron.voltage, right_wheel_neuron.voltage"
    drawing.local(function, "linear", f"geometry_msgs.msg.Vector3(20 * min({both}), 0, 0)")
    turn = "100 * (right_wheel_neuron.voltage - left_wheel_neuron.voltage)"
    drawing.local(function, "angular", f"geometry_msgs.msg.Vector3(0, 0, {turn})")
    returned = drawing.wired("topic:/husky/cmd_vel", function)
    text = "geometry_msgs.msg.Twist(linear=linear, angular=angular)"
    drawing.do("write", path=returned, field="body", text=text)
    assert drawing.model == read_bibi(PAPER / "listing1.bibi")


def test_the_second_listing_of_the_paper_is_drawn_with_commands(drawing: Drawing) -> None:
    function = drawing.function("Robot2Neuron", "eye_sensor_transmit")
    drawing.wired(function, "topic:/husky/camera")
    drawing.local(function, "image_results", "nrp.tf_lib.detect_red(camera.value)")
    for name, cells in (("red_left_eye", "0, 2"), ("red_right_eye", "1 3"), ("green_blue_eye", "4")):
        device = drawing.wired("population:sensors", function, name)
        if len(cells) > 1:
            drawing.do("become", path=f"{device}/neurons", type="List")
        field = "element" if len(cells) > 1 else "index"
        drawing.do("set", path=f"{device}/neurons", field=field, text=cells)
        share = name.replace("_eye", "").replace("red_left", "leftred").replace("red_right", "rightred")
        text = f"1000.0 * image_results.{share.replace('_', '')}"
        drawing.do("write", path=device, field="body", text=text)
    assert drawing.model == read_bibi(PAPER / "listing2.bibi")


@st.composite
def _command(draw: st.DrawFn, model: object) -> tuple[str, dict[str, object]]:
    """A command that somebody could give, sensible or not."""
    paths = [path for path, _ in walk(model)]  # type: ignore[arg-type]
    classes = metamodel_data()["classes"]
    fields = sorted({feature["field"] for one in classes.values() for feature in one["features"]})
    ends = [*(box["id"] for box in Graph(model, HUSKY).boxes), *paths]  # type: ignore[arg-type]
    path, field = draw(st.sampled_from(paths)), draw(st.sampled_from(fields))
    kind = draw(st.none() | st.sampled_from(sorted(classes)))
    text = draw(
        st.sampled_from(["", "a", "3", "-1.5", "0, 2", "/a/b", "Poisson", "true", "camera.value + 1"])
    )
    command = draw(st.sampled_from(["add", "add", "add", "set", "become", "write", "remove", "move", "copy",
                                    "connect", "connect", "connect"]))  # fmt: skip
    return command, {
        "add": {"path": path, "field": field, "type": kind},
        "set": {"path": path, "field": field, "text": text},
        "become": {"path": path, "type": kind or "Add"},
        "write": {"path": path, "field": field, "text": text},
        "remove": {"path": path}, "move": {"path": path, "to": 0}, "copy": {"path": path},
        "connect": {"source": draw(st.sampled_from(ends)), "target": draw(st.sampled_from(ends))},
    }[command]  # fmt: skip


@given(data=st.data())
@settings(max_examples=15, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
def test_any_commands_leave_a_model_that_is_written_and_every_step_goes_back(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    document = Document(tmp_path_factory.mktemp("drawn") / "new.bibi", HUSKY)
    for kind in ("Robot2Neuron", "Neuron2Robot", "Neuron2Monitor"):
        document.do("add", path="", field="transfer_function", type=kind)
    states = [document.model]
    for _ in range(12):
        command, arguments = data.draw(_command(document.model))
        try:
            document.do(command, **arguments)
            states.append(document.model)
        except ExperimentError:
            assert document.model is states[-1], "what is refused changes nothing"
        assert parse_bibi(bibi_text(document.model)) == document.model
        model_findings(document.model, document.path)
    for model in states[-2::-1]:
        document.undo()
        assert document.model is model
    for model in states[1:]:
        document.redo()
        assert document.model is model


@pytest.mark.parametrize(
    ("source", "target", "reason"),
    [
        ("topic:/husky/odom", "transfer_function/2", "/husky/odom"),
        ("topic:/husky/odom", "population:actors", "need a transfer function between them"),
        ("topic:/husky/odom", "topic:/husky/camera", "two topics need a transfer function"),
        ("population:actors", "population:sensors", "the brain connects its populations"),
        ("topic:/husky/camera", "transfer_function/0", "/husky/camera"),
        ("topic:/husky/cmd_vel", "transfer_function/0/topic/0", "is a command: it can only be published"),
        (
            "topic:/husky/odom",
            "transfer_function/1/return_value",
            "published by the robot: it can only be read",
        ),
        ("topic:/husky/odom", "transfer_function/0/device/0", "'eye'"),
        ("population:actors", "transfer_function/0/topic/0", "'camera'"),
        ("population:actors", "transfer_function/3", "its code says what it is connected to"),
        ("transfer_function/0", "transfer_function/1", "exchange values over topics or neurons"),
        ("transfer_function/0/topic/0", "transfer_function/1/return_value", "only inside its function"),
    ],
)
def test_an_impossible_connection_is_refused_with_its_reason(
    drawing: Drawing, source: str, target: str, reason: str
) -> None:
    first = drawing.function("Robot2Neuron", "eyes")
    second = drawing.function("Neuron2Robot", "wheels")
    drawing.function("Neuron2Monitor", "shown")
    drawing.do("add", path="", field="transfer_function", type="PythonTransferFunction")
    drawing.wired("topic:/husky/camera", first)
    drawing.wired("population:sensors", first, "eye")
    drawing.wired("topic:/husky/cmd_vel", second)
    before = drawing.model
    with pytest.raises(ExperimentError, match=reason):
        drawing.wired(source, target)
    assert drawing.model is before
    edit = Edit(before, HUSKY)
    found = refusals(edit, Connecting(edit).connect, source, [target])
    assert reason in str(found[target]), "a page says it before somebody lets go"


def test_a_wire_gets_its_type_from_its_ends(drawing: Drawing) -> None:
    function = drawing.function("Robot2Neuron", "eyes")
    camera = drawing.wired("topic:/husky/camera", function)
    eye = drawing.wired("population:sensors[0]", function, "eye")
    drawing.wired("population:actors", eye)
    drawing.wired(camera, eye)
    (row_of_topic, row) = next(box for box in Graph(drawing.model, HUSKY).boxes if box["id"] == function)[
        "rows"
    ]
    assert (row_of_topic["is_written"], row["is_written"]) == (False, True)
    assert (row["neurons"], row["text"], row["type"]) == ("actors[0]", "rate = camera.value", "Poisson")
    drawing.wired("topic:/screen/color", camera)
    assert drawing.model.transfer_function[0].topic[0].topic == "/screen/color"  # type: ignore[attr-defined]


def test_a_new_name_is_written_wherever_the_old_one_was_meant(drawing: Drawing) -> None:
    function = drawing.function("Neuron2Robot", "wheels")
    device = drawing.wired("population:actors", function, "left")
    drawing.local(function, "speed", "2 * left.voltage")
    drawing.do("set", path=device, field="name", text="right")
    assert 'name="right" property="voltage"' in bibi_text(drawing.model)
    copy = drawing.do("copy", path=device)
    assert [one.name for one in drawing.model.transfer_function[0].device] == ["right", "right_2"]  # type: ignore[attr-defined]
    drawing.do("move", path=copy, to=0)
    assert [one.name for one in drawing.model.transfer_function[0].device] == ["right_2", "right"]  # type: ignore[attr-defined]


def test_triggers_and_throttling_rates_are_written_to_the_file(drawing: Drawing) -> None:
    function = drawing.function("Robot2Neuron", "eyes")
    camera = drawing.wired("topic:/husky/camera", function)
    drawing.do("set", path=function, field="trigger", text="camera")
    drawing.do("set", path=function, field="throttling_rate", text="12.5")
    drawing.do("set", path=camera, field="name", text="eye")
    assert (
        'nrp.Robot2Neuron(triggers=["eye"], throttling_rate=12.5)'
        in drawing.document.data()["python"]["text"]
    )
    assert next(box["when"] for box in Graph(drawing.model, HUSKY).boxes if box["id"] == function) == (
        "on eye, ≤ 12.5 Hz"
    )
    drawing.do("remove", path=camera)
    (found,) = model_findings(drawing.model, drawing.document.path)
    assert (found["box"], "cannot be triggered by 'eye'" in found["summary"]) == (function, True)
    with pytest.raises(ExperimentError, match=r"'throttlingRate'.*'-3'"):
        drawing.do("set", path=function, field="throttling_rate", text="-3")


def test_the_forms_have_every_setting_of_a_function() -> None:
    for kind in (dsl.Neuron2Robot, dsl.Robot2Neuron):
        fields = {one["field"] for one in metamodel_data()["classes"][kind.__name__]["features"]}
        # vectorized is one of written Python
        settings_of_python = signature(kind).parameters.keys() - {
            "robot_topic",
            "vectorized",
        }
        assert settings_of_python
        assert all({name, name.rstrip("s")} & fields for name in settings_of_python)


def test_a_finding_stands_at_its_box_and_its_part(drawing: Drawing) -> None:
    function = drawing.function("Neuron2Robot", "wheels")
    drawing.function("Robot2Neuron", "eyes")
    device = drawing.wired("population:actors", function, "left")
    drawing.local(function, "speed", "left.voltage")
    drawing.do("remove", path=device)
    (found,) = model_findings(drawing.model, drawing.document.path)
    assert (found["box"], found["path"]) == (function, f"{function}/local/0/body")
    assert "no channel and no earlier local has the name 'left'" in found["summary"]
    drawing.document.undo()
    drawing.do("set", path="transfer_function/1", field="name", text="wheels")
    (found,) = model_findings(drawing.model, drawing.document.path)
    assert "'wheels' is used twice" in found["summary"]


@pytest.mark.parametrize(
    ("field", "text", "reason"),
    [
        ("name", "1st", "'name'.*'1st'"),
        ("name", "", "'name' is needed"),
        ("type", "Poison", "one of ACSource"),
    ],
)
def test_a_value_that_cannot_be_is_refused(drawing: Drawing, field: str, text: str, reason: str) -> None:
    device = drawing.wired("population:actors", drawing.function("Neuron2Robot", "wheels"))
    with pytest.raises(ExperimentError, match=reason):
        drawing.do("set", path=device, field=field, text=text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("lft.voltage", "this function has no channel or local 'lft.voltage'; did you mean 'left'?"),
        ("left.voltage **", "this is not an expression"),
        ("left.voltage ** 2", "cannot be expressed as blocks"),
        ("", "'body' needs an expression"),
    ],
)
def test_an_expression_that_cannot_be_is_refused(drawing: Drawing, text: str, reason: str) -> None:
    function = drawing.function("Neuron2Robot", "wheels")
    drawing.wired("population:actors", function, "left")
    with pytest.raises(ExperimentError, match=reason.replace("?", r"\?").replace("*", r"\*")):
        drawing.local(function, "speed", text)


def test_every_kind_of_device_says_whether_it_drives_neurons() -> None:
    devices = metamodel_data()["devices"]
    assert {kind.value for kind in DeviceType} == set(devices)
    assert {name for name, one in devices.items() if one["drives"]} == {
        "ACSource", "DCSource", "FixedFrequency", "NCSource", "Poisson",
    }  # fmt: skip
    assert (devices["Poisson"]["unit"], devices["LeakyIntegratorAlpha"]["unit"]) == ("Hz", "mV")


ENVELOPE = """
from nrp_core.dsl import CustomDevice

class Envelope(CustomDevice):
    default_property = "level"

    def apply(self, neurons, brain):
        self.level = 0.0
"""


def test_a_device_of_a_package_is_chosen_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawing: Drawing
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "lab_envelope.py").write_text(ENVELOPE)
    info = tmp_path / "lab_envelope-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-envelope\nVersion: 1.0\n")
    entry_points = "[nrp_core.devices]\nEnvelope = lab_envelope:Envelope\nBroken = lab_nothing:X\n"
    (info / "entry_points.txt").write_text(entry_points)
    found = metamodel_data()
    assert found["devices"]["Envelope"] == {"drives": False, "property": "level", "unit": ""}
    assert "Broken" not in found["devices"]
    (kinds,) = (
        one["enumeration"] for one in found["classes"]["DeviceChannel"]["features"] if one["field"] == "type"
    )
    assert kinds == list(found["devices"])
    function = drawing.function("Neuron2Robot", "wheels")
    left = drawing.wired("population:actors", function, "left")
    drawing.do("set", path=left, field="type", text="Envelope")
    drawing.local(function, "speed", "2 * left.level")
    python = drawing.document.data()["python"]["text"]
    assert '@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.device("Envelope"))' in python
    assert model_findings(drawing.model, drawing.document.path) == []


@pytest.mark.parametrize("place", [(float("nan"), 0.0), (0.0, float("-inf"))])
def test_a_place_that_is_not_finite_is_refused(
    drawing: Drawing, place: tuple[float, float], golden: Golden
) -> None:
    with golden.raises(ExperimentError):
        drawing.document.place("topic:/husky/camera", *place)


def test_boxes_stay_where_they_were_put_and_that_is_kept_beside_the_file(tmp_path: Path) -> None:
    document = Document(tmp_path / "new.bibi", HUSKY)
    document.place("topic:/husky/camera", 12.4, 30.0)
    document.save()
    assert read_layout(document.path) == ({"topic:/husky/camera": (12, 30)}, "")
    assert Document(document.path, HUSKY).state.moved == document.state.moved
    document.arrange()
    document.save()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["new.bibi"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "line 1 is not JSON: "),
        ('{"boxs": {}}', 'a layout is {"boxes": {"NAME": [x, y]}}'),
        ('{"boxes": {"drive": [1]}}', "the place of 'drive' is [1], not two numbers"),
        ('{"boxes": {"drive": [1, "2"]}}', """the place of 'drive' is [1, "2"], not two numbers"""),
        ('{"boxes": {"drive": [1, NaN]}}', "the place of 'drive' is [1, NaN], not two numbers"),
        ("[" * 99_999, "recursion"),
        ("\udcff", "utf-8"),
    ],
)
def test_an_unusable_layout_is_reported_until_it_is_saved(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "new.layout.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    for document in (Document(tmp_path / "new.bibi", HUSKY), BrainDocument(tmp_path / "new.py")):
        (note,) = document.notes
        assert "'new.layout.json' is not used, and saving replaces it: " in note
        assert words in note
        assert document.state.moved == {}
    document = Document(tmp_path / "new.bibi", HUSKY)
    document.save()
    assert document.notes == []
    assert Document(document.path, HUSKY).notes == []
