"""Values of robots and rooms that are valid, but that no real thing has, are reported."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi
from pathlib import Path

import nrp_experiments.bodies
import pytest

from nrp_core import read_model
from nrp_core.world.scene.implausible import implausible
from nrp_core.world.scene.model import Scene

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
        ({"mass": 20_000}, "'base' of 'arm' weighs 2e+04 kg in a box of 0.4 x 0.4 x 0.5 m: 2.5e+05 kg/m^3"),
        ({"mass": 4_000}, "'arm' weighs 4e+03 kg in a box of 0.4 x 0.4 x 0.5 m around it: 5e+04 kg/m^3"),
        ({"side": 400}, "the visuals of 'arm' are 400 m large and its collision shapes 0.5 m"),
        ({"gravity": 9.8}, "gravity is 0 0 9.8 m/s^2: it points upward"),
    ],
    ids=["degrees", "grams", "heavy", "millimetres", "gravity"],
)
def test_an_implausible_value_is_reported(tmp_path: Path, values: dict[str, float], words: str) -> None:
    (sentence,) = _sentences(tmp_path, **values)
    assert words in sentence


def test_a_transparency_in_percent_is_reported_with_what_it_hides(tmp_path: Path) -> None:
    value, seen = _sentences(tmp_path, transparency=5)
    assert "<transparency> must be from 0 to 1, not 5: 1 is used" in value
    assert seen == "nothing of 'arm' is seen: the opacity of each of its visuals is 0"


_CONTROLLED = """<sdf version="1.9"><model name="arm">
  <link name="base"><inertial><mass>20</mass></inertial></link>
  <link name="tip"><inertial><mass>1</mass></inertial></link>
  <joint name="elbow" type="revolute"><parent>base</parent><child>tip</child><axis><xyz>0 1 0</xyz>
    <limit><lower>-1</lower><upper>1</upper>{limits}</limit>
    <dynamics><damping>{damping}</damping></dynamics></axis></joint>
  <plugin filename="gz-sim-joint-position-controller-system" name="gz::sim::systems::JointPositionController">
    <joint_name>elbow</joint_name><p_gain>{p}</p_gain>
    <i_gain>{i}</i_gain><d_gain>{d}</d_gain><initial_position>{initial}</initial_position></plugin>
</model></sdf>
"""
_USUAL = {"limits": "", "damping": "0.1", "p": "9", "i": "0", "d": "0", "initial": "0"}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, None),
        ({"limits": "<effort>0</effort>"}, "has a controller, and its limit of effort is 0: it never moves"),
        ({"limits": "<velocity>0</velocity>"}, "its limit of velocity is 0: it never moves"),
        ({"damping": "-0.1"}, "has a damping of -0.1, which speeds it up"),
        ({"p": "2e6", "limits": "<effort>4</effort>"}, "exerts the largest effort, 4, at an error of 2e-06"),
        ({"p": "200", "limits": "<effort>4</effort>"}, None),
        ({"p": "0"}, "has no gain: its commands move nothing"),
        ({"p": "0", "d": "1"}, "has the gains p 0 and i 0: it never nears its target"),
        ({"p": "0", "i": "2", "d": "1"}, None),
        ({"initial": "1.2"}, "starts with 1.2, outside the limits of the joint of -1 to 1"),
    ],
    ids=[
        "nothing",
        "effort",
        "velocity",
        "damping",
        "strong",
        "ordinary",
        "gain",
        "dampens",
        "adds",
        "start",
    ],
)
def test_a_joint_that_never_moves_or_moves_by_itself_is_reported(
    tmp_path: Path, values: dict[str, str], words: str | None
) -> None:
    path = tmp_path / "arm.sdf"
    path.write_text(_CONTROLLED.format(**_USUAL | values))
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


_LINKS = """<sdf version="1.9"><model name="cart">
  <link name="base"><inertial><mass>{mass}</mass><pose>{centre} 0 0 0 0 0</pose>
    <inertia><ixx>{moment}</ixx><iyy>{moment}</iyy><izz>{moment}</izz></inertia></inertial>
    <{solid} name="hull"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></{solid}>
    <{solid} name="bump"><geometry><sphere><radius>{bump}</radius></sphere></geometry></{solid}>
    <sensor name="eye" type="camera"><topic>eye</topic><update_rate>30</update_rate><camera>
      <horizontal_fov>{fov}</horizontal_fov><image><width>32</width><height>32</height></image>
      <clip><near>{near}</near><far>50</far></clip></camera></sensor>
    <sensor name="scanner" type="ray"><topic>scan</topic><update_rate>10</update_rate><ray>
      <scan><horizontal><samples>181</samples><min_angle>{first}</min_angle><max_angle>1.57</max_angle>
      </horizontal></scan><range><min>0.1</min><max>8</max></range></ray></sensor></link>
  <link name="arm"><pose>{away} 0 0 0 0 0</pose><inertial><mass>{tip}</mass></inertial>
    <visual name="look"><geometry><box><size>0.4 0.1 0.1</size></box></geometry></visual></link>
  <joint name="elbow" type="{kind}"><parent>base</parent><child>{child}</child><axis><xyz>0 1 0</xyz>
    <dynamics><spring_stiffness>1</spring_stiffness><spring_reference>{rest}</spring_reference></dynamics>
    </axis></joint>{last}
</model></sdf>
"""
_ORDINARY = {
    "mass": 10, "centre": 0.1, "moment": 0.3, "solid": "collision", "bump": 0.05, "away": 0.4, "rest": 1.57,
    "kind": "revolute", "child": "arm", "last": "", "tip": 1, "fov": 1.0, "near": 0.05, "first": -1.57,
}  # fmt: skip


def _of_cart(folder: Path, robots: list[str], gravity: float, **values: object) -> list[str]:
    path = folder / "cart.sdf"
    path.write_text(_LINKS.format(**{**_ORDINARY, **values}))
    scene = Scene((read_model(path),), gravity=(0.0, 0.0, gravity))
    return [sentence for _, sentence in implausible(scene, robots)]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (
            {"mass": 10_000},
            "the link 'base' of 'cart' weighs 1e+04 kg in a box of 0.4 x 0.4 x 0.4 m: 1.6e+05",
        ),
        ({"moment": 0.3e-6}, "an inertia of 3e-07 kg m^2, that of 10 kg in a ball of 0.00055 m"),
        ({"moment": 0.3e6}, "an inertia of 3e+05 kg m^2, that of 10 kg in a ball of 5.5e+02 m"),
        ({"centre": 0.5}, "the centre of mass of the link 'base' of 'cart' is 0.3 m outside of its shapes"),
        ({"bump": 0.00005}, "the collision 'bump' of the link 'base' of 'cart' is 0.0001 m large"),
        (
            {"away": 400},
            "the joint 'elbow' of 'cart' joins links 400 m apart, and the largest link is 0.69 m",
        ),
        ({"solid": "visual"}, "'cart' has no collision shape: it falls through the ground"),
        ({"last": "<link name='lid'/>"}, "the link 'lid' of 'cart' is a body of its own: no joint holds it"),
        ({"rest": 90}, "the spring of the joint 'elbow' of 'cart' rests at 90 rad, more than two turns"),
        ({"fov": 0.01}, "the camera 'eye' of 'cart' sees 0.01 rad, which is 0.57 degrees"),
        ({"near": 5}, "the camera 'eye' of 'cart' sees nothing nearer than 5 m"),
        ({"first": 1.569}, "the 181 beams of 'scanner' of 'cart' are within 0.001 rad: from 1.569 to 1.57"),
    ],
    ids=lambda one: next(iter(one)) if isinstance(one, dict) else "",
)
def test_a_link_that_is_no_body_is_reported(tmp_path: Path, values: dict[str, object], words: str) -> None:
    assert [words in sentence for sentence in _of_cart(tmp_path, ["cart"], -9.8, **values)] == [True]


def test_an_ordinary_cart_gives_nothing(tmp_path: Path) -> None:
    near = {"mass": 30, "moment": 0.05, "centre": -0.25, "bump": 0.001, "away": 3, "fov": 0.1, "rest": 6.0}
    assert _of_cart(tmp_path, ["cart"], -9.8) == []
    assert _of_cart(tmp_path, ["cart"], -1.62, **near, near=0.5, first=1.47) == []


@pytest.mark.parametrize(
    ("gravity", "mass", "words"),
    [
        (-1.0, 10.0, "gravity is 0 0 -1 m/s^2; is it meant in g, which is 9.8 m/s^2?"),
        (-9.8, 1e-9, "'cart' weighs 2e-09 kg in a box of 0.8 x 0.4 x 0.4 m around it: 1.6e-08"),
    ],
)
def test_the_room_is_checked_as_well(tmp_path: Path, gravity: float, mass: float, words: str) -> None:
    said = _of_cart(tmp_path, [], gravity, mass=mass, moment=mass / 30, tip=mass)
    assert [words in sentence for sentence in said] == [True]


_BODY = """<inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>"""
_SLOW = """<robot name="arm"><link name="base">{body}</link><link name="tip">{body}</link>
  <joint name="elbow" type="{kind}"><parent link="base"/><child link="tip"/>
    <limit lower="-1" upper="1"{effort} velocity="{velocity}"/></joint>
  <gazebo><plugin name="gz::sim::systems::JointPositionController" filename="x">
    <joint_name>elbow</joint_name>{more}</plugin></gazebo></robot>
"""


def _output(high: float, low: float) -> str:
    return f"<cmd_max>{high}</cmd_max><cmd_min>{low}</cmd_min>"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"velocity": "0.006"}, "has a controller and moves at most 0.006 rad/s: is that meant?"),
        ({"velocity": "0.0006", "kind": "prismatic"}, "moves at most 0.0006 m/s: is that meant?"),
        ({"effort": ""}, "the <limit> of the joint 'elbow' has no effort: not limited"),
        ({"more": _output(-1, 1)}, "<cmd_min> of 'elbow', 1, is above its <cmd_max>, -1: only the effort of"),
        ({"more": _output(3, -3)}, "'elbow' is not limited to <cmd_min> -3 and <cmd_max> 3: only the effort"),
        ({}, ""),
        ({"velocity": "0.05"}, ""),
        ({"more": _output(1000, -1000)}, ""),
    ],
)
def test_limits_of_a_commanded_joint_are_plausible(
    tmp_path: Path, values: dict[str, str], words: str
) -> None:
    written = {
        "velocity": "2",
        "kind": "revolute",
        "effort": ' effort="9"',
        "more": "",
        "body": _BODY,
    } | values
    path = tmp_path / "arm.urdf"
    path.write_text(_SLOW.format(**written))
    model = read_model(path)
    found = [str(warning) for warning in model.warnings]
    found += [sentence for _, sentence in implausible(Scene((model,)), ["arm"]) if "elbow" in sentence]
    assert [one for one in found if words in one] if words else not found, found


_ROD = """<sdf version="1.9"><model name="rod"><link name="rod"><inertial><mass>0.8</mass>
  <pose>0 0 0 {tilt}</pose><inertia><ixx>{x}</ixx><iyy>0.0079</iyy><izz>{z}</izz></inertia></inertial>
  <collision name="rod"><geometry><box><size>0.36 0.06 0.06</size></box></geometry></collision>
</link></model></sdf>
"""


@pytest.mark.parametrize(
    ("tilt", "x", "z", "is_exchanged"),
    [
        ("0 0 0", 0.0004, 0.0079, False),
        ("0 0 0", 0.0079, 0.0004, True),
        ("0 1.5708 0", 0.0079, 0.0004, False),  # the axes of the moments are turned as the rod is
        ("0 1.5708 0", 0.0004, 0.0079, True),
    ],
)
def test_moments_are_compared_with_shapes_along_the_axes_of_the_link(
    tmp_path: Path, tilt: str, x: float, z: float, is_exchanged: bool
) -> None:
    (path := tmp_path / "rod.sdf").write_text(_ROD.format(tilt=tilt, x=x, z=z))
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), ["rod"])]
    assert [sentence for sentence in found if "are the axes exchanged?" in sentence] == found[:is_exchanged]
    assert len(found) == is_exchanged


_PILLAR = """<sdf version="1.9"><model name="pillar"><static>true</static><link name="link">
  <collision name="pillar"><geometry>{solid}</geometry></collision>
  <visual name="pillar"><geometry>{seen}</geometry></visual>
</link></model></sdf>
"""
_CYLINDER = "<cylinder><radius>{}</radius><length>1</length></cylinder>"


@pytest.mark.parametrize(
    ("solid", "seen", "is_reported"),
    [(0.25, 0.25, False), (0.5, 0.25, True), (0.25, 0.5, True), (0.3, 0.25, False)],
)
def test_a_diameter_in_place_of_a_radius_is_reported(
    tmp_path: Path, solid: float, seen: float, is_reported: bool
) -> None:
    shapes = {"solid": _CYLINDER.format(solid), "seen": _CYLINDER.format(seen)}
    (path := tmp_path / "pillar.sdf").write_text(_PILLAR.format(**shapes))
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), [])]
    words = f"has a radius of {solid:g} m, and its visual one of {seen:g} m; is one of them a diameter?"
    assert [words in one for one in found] == [True] * is_reported
    foot = path.read_text().replace("<static>true</static>", "")
    path.write_text(foot)  # a robot may have larger feet than it shows
    assert not any("a diameter?" in one for _, one in implausible(Scene((read_model(path),)), ["pillar"]))


@pytest.mark.parametrize(("effort", "is_reported"), [(20.0, False), (2.0, False), (1.0, True)])
def test_a_joint_that_cannot_hold_what_hangs_on_it_is_reported(
    tmp_path: Path, effort: float, is_reported: bool
) -> None:
    """The arm that ships, straight ahead: 0.8 kg at 0.15 m and 0.5 kg at 0.45 m need 3.38 N m."""
    text = (Path(nrp_experiments.bodies.__path__[0]) / "arm.sdf").read_text("utf-8")
    changed = text.replace("<upper>2</upper><effort>20<", f"<upper>2</upper><effort>{effort}<")
    (path := tmp_path / "arm.sdf").write_text(changed, "utf-8")
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), ["arm"])]
    needed = 9.81 * (0.8 * 0.15 + 0.5 * 0.45)
    words = f"what it carries needs {needed:.2g} N m to be held where it starts"
    assert [words in one for one in found] == [True] * is_reported


def test_a_joint_is_loaded_as_it_stands_at_the_start(tmp_path: Path) -> None:
    """Upper arm down by 60 degrees: half of what it needs straight ahead; upright it needs nothing."""
    text = (Path(nrp_experiments.bodies.__path__[0]) / "arm.sdf").read_text("utf-8")
    weak = text.replace("<upper>2</upper><effort>20<", "<upper>2</upper><effort>0.5<")
    (path := tmp_path / "arm.sdf").write_text(weak)
    model, needed = read_model(path), 9.81 * (0.8 * 0.15 + 0.5 * 0.45) * cos(pi / 3)
    for start, words in ((pi / 3, f"needs {needed:.2g} N m to be held"), (-pi / 2, "to be held")):
        scene = Scene((replace(model, starts=(("shoulder", start),)),))
        found = [sentence for _, sentence in implausible(scene, ["arm"])]
        assert [words in one for one in found] == [True] * (start > 0)


_CRANE = """<robot name="crane">
  <link name="base"><inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><box size="0.3 0.3 0.3"/></geometry></collision></link>
  <link name="hook">{solid}
    <inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/></inertial></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="hook"/>
    <origin xyz="0 0 0.2" {turned}/>
    <limit lower="{lower}" upper="{upper}" effort="10" velocity="1"/></joint>
  <gazebo reference="hook"><sensor name="touch" type="contact"/>
    <sensor name="eye" type="camera"><pose>0 0 0 {look}</pose>
    <camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height></image></camera>
    </sensor></gazebo>
</robot>"""
_SOLID = '<collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision>'
_RIGHT = {"solid": _SOLID, "turned": "", "lower": "0", "upper": "0.2", "look": "0 0 0"}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, ""),
        ({"upper": "30"}, "'slide' of 'crane' slides from 0 to 30 m, and the largest link is 0.52 m large"),
        ({"upper": "6.28"}, ""),
        ({"lower": "-50", "upper": "50"}, ""),
        ({"upper": "1000"}, ""),
        (
            {"solid": ""},
            "the contact sensor 'touch' of 'crane' is on the link 'hook', which has no collision",
        ),
        ({"look": "-1.5708 0 -1.5708"}, "looks along -y of its link, and the top of its images is along x"),
        ({"look": "-1.5708 0 -1.5708", "turned": 'rpy="1.5708 0 1.5708"'}, ""),
        ({"look": "1.5708 0 0"}, ""),
        ({"look": "0 0 -1.5708"}, ""),
    ],
)
def test_travels_touch_and_cameras_that_contradict_their_robot_are_reported(
    tmp_path: Path, values: dict[str, str], words: str
) -> None:
    (path := tmp_path / "crane.urdf").write_text(_CRANE.format(**_RIGHT | values))
    found = [sentence for _, sentence in implausible(Scene((read_model(path),)), ["crane"])]
    assert [words in one for one in found] == [True] * bool(words), found


_NOISE = """<sdf version="1.9"><model name="scout"><link name="base">
  <collision name="hull"><geometry><box><size>1 1 1</size></box></geometry></collision>
  <sensor name="scan" type="ray"><update_rate>10</update_rate><ray>
    <scan><horizontal><samples>9</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
    <range><min>0</min><max>8</max></range><noise>{noise}</noise></ray></sensor>
</link></model></sdf>
"""


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        ("<type>gaussian</type><stddev>0.05</stddev>", None),
        ("<type>none</type><mean>0</mean><stddev>0</stddev>", None),
        ("<type>gaussian</type><stddev>5</stddev>", "is 5, and its range is 8"),
        ("<stddev>0.05</stddev>", "of the type none: there is no noise; write <type>gaussian</type>"),
        ("<type>none</type><stddev>0.05</stddev>", "of the type none: there is no noise"),
    ],
)
def test_noise_that_is_off_or_drowns_a_measurement_is_reported(
    tmp_path: Path, noise: str, words: str | None
) -> None:
    (path := tmp_path / "scout.sdf").write_text(_NOISE.format(noise=noise))
    model = read_model(path)
    found = [str(one) for one in model.warnings if "<noise>" in str(one)]
    found += [sentence for _, sentence in implausible(Scene((model,)), []) if "noise" in sentence]
    assert [words is not None and words in one for one in found] == [True] * (words is not None)
