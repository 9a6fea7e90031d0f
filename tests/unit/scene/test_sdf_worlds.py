from __future__ import annotations

from collections.abc import Callable
from math import inf
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Box, Cylinder, Mesh, Plane, Scene, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene

WorldReader = Callable[..., Scene]
Writer = Callable[..., Path]

LINK = '<link name="base"><inertial/></link>'


def test_a_world_holds_models_lights_and_gravity(world: WorldReader) -> None:
    scene = world(
        f'<gravity>0 0 -1.6</gravity><model name="a"><pose>1 2 3 0 0 0</pose>{LINK}</model>'
        '<light name="sun" type="directional"><pose>0 0 9 0 0 0</pose><direction>0 3 -4</direction>'
        "<diffuse>0.5 0.5 0.5 1</diffuse></light>"
    )
    assert scene.gravity == (0, 0, -1.6)
    assert scene.model("a").pose == Pose((1, 2, 3))
    (sun,) = scene.lights
    assert (sun.name, sun.kind, sun.pose.position) == ("sun", "directional", (0, 0, 9))
    assert sun.direction == pytest.approx((0, 0.6, -0.8))
    assert sun.diffuse == (0.5, 0.5, 0.5, 1)
    assert scene.warnings == ()


def test_gravity_is_earths_unless_the_world_or_its_physics_say(world: WorldReader) -> None:
    assert world("").gravity == (0, 0, -9.8)
    old = "<physics><gravity>0 0 -3</gravity></physics>"
    assert world(old, version="1.4").gravity == (0, 0, -3)


def test_the_default_of_several_physics_is_used(world: WorldReader) -> None:
    physics = "<physics{}><max_step_size>{}</max_step_size></physics>"
    scene = world(physics.format("", 0.001) + physics.format(' default="true"', 0.002))
    assert scene.step_s == 0.002
    assert not scene.warnings
    assert world(physics.format("", 0.001) + physics.format("", 0.002)).step_s == 0.001


def test_models_without_a_world_are_a_scene(write: Writer) -> None:
    assert [m.name for m in read_scene(write(f'<model name="a">{LINK}</model>')).models] == ["a"]


def test_models_and_fixed_links_of_one_name_are_renamed(world: WorldReader) -> None:
    scene = world(
        f'<model name="a">{LINK}</model>\n<model name="a">{LINK}</model>'
        f'<model name="house"><static>1</static>{LINK}{LINK}</model>'
    )
    assert [model.name for model in scene.models] == ["a", "a_0", "house"]
    assert len({link.name for link in scene.models[2].links}) == 2
    assert [each.subject for each in scene.warnings if each.code == Code.NRP266].count("a") == 1


def test_lights_shine_as_far_as_wide_and_as_bright_as_the_file_says(world: WorldReader) -> None:
    scene = world(
        '<light name="sun" type="directional"/>'
        '<light name="lamp" type="point">'
        "<attenuation><range>7</range><quadratic>0.5</quadratic></attenuation>"
        "<diffuse>0.5 0.5 0.25 1</diffuse><intensity>2</intensity><cast_shadows>true</cast_shadows></light>"
        '<light name="spot" type="spot">'
        "<spot><inner_angle>0.2</inner_angle><outer_angle>0.6</outer_angle></spot></light>"
        '<light name="off" type="point"><light_on>false</light_on></light>'
    )
    assert scene.warnings == ()
    sun, lamp, spot, off = scene.lights
    assert sun.casts_shadows
    assert sun.attenuation == (inf, 1, 0, 0)
    assert lamp.casts_shadows
    assert lamp.attenuation == (7, 1, 1, 0.5)  # linear is 1 where the file says nothing
    assert lamp.diffuse == (1, 1, 0.5, 1)
    assert spot.cone == (0.2, 0.6)
    assert not spot.casts_shadows
    assert off.diffuse[:3] == (0, 0, 0)


@pytest.mark.parametrize(("falloff", "warnings"), [("1", 0), ("0.2", 1)])
def test_a_cone_that_fades_otherwise_than_evenly_is_warned_of(
    world: WorldReader, falloff: str, warnings: int
) -> None:
    scene = world(f'<light name="spot" type="spot"><spot><falloff>{falloff}</falloff></spot></light>')
    assert len(scene.warnings) == warnings
    assert all("<falloff> 0.2 of a <spot> is not simulated" in str(warning) for warning in scene.warnings)


def test_an_unknown_light_is_refused(world: WorldReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'sun'"):
        world('<light name="sun" type="sun"/>')


def test_a_file_of_two_worlds_is_refused(write: Writer, golden: Golden) -> None:
    with golden.raises(SceneError, match="<world>"):
        read_scene(write('<world name="a"/><world name="b"/>'))


# -- the state of a saved world


def test_a_saved_world_has_its_things_where_they_were_last(world: WorldReader) -> None:
    scene = world(
        f'<model name="ball">{LINK}</model><model name="gone">{LINK}</model>'
        '<light name="lamp" type="point"><pose>0 0 1 0 0 0</pose></light>'
        '<state world_name="room"><model name="ball"><pose frame="">1 2 3 0 0 0</pose></model>'
        '<light name="lamp"><pose>0 0 2 0 0 0</pose></light>'
        f'<insertions><model name="new"><pose>4 0 0 0 0 0</pose>{LINK}</model></insertions>'
        "<deletions><name>gone</name></deletions></state>"
    )
    assert {m.name: m.pose.position for m in scene.models} == {"ball": (1, 2, 3), "new": (4, 0, 0)}
    assert scene.lights[0].pose.position == (0, 0, 2)


def test_models_are_as_large_as_they_were_in_a_saved_world(world: WorldReader) -> None:
    """Gazebo saves the shapes without the scale; a round one stays round, and poses stay as they are."""
    shapes = {
        "<box><size>1 2 3</size></box>": Box((2, 6, 12)),
        "<sphere><radius>1</radius></sphere>": Sphere(4),
        "<cylinder><radius>1</radius><length>2</length></cylinder>": Cylinder(3, 8),
        "<plane><normal>0 0 1</normal><size>1 1</size></plane>": Plane((1, 1)),
    }
    parts = "".join(
        f'<collision name="c{i}"><pose>1 0 0 0 0 0</pose><geometry>{shape}</geometry></collision>'
        f'<visual name="v{i}"><geometry>{shape}</geometry></visual>'
        for i, shape in enumerate(shapes)
    )
    model = f'<model name="thing"><static>1</static><link name="l">{parts}</link></model>'
    state = '<state world_name="room"><model name="thing"><scale>{}</scale></model></state>'
    (link,) = world(model + state.format("2 3 4")).models[0].links
    assert [each.geometry for each in link.collisions] == list(shapes.values())
    assert [each.geometry for each in link.visuals] == list(shapes.values())
    assert {each.pose.position for each in link.collisions} == {(1, 0, 0)}
    same, refused = (world(model + state.format(scale)) for scale in ("1 1 1", "0 1 1"))
    assert same.models == refused.models
    assert [len(scene.warnings) for scene in (same, refused)] == [0, 1]


# -- includes


def test_the_models_of_an_included_world_are_included(
    world: WorldReader, tmp_path: Path, golden: Golden
) -> None:
    """A robot's file may bring a floor, as a file in MJCF does; it is left out where one model moves."""
    robot, crate = (f'<model name="{name}">{LINK}</model>' for name in ("robot", "crate"))
    floor = '<model name="floor"><static>1</static><link name="l"/></model>'
    for name, inside in (("robot", floor + robot), ("scenery", floor), ("crates", robot + crate)):
        text = f'<sdf version="1.9"><world name="w">{inside}</world></sdf>'
        (tmp_path / f"{name}.sdf").write_text(text)
    scene = world("<include><uri>robot.sdf</uri><name>second</name><pose>1 0 0 0 0 0</pose></include>")
    assert [(model.name, model.pose.position) for model in scene.models] == [("second", (1, 0, 0))]
    assert "'floor'" in str(scene.warnings[0])
    golden(str(scene.warnings[0]))
    assert [model.name for model in world("<include><uri>scenery.sdf</uri></include>").models] == ["floor"]
    both = world("<include><uri>crates.sdf</uri></include>")
    assert [model.name for model in both.models] == ["robot", "crate"]
    assert not any("left out" in str(warning) for warning in both.warnings)


def test_an_include_of_nothing_is_reported(world: WorldReader, tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "empty.sdf").write_text('<sdf version="1.9"/>')
    scene = world("<include><uri>empty.sdf</uri></include>")
    assert "'empty.sdf'" in str(scene.warnings[0])
    golden(str(scene.warnings[0]))


def test_an_included_model_may_be_renamed_and_moved(world: WorldReader, write: Writer) -> None:
    write(f'<model name="box"><pose>9 9 9 0 0 0</pose>{LINK}</model>', name="box.sdf")
    scene = world(
        "<include><uri>box.sdf</uri></include>"
        "<include><uri>file://box.sdf</uri><name>second</name><pose>1 0 0 0 0 0</pose><static>1</static>"
        "</include>"
    )
    first, second = scene.models
    assert (first.name, first.pose.position, first.static) == ("box", (9, 9, 9), False)
    assert (second.name, second.pose.position, second.static) == ("second", (1, 0, 0), True)


def test_a_model_is_found_by_its_folder(world: WorldReader, write: Writer, tmp_path: Path) -> None:
    write(f'<model name="old">{LINK}</model>', name="models/box/old.sdf")
    write(f'<model name="new">{LINK}</model>', name="models/box/new.sdf")
    (tmp_path / "models/box/model.config").write_text(
        '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.10">new.sdf</sdf></model>'
    )
    include = "<include><uri>model://box</uri></include>"
    assert world(include, search_path=[tmp_path / "models"]).models[0].name == "new"


def test_folders_of_the_environment_are_searched(
    world: WorldReader, write: Writer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(f'<model name="box">{LINK}</model>', name="elsewhere/box/model.sdf")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"/nowhere:{tmp_path / 'elsewhere'}")
    assert world("<include><uri>model://box</uri></include>").models[0].name == "box"


def test_meshes_of_an_included_model_are_found_beside_it(
    world: WorldReader, write: Writer, tmp_path: Path, tetrahedron: Triangles
) -> None:
    mesh = '<visual name="v"><geometry><mesh><uri>model://box/meshes/a.stl</uri></mesh></geometry></visual>'
    write(
        f'<model name="box"><static>1</static><link name="l">{mesh}</link></model>',
        name="models/box/model.sdf",
    )
    (tmp_path / "models/box/meshes").mkdir()
    write_stl(tmp_path / "models/box/meshes/a.stl", tetrahedron)
    scene = world("<include><uri>model://box</uri></include>", search_path=[tmp_path / "models"])
    assert isinstance(scene.visuals["box/l/v"].geometry, Mesh)
    assert scene.warnings == ()


def test_the_ground_and_the_sun_of_gazebo_are_there(world: WorldReader) -> None:
    scene = world(
        "<include><uri>model://ground_plane</uri></include><include><uri>model://sun</uri></include>"
    )
    (ground,), (sun,) = scene.models, scene.lights
    assert ground.static
    assert ground.links[0].collisions[0].geometry == Plane((100, 100))
    assert sun.kind == "directional"
    assert scene.warnings == ()


def test_a_missing_model_is_named_with_the_folders_that_were_searched(
    world: WorldReader, tmp_path: Path, golden: Golden
) -> None:
    with golden.raises(SceneError, match="'model://husky'") as refusal:
        world("\n<include><uri>model://husky</uri></include>")
    assert refusal.value.line == 5
    assert str(tmp_path) in str(refusal.value)


def test_a_lenient_reader_leaves_out_missing_models_and_names_each_once(
    world: WorldReader, write: Writer, golden: Golden
) -> None:
    write(f'<model name="box">{LINK}</model>', name="box.sdf")
    gone = "<include><uri>model://gone</uri><name>{}</name></include>"
    room = f"{gone.format('a')}\n<include><uri>box.sdf</uri></include>\n{gone.format('b')}"
    scene = world(room, lenient=True)
    assert [model.name for model in scene.models] == ["box"]
    (warning,) = scene.warnings
    assert "'model://gone'" in str(warning)
    golden(str(warning))
    with golden.raises(SceneError, match="'model://gone'"):
        world(room)
    around = world(f'<model name="m">{gone.format("a")}</model><model name="n">{LINK}</model>', lenient=True)
    assert [model.name for model in around.models] == ["n"]
    assert [(each.code, each.subject) for each in around.warnings] == [(Code.NRP260, "model://gone")]


def test_includes_of_one_model_without_names_are_counted_as_gazebo_does(
    world: WorldReader, write: Writer, golden: Golden
) -> None:
    write(f'<model name="box">{LINK}</model>', name="box.sdf")
    include = "<include><uri>box.sdf</uri></include>"
    scene = world(f'{include * 2}<model name="box_1">{LINK}</model>{include}')
    assert [model.name for model in scene.models] == ["box", "box_0", "box_1", "box_2"]
    golden(*[warning.message for warning in scene.warnings])


def test_includes_with_one_name_are_counted_as_gazebo_classic_reads_them(
    world: WorldReader, write: Writer
) -> None:
    write(f'<model name="box">{LINK}</model>', name="box.sdf")
    scene = world("<include><uri>box.sdf</uri><name>mine</name></include>" * 2)
    assert [model.name for model in scene.models] == ["mine", "mine_0"]
    assert [warning.code for warning in scene.warnings] == [Code.NRP266]


def test_nothing_is_fetched_from_the_network(world: WorldReader, golden: Golden) -> None:
    with golden.raises(SceneError):
        world("<include><uri>https://fuel.gazebosim.org/1.0/models/sun</uri></include>")


def test_an_include_of_nothing_is_refused(world: WorldReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="<uri>"):
        world("<include><uri/></include>")
    with golden.raises(SceneError):
        world("<include/>")


def test_a_folder_without_a_model_is_refused(world: WorldReader, tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "empty").mkdir()
    with golden.raises(SceneError, match=r"model\.config.*model\.sdf"):
        world("<include><uri>empty</uri></include>")


def test_files_that_include_each_other_are_refused(write: Writer, golden: Golden) -> None:
    write('<model name="a"><include><uri>b.sdf</uri></include></model>', name="a.sdf")
    path = write('<model name="b">\n<include><uri>a.sdf</uri></include></model>', name="b.sdf")
    with golden.raises(SceneError, match=r"b\.sdf -> a\.sdf -> b\.sdf"):
        read_model(path)


def test_an_included_part_is_nested_under_its_name(write: Writer) -> None:
    write(f'<model name="wheel">{LINK}</model>', name="wheel.sdf")
    robot = write(
        '<model name="robot"><link name="body"><inertial/></link>'
        "<include><uri>wheel.sdf</uri><name>left</name><pose>0 1 0 0 0 0</pose></include></model>"
    )
    assert [(part.name, part.pose.position) for part in read_model(robot).links] == [
        ("body", (0, 0, 0)),
        ("left::base", (0, 1, 0)),
    ]


def test_a_merged_part_becomes_the_models_own(write: Writer) -> None:
    write(f'<model name="wheel">{LINK}</model>', name="wheel.sdf")
    robot = write(
        '<model name="robot"><link name="body"><inertial/></link>'
        '<include merge="true"><uri>wheel.sdf</uri><pose>0 1 0 0 0 0</pose></include>'
        '<joint name="j" type="revolute"><parent>body</parent><child>base</child><axis/></joint></model>'
    )
    model = read_model(robot)
    assert [(part.name, part.pose.position) for part in model.links] == [
        ("body", (0, 0, 0)),
        ("base", (0, 1, 0)),
    ]
    assert model.joints[0].child == "base"


# -- files


def test_a_robot_gets_its_id_and_its_place(write: Writer) -> None:
    path = write(f'<model name="husky"><pose>0 0 1 0 0 0</pose>{LINK}</model>')
    assert (read_model(path).name, read_model(path).pose.position) == ("husky", (0, 0, 1))
    robot = read_model(path, name="robot_7", pose=Pose((1, 2, 3)))
    assert (robot.name, robot.pose.position) == ("robot_7", (1, 2, 3))


@pytest.mark.parametrize(("body", "count"), [("", 0), (f'<model name="a">{LINK}</model>' * 2, 2)])
def test_the_file_of_a_robot_holds_one_model(write: Writer, body: str, count: int, golden: Golden) -> None:
    with golden.raises(SceneError, match=f"<model>.*{count}"):
        read_model(write(body))


def test_another_kind_of_xml_is_refused(tmp_path: Path, golden: Golden) -> None:
    path = tmp_path / "robot.xml"
    path.write_text("<COLLADA/>")
    with golden.raises(SceneError, match="SDF.*URDF.*<COLLADA>"):
        read_model(path)


@pytest.mark.parametrize(
    ("version", "known"), [("1.4", True), ("1.12", True), ("1.3", False), ("2.0", False)]
)
def test_versions_that_are_not_known_are_read_with_a_warning(
    write: Writer, version: str, known: bool
) -> None:
    model = read_model(write(f'<model name="a">{LINK}</model>', version=version))
    assert (model.warnings == ()) == known


@pytest.mark.parametrize("version", ["", "one", "1"])
def test_a_file_that_does_not_say_its_version_is_refused(write: Writer, version: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        read_model(write(f'<model name="a">{LINK}</model>', version=version))


# -- unknown elements


def test_an_unknown_element_is_warned_of_once_with_its_first_line(write: Writer, golden: Golden) -> None:
    body = (
        f'<model name="a">\n{LINK}<colour/>\n<colour/>\n<link name="b"><inertial/><colision/></link></model>'
    )
    first, second = read_model(write(body)).warnings
    assert "robot.sdf:4: <colour>" in str(first)
    golden(str(first))
    assert "robot.sdf:6: <colision> is not an element of <link>: ignored; did you mean <collision>?" in str(
        second
    )


def test_elements_of_other_namespaces_are_the_users_own(write: Writer) -> None:
    body = f'<model name="a" xmlns:my="http://my">{LINK}<my:thing><unknown/></my:thing></model>'
    assert read_model(write(body)).warnings == ()


def test_elements_of_the_specification_that_are_not_simulated_cause_a_warning(
    world: WorldReader, golden: Golden
) -> None:
    scene = world(
        '<actor name="x"/><physics><ode><solver/></ode></physics><scene/><gui><camera name="c"/></gui>'
        '<wind><linear_velocity>0 0 0</linear_velocity></wind><model name="a"><link name="base">'
        "<kinematic>1</kinematic><inertial/></link></model>"
    )
    assert len(scene.warnings) == 2
    assert "<actor>" in str(scene.warnings[0])
    golden(str(scene.warnings[0]))
    assert "<kinematic> 1" in str(scene.warnings[1])
    golden(str(scene.warnings[1]))


def test_the_warnings_of_a_robot_join_those_of_the_room(world: WorldReader, write: Writer) -> None:
    scene = world("<unknown/>").with_model(read_model(write(f'<model name="a">{LINK}<unknown/></model>')))
    assert [warning.path.name for warning in scene.warnings if warning.path] == ["room.sdf", "robot.sdf"]


def test_equal_files_have_equal_digests_wherever_they_lie(write: Writer) -> None:
    body = f'<model name="a">{LINK}<unknown/></model>'
    here, there = write(body), write(body, name="other/robot.sdf")
    assert read_scene(here).digest == read_scene(there).digest
    assert read_scene(here).digest != read_scene(write(body.replace('"a"', '"b"'))).digest


@pytest.mark.parametrize("minor", range(4, 13))
def test_one_robot_is_the_same_in_every_version(write: Writer, minor: int) -> None:
    """Written as each version writes it: ``frame`` or ``relative_to``, axes in the model or in the joint."""
    relative = "frame" if minor < 7 else "relative_to"
    axis = "1 0 0" if minor == 4 else "0 1 0"  # the joint is turned by 90 degrees about z
    links = (
        '<link name="base"><inertial><mass>2</mass></inertial></link>'
        f'<link name="arm"><pose {relative}="base">0 0 1 0 0 1.5707963267948966</pose>'
        "<inertial><mass>1</mass></inertial></link>"
    )
    joint = (
        '<joint name="elbow" type="revolute"><parent>base</parent><child>arm</child>'
        f"<axis><xyz>{axis}</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>"
    )
    path = write(f'<model name="robot">{links}{joint}</model>', version=f"1.{minor}")
    robot = read_model(path)
    assert robot.warnings == ()
    assert robot.link("arm").pose.position == (0, 0, 1)
    (elbow,) = robot.joints
    in_model = elbow.pose.rotate(elbow.axis)
    assert in_model == pytest.approx((1, 0, 0) if minor == 4 else (-1, 0, 0))
