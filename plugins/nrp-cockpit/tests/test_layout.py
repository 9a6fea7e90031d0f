"""A layout of the page that cannot be used says why, with file and line, on the page and in the terminal."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest
from nrp_cockpit.command import open_run
from nrp_cockpit.session.arrangement import PANELS
from nrp_cockpit.session.layout import Layout
from nrp_cockpit.wire.channels import Channels
from nrp_cockpit.wire.hub import Hub
from visitors import SMALL, cockpit

from nrp_core import geometry_msgs, sensor_msgs
from nrp_core.errors import ExperimentError
from nrp_core.messages.cdr import Codec

TREE = {
    "direction": "row", "sizes": [2, 1, 1],
    "parts": ["scene", {"direction": "column", "sizes": [1, 1, 1], "parts": ["camera", "map", "brain"]},
              {"direction": "column", "sizes": [1.5, 1, 1], "parts": ["spikes", "traces", "inspector"]}],
}  # fmt: skip
GOOD = {"version": 1, "tree": TREE, "traces": [{"topic": "/husky/cmd_vel", "path": "linear.x"}]}


@pytest.fixture
def channels() -> Channels:
    codec, channels = Codec(), Channels()
    for topic, cls in {
        "/husky/cmd_vel": geometry_msgs.Twist, "/husky/joint_states": sensor_msgs.JointState
    }.items():  # fmt: skip
        name = codec.name(cls)
        channels.open(topic, name, codec.definition(name))
    return channels


def test_a_good_layout_has_no_problem(tmp_path: Path, channels: Channels) -> None:
    layout = Layout(tmp_path / "it.cockpit.json", channels)
    assert layout.load() == {}
    layout.save(GOOD)
    assert layout.load() == {"layout": GOOD}
    assert [*tmp_path.iterdir()] == []  # a layout is the user's own
    layout.reset()
    assert layout.load() == {}
    layout.preset(GOOD)
    layout.save({**GOOD, "traces": []})
    assert layout.load()["layout"]["traces"] == []
    assert layout.reset() == {"layout": GOOD}
    with pytest.raises(ExperimentError, match="'trees'"):
        layout.save({**GOOD, "trees": {}})


def test_a_layout_has_some_panels_and_several_of_a_kind(tmp_path: Path, channels: Channels) -> None:
    layout = Layout(tmp_path / "it.cockpit.json", channels)
    given = {
        **GOOD,
        "tree": {"direction": "row", "sizes": [1, 1, 1], "parts": ["camera", "camera 2", "traces 3"]},
        "traces": [{"topic": "/husky/cmd_vel", "path": "linear.x", "panel": "traces 3"}],
        "choices": {"camera 2": "/husky/camera"},
    }
    layout.save(given)
    assert layout.load() == {"layout": given}
    with pytest.raises(ExperimentError, match=r"'cmera 2'.*'camera'"):
        layout.save({**given, "choices": {"cmera 2": "/husky/camera"}})


def test_the_panels_are_those_of_the_page() -> None:
    source = Path(__file__).parents[1] / "page" / "src" / "state" / "panels.ts"
    (listed,) = re.findall(r"PANELS = \[(.*?)\] as const", source.read_text(), re.DOTALL)
    assert re.findall(r'"(\w+)"', listed) == [*PANELS]


def changed(keys: list[Any], value: Any) -> str:
    layout: Any = copy.deepcopy(GOOD)
    part = layout
    for key in keys[:-1]:
        part = part[key]
    part[keys[-1]] = value
    return json.dumps(layout, indent=2)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{\n"version": 1,\n', ":3:1: not YAML: a list in [ ] or a mapping in { } is not complete"),
        ("[]", ":1:1: a layout is a mapping"),
        ("\ud83d", ":1:1: not UTF-8"),
        ("[" * 100_000, ": nested too deeply"),
        ("{}", ":1:1: a layout needs the key 'version'"),
        (changed(["version"], 2), ":2:14: version: should be 1, not 2"),
        (changed(["tree", "parts", 0], "scen"),
         ":11:7: tree.parts.0: there is no panel 'scen'; did you mean 'scene'?"),
        (changed(["tree", "parts", 0], "scene 1"),
         ":11:7: tree.parts.0: 'scene 1': the panels of a kind are 'scene', 'scene 2', 'scene 3' and so on"),
        (changed(["tree"], {"direction": "row", "parts": [], "sizes": []}),
         ":3:11: tree: there is no panel in it"),
        (changed(["tree", "parts", 1, "parts", 0], "scene"), ":3:11: tree: the panel 'scene' is twice in it"),
        (changed(["tree", "parts", 1, "direction"], "diagonal"),
         ":13:22: tree.parts.1.direction: should be 'row' or 'column', not 'diagonal'"),
        (changed(["tree", "parts", 1, "sizs"], []),
         ":24:9: 'tree.parts.1' has no key 'sizs'; did you mean 'sizes'?"),
        (changed(["tree", "parts", 1], 3), ":12:7: tree.parts.1: should be a valid mapping, not 3"),
        (changed(["tree", "sizes"], [1, 1]), ":3:11: tree: it has 3 'parts' and 2 'sizes'"),
        (changed(["tree", "sizes", 0], -3), ":6:7: tree.sizes.0: should be greater than 0, not -3"),
        (changed(["traces"], {}), "traces: should be a valid list, not {}"),
        (changed(["traces", 0], {"topic": "/husky/cmd_vel"}), "'traces.0' needs the key 'path'"),
        (changed(["traces", 0, "path"], 3), "traces.0.path: should be a valid string, not 3"),
        (changed(["trces"], []), "a layout has no key 'trces'; did you mean 'traces'?"),
    ],
)  # fmt: skip
def test_a_broken_layout_is_not_used(text: str, words: str, tmp_path: Path, channels: Channels) -> None:
    file = tmp_path / "it.cockpit.json"
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    (problem,) = Layout(file, channels).load().values()
    assert str(file) in problem
    assert words in problem
    assert problem.endswith("; the page has its usual layout")


@pytest.mark.parametrize(
    ("topic", "path", "words"),
    [
        ("/husky/cmd_vl", "linear.x",
         "nothing is offered on the topic '/husky/cmd_vl' of a curve; did you mean '/husky/cmd_vel'?"),
        ("/husky/cmd_vel", "linear.w",
         "messages on /husky/cmd_vel have no number 'linear.w' for a curve; valid: x, y, z"),
        ("/husky/cmd_vel", "linear", "a curve needs one of x, y, z"),
        ("/husky/cmd_vel", "linear.x.y", "no number 'linear.x.y'"),
        ("/husky/cmd_vel", "linear[0].x", "'linear' is one value"),
        ("/husky/joint_states", "position", "'position' is a list: position[0] is its first item"),
        ("/husky/joint_states", "name[0]", "it is a text"),
        ("/husky/joint_states", "position[0]", ""),
    ],
)  # fmt: skip
def test_a_curve_without_data_is_reported_and_the_rest_is_used(
    topic: str, path: str, words: str, tmp_path: Path, channels: Channels
) -> None:
    file = tmp_path / "it.cockpit.json"
    given = {**GOOD, "traces": [*GOOD["traces"], {"topic": topic, "path": path}]}  # type: ignore[misc]
    file.write_text(json.dumps(given, indent=2))
    found = Layout(file, channels).load()
    assert found["layout"] == given
    problem = found.get("problem", "")
    assert words in problem
    assert bool(problem) == bool(words)
    assert not words or re.match(re.escape(str(file)) + r":\d+:\d+: ", problem)


def test_a_broken_layout_is_reported_in_the_terminal_and_on_the_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("extends: braitenberg_husky\nname: mine\n")
    layout = tmp_path / "mine.cockpit.json"
    layout.write_text("{")
    with open_run(str(file), [SMALL], Hub()) as session:
        session.functions.close()
    told = f"{layout}:1:2: not YAML"
    assert f"warning: {told}" in capsys.readouterr().err
    with cockpit(experiment=str(file)) as opened, opened.visit(steers=False) as visitor:
        assert told in visitor.call("layout/load")["problem"]


def test_a_file_that_cannot_be_read_is_reported(tmp_path: Path, channels: Channels) -> None:
    (problem,) = Layout(tmp_path, channels).load().values()
    assert f"{tmp_path}: cannot be read: Is a directory" in problem
