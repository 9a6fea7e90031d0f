"""A model as a picture."""

from __future__ import annotations

import re
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import pytest
from lxml import etree
from nrp_bibi import Bibi, parse_bibi, read_bibi
from nrp_bibi.diagram import diagram

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

@nrp.NeuronMonitor(nrp.brain.wheels, nrp.population_rate)
def watch(t):
    return True
"""


def drawn(model: Bibi, folder: Path = FOLDER) -> etree._Element:
    return etree.fromstring(diagram(model, folder / "model.bibi").encode())


def cards(picture: etree._Element, style: str) -> list[list[str]]:
    groups = picture.iterfind(f".//{{*}}g[@class='{style}']")
    return [[text.text or "" for text in group.iterfind("{*}text")] for group in groups]


def test_populations_devices_expressions_and_topics_are_drawn() -> None:
    picture = drawn(read_bibi(FOLDER / "listing1.bibi"))
    assert cards(picture, "population") == [["actors"]]
    assert cards(picture, "device") == [
        ["left_wheel_neuron", "leaky_integrator_alpha", "actors[0]"],
        ["right_wheel_neuron", "leaky_integrator_alpha", "actors[1]"],
    ]
    assert cards(picture, "topic") == [["/husky/cmd_vel", "geometry_msgs/Twist"]]
    ((title, *lines),) = cards(picture, "function")
    assert title.startswith("linear_twist")
    assert lines[-1] == "return geometry_msgs.msg.Twist(linear=linear, angular=angular)"


@pytest.mark.parametrize(("name", "to_the_right"), [("listing1", 3), ("listing2", 0)])
def test_arrows_point_where_the_information_goes(name: str, to_the_right: int) -> None:
    picture = drawn(read_bibi(FOLDER / f"{name}.bibi"))
    heads = [path.get("d") or "" for path in picture.iterfind(".//{*}path[@marker-end]")]
    ends = [[float(x) for x in re.findall(r"([\d.]+),", path)] for path in heads]
    assert sum(end[0] < end[-1] for end in ends) == to_the_right


def test_no_card_overlaps_another() -> None:
    models = [read_bibi(FOLDER / f"listing{i}.bibi").transfer_function for i in (1, 2)]
    picture = drawn(Bibi(transfer_function=(*models[0], *models[1])))
    boxes = [
        [float(r.get(k)) for k in ("x", "y", "width", "height")] for r in picture.iterfind(".//{*}g/{*}rect")
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
    picture = drawn(parse_bibi("<bibi><transferFunctionImport src='functions.py'/></bibi>"), tmp_path)
    assert cards(picture, "function") == [["Python: functions.py", "see(t, camera, left, right)", "watch(t)"]]
    assert cards(picture, "population") == [["ears"], ["eyes"], ["wheels"]]
    assert cards(picture, "device") == [
        ["right", "poisson", "map_neurons(range(3), lambda", "i: ears[i])"],
        ["left", "poisson", "eyes[0:2]"],
        ["watch", "population_rate", "wheels"],
    ]
    assert cards(picture, "topic") == [
        ["/husky/camera", "sensor_msgs/Image"],
        ["/monitor/population_rate", "cle_ros_msgs/SpikeRate"],
    ]


def test_what_is_no_python_is_drawn_as_its_text() -> None:
    picture = drawn(parse_bibi("<bibi><transferFunctionInline>print 'old'</transferFunctionInline></bibi>"))
    assert cards(picture, "function") == [["Python", "print 'old'"]]


def test_the_command_writes_a_picture(tmp_path: Path) -> None:
    target = tmp_path / "a.svg"
    assert run_app(["generate", str(FOLDER / "listing2.bibi"), "--diagram", str(target)]) == 0
    assert target.read_text() == diagram(read_bibi(FOLDER / "listing2.bibi"), FOLDER / "listing2.bibi")
