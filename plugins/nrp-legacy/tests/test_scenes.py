"""Of rooms and robots that cannot be used whole, the rest is used, and what is left out is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.errors import SceneError
from nrp_core.scene.model import Scene
from nrp_core.scene.reading.context import read_without
from nrp_core.scene.sdf import read_scene

ROOM = """<sdf version="1.6"><world name="w">
  <include><uri>model://not_there</uri></include>
  <model name="box"><static>1</static>
    <link name="link">
      <collision name="c">
        <geometry><box><size>1 1 1</size></box></geometry>
      </collision>
      <visual name="v">
        <pose>0 0</pose>
        <geometry><box><size>1 1 1</size></box></geometry>
      </visual>
    </link>
  </model>
  <light name="lamp" type="candle"/>
</world></sdf>
"""


def read(folder: Path, text: str) -> tuple[Scene, list[str]]:
    path = folder / "room.sdf"
    path.write_text(text)
    return read_without(lambda without: read_scene(path, without=without))


def test_the_least_that_is_wrong_is_left_out_with_its_line(tmp_path: Path) -> None:
    scene, left_out = read(tmp_path, ROOM)
    (box,) = scene.models
    (link,) = box.links
    assert (len(link.collisions), len(link.visuals), scene.lights) == (1, 0, ())
    assert sorted(found.line for found in left_out if found.line) == [2, 9, 14]
    assert all(found.message.endswith(": left out") for found in left_out)


def test_a_room_without_faults_is_read_as_it_is(tmp_path: Path) -> None:
    text = "\n".join(
        line for line in ROOM.splitlines() if not any(w in line for w in ("not_there", "0 0<", "candle"))
    )
    scene, left_out = read(tmp_path, text)
    assert (len(scene.models[0].links[0].visuals), left_out) == (1, [])


def test_a_file_that_is_not_a_scene_is_still_an_error(tmp_path: Path) -> None:
    with pytest.raises(SceneError):
        read(tmp_path, "<html/>")


def test_of_parts_on_one_line_those_that_cannot_be_used_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "room.sdf"
    path.write_text(
        '<sdf version="1.5"><world name="w"><include><uri>model://gone</uri></include>'
        "<population name='p'><model name='m'/></population></world></sdf>"
    )
    scene, told = read_without(lambda without: read_scene(path, without=without))
    assert not scene.models
    assert "there is no 'model://gone'" in "\n".join(map(str, told))


@pytest.mark.parametrize("version", ["", ' version="1.0"'])
@pytest.mark.parametrize("kept", [ROOM, ROOM[ROOM.index("<world") : ROOM.index("</sdf>")]])
def test_a_room_within_an_element_of_gazebo_is_read(tmp_path: Path, version: str, kept: str) -> None:
    scene, _ = read(tmp_path, f"<gazebo{version}>{kept}</gazebo>")
    assert [model.name for model in scene.models] == ["box"]


def test_a_model_that_is_named_twice_gets_a_number_and_is_reported_once(tmp_path: Path) -> None:
    box = ROOM[ROOM.index("<model") : ROOM.index("<light")].replace("<pose>0 0</pose>", "")
    scene, told = read(tmp_path, f'<sdf version="1.6"><world name="w">{box}{box}</world></sdf>')
    assert [model.name for model in scene.models] == ["box", "box_0"]
    assert len([*told, *scene.warnings]) == 1
