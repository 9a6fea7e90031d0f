"""Values of robots and rooms that are valid, but that no real thing has, are reported."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core import read_model
from nrp_core.world.scene.model import Scene
from nrp_core.world.scene.plausible import implausible

_ARM = """<sdf version="1.9"><model name="arm">
  <link name="base"><inertial><mass>{mass}</mass></inertial>
    <collision name="hull"><geometry><box><size>0.4 0.4 0.5</size></box></geometry></collision>
    <visual name="look"><transparency>{transparency}</transparency>
      <geometry><box><size>{side} 0.4 0.5</size></box></geometry></visual></link>
  <link name="tip"><inertial><mass>1</mass></inertial></link>
  <joint name="elbow" type="revolute"><parent>base</parent><child>tip</child><axis><xyz>0 1 0</xyz>
    <limit><lower>{lower}</lower><upper>{upper}</upper></limit></axis></joint>
</model></sdf>
"""


def _sentences(folder: Path, gravity: float = -9.8, **values: float) -> list[str]:
    written = {"mass": 20, "side": 0.4, "lower": -1.57, "upper": 1.57, "transparency": 0} | values
    path = folder / "arm.sdf"
    path.write_text(_ARM.format(**written))
    model = read_model(path)
    found = [str(warning) for warning in model.warnings]
    scene = Scene((model,), gravity=(0.0, 0.0, gravity))
    return found + [sentence for _, sentence in implausible(scene, ["arm"])]


def test_a_plausible_robot_gives_nothing(tmp_path: Path) -> None:
    assert _sentences(tmp_path) == []


@pytest.mark.parametrize("upper", [1e16, 1e3, float("inf"), 12.0])
def test_limits_that_mean_no_limit_or_two_turns_give_nothing(tmp_path: Path, upper: float) -> None:
    assert _sentences(tmp_path, lower=-upper, upper=upper) == []


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"lower": -90, "upper": 90}, "'elbow' of 'arm' has limits of -90 to 90 rad, more than two turns"),
        ({"mass": 20_000}, "'arm' weighs 2e+04 kg in a box of 0.4 x 0.4 x 0.5 m around it: 2.5e+05 kg/m^3"),
        ({"side": 400}, "the visuals of 'arm' are 400 m large and its collision shapes 0.5 m"),
        ({"gravity": 9.8}, "gravity is 0 0 9.8 m/s^2: it points upward"),
        ({"transparency": 5}, "<transparency> must be from 0 to 1, not 5: 1 is used"),
    ],
    ids=["degrees", "grams", "millimetres", "gravity", "transparency"],
)
def test_an_implausible_value_is_reported(tmp_path: Path, values: dict[str, float], words: str) -> None:
    (sentence,) = _sentences(tmp_path, **values)
    assert words in sentence


_CONTROLLED = """<sdf version="1.9"><model name="arm">
  <link name="base"><inertial><mass>20</mass></inertial></link>
  <link name="tip"><inertial><mass>1</mass></inertial></link>
  <joint name="elbow" type="revolute"><parent>base</parent><child>tip</child><axis><xyz>0 1 0</xyz>
    <limit><lower>-1</lower><upper>1</upper>{limits}</limit>
    <dynamics><damping>{damping}</damping></dynamics></axis></joint>
  <plugin filename="gz-sim-joint-position-controller-system" name="gz::sim::systems::JointPositionController">
    <joint_name>elbow</joint_name><p_gain>{p}</p_gain>
    <i_gain>0</i_gain><d_gain>0</d_gain><initial_position>{initial}</initial_position></plugin>
</model></sdf>
"""


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, None),
        ({"limits": "<effort>0</effort>"}, "has a controller, and its limit of effort is 0: it never moves"),
        ({"limits": "<velocity>0</velocity>"}, "its limit of velocity is 0: it never moves"),
        ({"damping": "-0.1"}, "has a damping of -0.1, which speeds it up"),
        ({"p": "0"}, "has no gain: its commands move nothing"),
        ({"initial": "1.2"}, "starts with 1.2, outside the limits of the joint of -1 to 1"),
    ],
    ids=["nothing", "effort", "velocity", "damping", "gain", "start"],
)
def test_a_joint_that_never_moves_or_moves_by_itself_is_reported(
    tmp_path: Path, values: dict[str, str], words: str | None
) -> None:
    path = tmp_path / "arm.sdf"
    path.write_text(_CONTROLLED.format(**{"limits": "", "damping": "0.1", "p": "9", "initial": "0"} | values))
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), ["arm"])]
    assert len(found) == (words is not None)
    assert words is None or words in found[0]


@pytest.mark.parametrize(("roll", "count"), [("0", 0), ("1.5708", 0), ("3.14159", 1)])
def test_a_ground_plane_that_faces_downward_is_reported(tmp_path: Path, roll: str, count: int) -> None:
    path = tmp_path / "ground.sdf"
    path.write_text(
        f'<sdf version="1.9"><model name="ground"><static>true</static><pose>0 0 0 {roll} 0 0</pose>'
        '<link name="l"><collision name="floor"><geometry><plane/></geometry></collision></link>'
        "</model></sdf>"
    )
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), [])]
    assert len(found) == count
    assert all("the plane 'floor' of 'ground' faces downward" in sentence for sentence in found)
