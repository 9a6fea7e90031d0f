"""What is drawn is the model, whole and exact, for every model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from nrp_bibi import Bibi, bibi_text, parse_bibi, read_bibi
from nrp_bibi.generation.walk import channels, parts
from nrp_bibi.model.channels import AnyDevice, TopicChannel
from nrp_bibi.model.functions import BIBITransferFunction, Neuron2Robot, PythonTransferFunction
from nrp_bibi.model.selectors import NeuronSelector, NeuronSelectorTemplate
from nrp_cockpit.designer.checking import generated
from nrp_cockpit.designer.document import Document
from nrp_cockpit.designer.graph import Graph
from nrp_cockpit.designer.layout import placed
from nrp_cockpit.designer.metamodel import metamodel_data
from nrp_cockpit.designer.surroundings import Surroundings, Topic
from nrp_cockpit.designer.tree import at, node_data, walk

from nrp_core.errors import ExperimentError

SOME = settings(
    max_examples=12, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck)
)
ROOT = Path(__file__).parents[4]
FILES = sorted([*ROOT.glob("experiments/**/*.bibi"), *ROOT.glob("tests/legacy/corpus/**/*.bibi")])
OUTDATED = {"bare", "students"}
"""Models of old that only the reader of old experiments understands."""
SHIPPED = [path for path in FILES if path.stem not in OUTDATED]


def of(path: Path, text: str) -> Document:
    path.write_text(text, encoding="utf-8")
    return Document(path, Surroundings())


def missing(model: Bibi, graph: dict[str, Any]) -> list[str]:
    """Return what a graph does not show of a model, or shows without an end."""
    ends = {
        end for box in graph["boxes"] for end in (box["id"], *(row["path"] for row in box.get("rows", ())))
    }
    boxes = {box["id"] for box in graph["boxes"]}
    lost = [wire["id"] for wire in graph["wires"]
            if not {wire["source"], wire["target"]} <= boxes
            or not {wire["source_end"], wire["target_end"]} <= ends]  # fmt: skip
    wired = {end for wire in graph["wires"] for end in (wire["source_end"], wire["target_end"])}
    for path, node in walk(model):
        if isinstance(node, (TopicChannel, AnyDevice)) and not (
            path in ends and (path in wired or _bare(node))
        ):
            lost.append(path)
    return lost


def _bare(node: Any) -> bool:
    """Whether a device names no population."""
    return isinstance(node, AnyDevice) and not any(
        isinstance(part, (NeuronSelector, NeuronSelectorTemplate)) and part.population for part in parts(node)
    )


@given(data=st.data())
@SOME
def test_xml_to_boxes_to_xml_is_the_identity(
    documents: SearchStrategy[Bibi], data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    model = data.draw(documents)
    document = of(tmp_path_factory.mktemp("models") / "model.bibi", bibi_text(model))
    assert document.model == model
    graph = Graph(document.model, Surroundings())
    assert missing(model, graph.data()) == []
    assert {box["id"] for box in placed(graph, {})} == {box["id"] for box in graph.boxes}
    document.read_xml(bibi_text(model))
    assert not document.can_undo, "the same text is no change"
    document.save()
    assert read_bibi(document.path) == model


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_model_is_drawn_whole_and_saved_as_it_was(path: Path, tmp_path: Path) -> None:
    document = of(tmp_path / "model.bibi", path.read_text(encoding="utf-8-sig"))
    assert missing(document.model, Graph(document.model, Surroundings()).data()) == []
    document.save()
    assert read_bibi(document.path) == read_bibi(path)


@given(data=st.data())
@SOME
def test_python_to_boxes_to_python_is_the_identity(
    models: SearchStrategy[Bibi], data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    model = data.draw(models)
    document = of(tmp_path_factory.mktemp("models") / "model.bibi", bibi_text(model))
    python = generated(document.model, document.path)
    if python["error"] is None:
        assert len(python["lines"]) == python["text"].count("\n")
        document.read_python(python["text"])
        assert document.model == model, "what Python does not say, such as names of connectors, stays"


@given(data=st.data())
@SOME
def test_the_data_of_a_model_have_the_forms_of_its_metamodel(
    documents: SearchStrategy[Bibi], data: st.DataObject
) -> None:
    model = data.draw(documents)
    classes = metamodel_data()["classes"]
    for path, node in walk(model):
        assert at(model, path) == node
        fields = {feature["field"] for feature in classes[type(node).__name__]["features"]}
        assert set(node_data(node)["fields"]) == fields


def test_a_graph_that_lost_a_wire_or_a_row_is_noticed() -> None:
    model = read_bibi(next(path for path in SHIPPED if path.name == "listing1.bibi"))
    graph = Graph(model, Surroundings()).data()
    function = next(box for box in graph["boxes"] if box["kind"] == "function")
    assert missing(model, {**graph, "wires": graph["wires"][1:]}) != []
    function["rows"] = function["rows"][:-1]
    assert missing(model, graph) != []


def test_the_loss_of_comments_is_announced_before_it_happens(tmp_path: Path) -> None:
    document = of(tmp_path / "model.bibi", "<bibi><!-- by hand --></bibi>")
    assert "comments" in document.notes[0]
    assert of(tmp_path / "other.bibi", "<bibi/>").notes == []


def test_python_that_is_blocks_becomes_boxes_and_other_python_one_box(tmp_path: Path, golden: Golden) -> None:
    listing = ROOT / "experiments/nrp_experiments/braitenberg_husky/listing1.py"
    file = tmp_path / "wheels.py"
    file.write_text(
        f"{listing.read_text()}\n\n@nrp.Robot2Neuron()\ndef other(t):\n    while t:\n        break\n"
    )
    document = Document(file, Surroundings())
    assert [type(one) for one in document.model.transfer_function] == [Neuron2Robot, PythonTransferFunction]
    assert document.path == tmp_path / "wheels.bibi"
    assert not document.is_saved
    with golden.raises(ExperimentError):
        document.as_blocks("transfer_function/1")


def test_python_functions_are_wired_by_their_decorators_and_only_by_their_text() -> None:
    hexapod = ROOT / "experiments/nrp_experiments/walking_hexapod/walk.py"
    topics = [
        f"/hexapod/{leg}_{joint}/cmd_pos"
        for leg in ("front_left", "rear_right")
        for joint in ("alpha", "beta")
    ]
    around = Surroundings(
        {name: Topic(name, "std_msgs.msg.Float64") for name in topics}, {"swing": 48, "stance": 48}
    )
    document = Document(hexapod, around)
    data = document.data()
    (box,) = (one for one in data["boxes"] if one["kind"] == "python")
    assert box["name"] == "move"  # not the decorator above it
    assert [row["name"] for row in box["rows"]] == ["lifting", "forward", "back", "alpha", "beta"]
    ends = {end for wire in data["wires"] for end in (wire["source_end"], wire["target_end"])}
    assert ends == {*(row["path"] for row in box["rows"]), *(f"topic:{name}" for name in topics),
                    "population:swing[cells]", "population:stance[cells]"}  # fmt: skip
    messages = [wire for wire in data["wires"] if wire["kind"] == "message"]
    assert {wire["target"] for wire in messages} == {f"topic:{name}" for name in topics}
    assert box["id"] not in document.fits(f"topic:{topics[0]}")


def test_a_reference_to_a_python_file_becomes_boxes_when_asked(tmp_path: Path) -> None:
    listing = ROOT / "experiments/nrp_experiments/braitenberg_husky/listing1.py"
    (tmp_path / "wheels.py").write_text(listing.read_text())
    document = of(tmp_path / "model.bibi", '<bibi><transferFunction src="wheels.py"/></bibi>')
    document.as_blocks("transfer_function/0")
    function = document.model.transfer_function[0]
    assert isinstance(function, BIBITransferFunction)
    assert [channel.name for channel in channels(function)] == ["left_wheel_neuron", "right_wheel_neuron"]
    assert parse_bibi(bibi_text(document.model)) == document.model
