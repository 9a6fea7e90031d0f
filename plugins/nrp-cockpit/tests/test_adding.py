"""Bodies are moved, added and removed while a run goes on; a recording repeats it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import pytest
from visitors import Cockpit, RefusedError, Visitor, cockpit

from nrp_core.experiment.reading.find import find_file
from nrp_core.recording import Recording, Replay, ReplayRequest


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cockpit]:
    """A run of an experiment with the file of a model, and the folder of one, in its folder."""
    folder = tmp_path_factory.mktemp("hall")
    (folder / "hall.yaml").write_text("extends: slalom_pioneer\nname: hall\n")
    plant = find_file("braitenberg_husky").with_name("plant.sdf")
    (folder / "palm").mkdir()
    shutil.copy(plant, folder / "palm/model.sdf")
    shutil.copy(find_file("slalom_pioneer").parents[1] / "bodies/pan_tilt.sdf", folder / "head.sdf")
    shutil.copy(find_file("slalom_pioneer").with_name("hall.sdf"), folder)  # a room, which is no model
    with cockpit(experiment=str(folder / "hall.yaml")) as opened:
        yield opened


def bodies(visitor: Visitor) -> dict[str, Any]:
    return {one["name"]: one for one in visitor.last("experiment")["bodies"]}


def test_added_bodies_stand_fall_and_can_be_removed(opened: Cockpit, visitor: Visitor) -> None:
    visitor.subscribe("/cockpit/experiment")
    assert visitor.call("bodies/models")["models"] == ["box", "sphere", "cylinder", "head.sdf", "palm"]
    world = opened.run.world
    places = {"box": 3.0, "box_2": 5.5, "palm": 8.0, "head": 8.8}
    for model, name in (("box", "box"), ("box", "box_2"), ("palm", "palm"), ("head.sdf", "head")):
        at = [places[name], 1.0, 0.0]
        assert visitor.call("bodies/add", model=model, position=at, size_m=0.4) == {"body": name}
    visitor.until(lambda: "head" in bodies(visitor))
    assert bodies(visitor)["palm"]["pose"]["position"] == [8.0, 1.0, 0.0]
    assert bodies(visitor)["box"]["pose"] is None
    assert world.model_motion("box").pose.position == pytest.approx((3.0, 1.0, 0.2))
    assert world.scene.model("box").links[0].inertial.mass == pytest.approx(100 * 0.4**3)  # type: ignore[union-attr]
    visitor.call("place", body="box", position=[3.0, 1.0, 0.4], orientation=[0, 0, 0, 1])
    visitor.call("run_to", t_s=1.0)
    visitor.status(state="paused", t_s=1.0)
    assert world.model_motion("box").pose.position == pytest.approx((3.0, 1.0, 0.2), abs=0.01)
    visitor.call("bodies/remove", body="box")
    visitor.until(lambda: "box" not in bodies(visitor))
    visitor.call("seek", t_s=0.5)  # it was there then
    visitor.until(lambda: "box" in bodies(visitor))
    visitor.call("reset", what="all")
    visitor.until(lambda: not {"box", "box_2", "palm", "head"} & bodies(visitor).keys())


@pytest.mark.parametrize(
    ("service", "arguments", "said"),
    [
        ("bodies/add", {"model": "boxx", "position": [0, 0, 0]}, "'box'"),
        ("bodies/add", {"model": "../hall.yaml", "position": [0, 0, 0]}, "can be added"),
        ("bodies/add", {"model": "box", "position": [0, 0]}, "is 3 finite numbers"),
        ("bodies/add", {"model": "box", "position": [0, 0, 0], "size_m": 0}, "0.0001.*100"),
        ("bodies/remove", {"body": "pioneer"}, "is a robot"),
        ("bodies/remove", {"body": "pionier"}, "'pioneer'"),
    ],
)
def test_a_wrong_request_is_refused(
    visitor: Visitor, service: str, arguments: dict[str, Any], said: str
) -> None:
    with pytest.raises(RefusedError, match=said):
        visitor.call(service, **arguments)


def test_a_recording_repeats_what_was_moved_and_added(
    opened: Cockpit, visitor: Visitor, tmp_path: Path
) -> None:
    visitor.call("record", folder=str(tmp_path / "run"))
    visitor.call("step", n=5)
    visitor.call("bodies/add", model="cylinder", position=[3.0, 1.0, 1.0])
    turned = [0.0, 0.0, sin(pi / 8), cos(pi / 8)]
    visitor.call("place", body="pioneer", position=[-0.2, -0.3, 0.1], orientation=turned)
    visitor.call("bodies/add", model="head.sdf", position=[5.5, 1.0, 0.0])
    visitor.call("place", body="second_pillar", position=[4.5, 0.8, 0.5], orientation=[0, 0, 0, 1])
    visitor.call("step", n=50)
    assert opened.run.world.model_motion("cylinder").pose.position[2] == pytest.approx(0.25, abs=0.01)
    visitor.call("record", folder=None)
    with Replay(Recording(tmp_path / "run"), ReplayRequest()) as again:
        outcome = again.verify()
    assert (outcome.difference, outcome.steps) == (None, 55)
    assert json.loads((tmp_path / "run/run.json").read_text())["state"] == "interrupted"
