"""A model as a drawing."""

from __future__ import annotations

import re
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import pytest
from lxml import etree
from matplotlib.font_manager import FontProperties, findfont
from nrp_bibi import Bibi, parse_bibi, read_bibi
from nrp_bibi.diagram import diagram
from PIL import ImageFont

from nrp_core.cli.app import run_app

FOLDER = Path(experiment.__file__).parent


PYTHON = """
EYES = nrp.brain.eyes[0:2]

@nrp.MapRobotSubscriber("camera", nrp.Topic("/husky/camera", "sensor_msgs.msg.Image"))
@nrp.MapSpikeSource("left", EYES, nrp.poisson)
@nrp.MapSpikeSource("right", nrp.map_neurons(range(3), lambda i: nrp.brain.ears[i]), nrp.poisson)
@nrp.Robot2Neuron()
def see(t, camera, left, right):
    left.rate = right.rate = 50 if camera.value else 0

@nrp.NeuronMonitor(nrp.brain.group["wheels"], nrp.population_rate)
def watch(t):
    return True
"""


def drawn(model: Bibi, folder: Path = FOLDER) -> etree._Element:
    return etree.fromstring(diagram(model, folder / "model.bibi").encode())


def cards(drawing: etree._Element, style: str) -> list[list[str]]:
    groups = drawing.iterfind(f".//{{*}}g[@class='{style}']")
    return [[text.text or "" for text in group.iterfind("{*}text")] for group in groups]


def test_populations_devices_expressions_and_topics_are_drawn() -> None:
    drawing = drawn(read_bibi(FOLDER / "listing1.bibi"))
    assert cards(drawing, "population") == [["actors"]]
    assert cards(drawing, "device") == [
        ["left_wheel_neuron", "leaky_integrator_alpha", "actors[0]"],
        ["right_wheel_neuron", "leaky_integrator_alpha", "actors[1]"],
    ]
    assert cards(drawing, "topic") == [["/husky/cmd_vel", "geometry_msgs/Twist"]]
    ((title, *lines),) = cards(drawing, "function")
    assert title.startswith("linear_twist")
    assert lines[-1] == "return geometry_msgs.msg.Twist(linear=linear, angular=angular)"


@pytest.mark.parametrize(("name", "to_the_right"), [("listing1", 3), ("listing2", 0)])
def test_arrows_point_where_the_information_goes(name: str, to_the_right: int) -> None:
    drawing = drawn(read_bibi(FOLDER / f"{name}.bibi"))
    heads = [path.get("d") or "" for path in drawing.iterfind(".//{*}path[@marker-end]")]
    ends = [[float(x) for x in re.findall(r"([\d.]+),", path)] for path in heads]
    assert sum(end[0] < end[-1] for end in ends) == to_the_right


def test_no_card_overlaps_another() -> None:
    models = [read_bibi(FOLDER / f"listing{i}.bibi").transfer_function for i in (1, 2)]
    drawing = drawn(Bibi(transfer_function=(*models[0], *models[1])))
    boxes = [
        [float(r.get(k)) for k in ("x", "y", "width", "height")] for r in drawing.iterfind(".//{*}g/{*}rect")
    ]
    for i, (x, y, width, height) in enumerate(boxes):
        for to_x, to_y, to_width, to_height in boxes[:i]:
            apart = x + width <= to_x or to_x + to_width <= x or y + height <= to_y or to_y + to_height <= y
            assert apart


def test_python_is_drawn_as_it_is_and_cut_where_it_is_long() -> None:
    code = "\n".join(f"x{i} = '&lt;'" for i in range(40))
    ((title, *lines),) = cards(
        drawn(parse_bibi(f"<bibi><transferFunctionInline>{code}</transferFunctionInline></bibi>")), "function"
    )
    assert title == "Python"
    assert (lines[0], lines[-1], len(lines)) == ("x0 = '<'", "...", 12)


def test_devices_and_topics_of_python_are_drawn_although_it_is_not_executed(tmp_path: Path) -> None:
    (tmp_path / "functions.py").write_text(PYTHON)
    drawing = drawn(parse_bibi("<bibi><transferFunctionImport src='functions.py'/></bibi>"), tmp_path)
    assert cards(drawing, "function") == [["Python: functions.py", "see(t, camera, left, right)", "watch(t)"]]
    assert cards(drawing, "population") == [["ears"], ["eyes"], ["wheels"]]
    assert cards(drawing, "device") == [
        ["right", "poisson", "map_neurons(range(3), lambda", "i: ears[i])"],
        ["left", "poisson", "eyes[0:2]"],
        ["watch", "population_rate", "group['wheels']"],
    ]
    assert cards(drawing, "topic") == [
        ["/husky/camera", "sensor_msgs/Image"],
        ["/monitor/population_rate", "cle_ros_msgs/SpikeRate"],
    ]


def test_code_that_is_not_python_is_drawn_as_text() -> None:
    drawing = drawn(parse_bibi("<bibi><transferFunctionInline>print 'old'</transferFunctionInline></bibi>"))
    assert cards(drawing, "function") == [["Python", "print 'old'"]]


def test_the_command_writes_a_drawing(tmp_path: Path) -> None:
    target = tmp_path / "a.svg"
    assert run_app(["generate", str(FOLDER / "listing2.bibi"), "--diagram", str(target)]) == 0
    assert target.read_text() == diagram(read_bibi(FOLDER / "listing2.bibi"), FOLDER / "listing2.bibi")


def test_a_long_signature_is_drawn_whole_on_several_lines(tmp_path: Path) -> None:
    names = [f"left_wheel_forward_neuron_{i}" for i in range(8)]
    mappings = "\n".join(
        f"@nrp.MapSpikeSink('{name}', nrp.brain.actors, nrp.population_rate)" for name in names
    )
    code = f"{mappings}\n@nrp.Neuron2Robot()\ndef turn(t, {', '.join(names)}):\n    pass\n"
    (tmp_path / "turn.py").write_text(code)
    model = parse_bibi('<bibi><transferFunction xsi:type="PythonTransferFunction" src="turn.py"/></bibi>')
    ((_, *lines),) = cards(drawn(model, tmp_path), "function")
    assert " ".join(line.strip() for line in lines) == f"turn(t, {', '.join(names)})"
    assert max(map(len, lines)) <= 76


def test_no_line_of_code_is_wider_than_its_card(tmp_path: Path) -> None:
    parameters = ", ".join(f"left_wheel_forward_neuron_{i}" for i in range(4))
    code = f"def f(t, {parameters}):\n    return '{'W' * 100}'"
    drawing = drawn(parse_bibi(f"<bibi><transferFunctionInline>{code}</transferFunctionInline></bibi>"))
    (group,) = drawing.iterfind(".//{*}g[@class='function']")
    (card,) = group.iterfind("{*}rect")
    font = ImageFont.truetype(findfont(FontProperties(family="DejaVu Sans Mono")), 12)
    for line in group.iterfind("{*}text[@class='line']"):
        right = float(line.get("x") or 0) + font.getlength(line.text or "")
        assert right <= float(card.get("x") or 0) + float(card.get("width") or 0)
