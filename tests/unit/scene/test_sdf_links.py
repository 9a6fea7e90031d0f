from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.inertia import LEAST_MOMENT
from nrp_core.scene.meshes.stl import read_stl, write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import (
    DEFAULT_RGBA,
    Box,
    Capsule,
    Cylinder,
    Inertial,
    Link,
    Mesh,
    Model,
    Plane,
    Sphere,
)
from nrp_core.scene.rigid import Pose

LinkReader = Callable[[str], Link]
ModelReader = Callable[..., Model]

BOX = "<geometry><box><size>1 2 3</size></box></geometry>"
UNIT_MASS = "<inertial><mass>1</mass></inertial>"


def visual(inside: str, geometry: str = BOX) -> str:
    return f'<visual name="skin">{inside}{geometry}</visual>'


def collision(inside: str, geometry: str = BOX) -> str:
    return f'<collision name="hull">{inside}{geometry}</collision>'


@pytest.mark.parametrize(
    ("shape", "geometry"),
    [
        ("<box><size>1 2 3</size></box>", Box((1, 2, 3))),
        ("<sphere><radius>2</radius></sphere>", Sphere(2)),
        ("<cylinder><radius>1</radius><length>2</length></cylinder>", Cylinder(1, 2)),
        ("<capsule><radius>1</radius><length>2</length></capsule>", Capsule(1, 2)),
        ("<plane><normal>0 0 1</normal><size>5 6</size></plane>", Plane((5, 6))),
        ("<plane/>", Plane((100, 100))),
    ],
)
def test_shapes_are_read(link: LinkReader, shape: str, geometry: object) -> None:
    read = link(visual("", f"<geometry>{shape}</geometry>") + collision("", f"<geometry>{shape}</geometry>"))
    assert read.visuals[0].geometry == geometry
    assert read.collisions[0].geometry == geometry


def test_a_plane_faces_along_its_normal(link: LinkReader) -> None:
    wall = link(collision("", "<geometry><plane><normal>2 0 0</normal></plane></geometry>")).collisions[0]
    assert wall.pose.rotate((0.0, 0.0, 1.0)) == pytest.approx((1, 0, 0))


@pytest.mark.parametrize(
    "shape",
    [
        "<box><size>1 0 3</size></box>",
        "<box><size>1 -2 3</size></box>",
        "<sphere><radius>-1</radius></sphere>",
        "<cylinder><radius>1</radius><length>-2</length></cylinder>",
        "<plane><size>0 1</size></plane>",
        "<cube><size>1 2 3</size></cube>",
        "<mesh/>",
    ],
)
def test_a_shape_without_a_size_is_one_error_at_its_line(link: LinkReader, shape: str) -> None:
    with pytest.raises(SceneError) as refusal:
        link(visual("", f"\n<geometry>{shape}</geometry>"))
    assert refusal.value.line == 6
    assert refusal.value.path is not None


def test_an_empty_geometry_yields_neither_a_shape_nor_a_warning(model: ModelReader) -> None:
    empty = "<geometry><empty/></geometry>"
    read = model(f'<link name="base">{UNIT_MASS}{visual("", empty)}{collision("", empty)}</link>')
    assert (read.links[0].visuals, read.links[0].collisions, read.warnings) == ((), (), ())


def test_a_geometry_without_a_shape_is_left_out_with_a_warning(model: ModelReader, golden: Golden) -> None:
    read = model(f'<link name="base">{UNIT_MASS}{visual("", "<geometry/>")}</link>')
    assert read.links[0].visuals == ()
    assert "<geometry>" in str(read.warnings[0])
    golden(str(read.warnings[0]))


@pytest.mark.parametrize("part", [visual, collision])
def test_parts_with_one_name_are_renamed_with_a_warning(
    model: ModelReader, part: Callable[[str], str], golden: Golden
) -> None:
    read = model(f'<link name="base">{UNIT_MASS}\n{part("")}\n{part("")}\n{part("")}</link>')
    parts = read.links[0].visuals or read.links[0].collisions
    name = parts[0].name
    assert [p.name for p in parts] == [name, f"{name}_2", f"{name}_3"]
    assert "robot.sdf:6" in str(read.warnings[0])
    golden(str(read.warnings[0]))
    assert f"named '{name}': this one is renamed '{name}_2'" in str(read.warnings[0])


def test_a_visual_and_a_collision_may_share_a_name(link: LinkReader) -> None:
    assert link(visual("") + collision("").replace("hull", "skin")).collisions[0].name == "skin"


# -- colours


@pytest.mark.parametrize(
    ("material", "rgba"),
    [
        ("", DEFAULT_RGBA),
        ("<material/>", DEFAULT_RGBA),
        ("<material><diffuse>0.1 0.2 0.3 0.5</diffuse></material>", (0.1, 0.2, 0.3, 0.5)),
        ("<material><diffuse>0.1 0.2 0.3</diffuse></material>", (0.1, 0.2, 0.3, 1)),
        ("<material><ambient>0.1 0.2 0.3 1</ambient></material>", (0.1, 0.2, 0.3, 1)),
        (
            "<material><ambient>1 1 1 1</ambient><diffuse>0.1 0.2 0.3 1</diffuse></material>",
            (0.1, 0.2, 0.3, 1),
        ),
        ("<material><diffuse>0 0 0 1</diffuse><emissive>1 0 0 1</emissive></material>", (1, 0, 0, 1)),
        ("<material><diffuse>0 1 0 1</diffuse><emissive>0 0 0 1</emissive></material>", (0, 1, 0, 1)),
        ("<material><script><name>Gazebo/BlueGlow</name></script></material>", (0, 0, 1, 1)),
        (
            "<material><script><uri>file://x</uri><name>Gazebo/Red</name></script>"
            "<ambient>1 1 1 1</ambient></material>",
            (1, 0, 0, 1),
        ),
        ("<transparency>0.25</transparency><material><diffuse>0 1 0 1</diffuse></material>", (0, 1, 0, 0.75)),
    ],
)
def test_the_colour_is_what_glows_else_what_is_lit(
    link: LinkReader, material: str, rgba: tuple[float, ...]
) -> None:
    assert link(visual(material)).visuals[0].rgba == pytest.approx(rgba)


@pytest.mark.parametrize(
    ("material", "glows"),
    [
        ("<diffuse>1 0 0 1</diffuse><emissive>1 0 0 1</emissive>", True),
        ("<diffuse>1 0 0 1</diffuse><emissive>0 0 0 1</emissive>", False),
        ("<script><name>Gazebo/BlueGlow</name></script>", True),
        ("<script><name>Gazebo/Blue</name></script>", False),
        ("<script>Gazebo/BlueGlow</script>", True),
        ("", False),
    ],
)
def test_emissive_and_lit_colours_are_distinguished(link: LinkReader, material: str, glows: bool) -> None:
    assert link(visual(f"<material>{material}</material>")).visuals[0].glows is glows


def test_an_unknown_material_is_grey_with_a_warning(model: ModelReader, golden: Golden) -> None:
    script = "<material><script><name>Gazebo/Rad</name></script></material>"
    read = model(f'<link name="base">{UNIT_MASS}{visual(script)}</link>')
    assert read.links[0].visuals[0].rgba == DEFAULT_RGBA
    assert len(read.warnings) == 1
    assert "'Gazebo/Rad'" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_colours_outside_0_to_1_are_255ths_with_a_warning(model: ModelReader, golden: Golden) -> None:
    colored = visual("<material><diffuse>255 51 0.5 -1</diffuse></material>")
    read = model(f'<link name="base">{UNIT_MASS}{colored}</link>')
    assert read.links[0].visuals[0].rgba == (1, 0.2, 0.5, 0)
    assert "robot.sdf:4: <diffuse>" in str(read.warnings[0])
    golden(str(read.warnings[0]))


# -- friction


def surface(friction: str) -> str:
    return collision(f"<surface><friction>{friction}</friction></surface>")


@pytest.mark.parametrize(
    ("friction", "mu"),
    [
        ("", 1.0),
        ("<ode/>", 1.0),
        ("<ode><mu>0.3</mu></ode>", 0.3),
        ("<ode><mu>0.3</mu><mu2>0.3</mu2></ode>", 0.3),
        ("<bullet><friction>0.4</friction></bullet>", 0.4),
        ("<ode><mu>0</mu></ode>", 0.0),
    ],
)
def test_friction_is_coulombs_coefficient(model: ModelReader, friction: str, mu: float) -> None:
    read = model(f'<link name="base">{UNIT_MASS}{surface(friction)}</link>')
    assert read.links[0].collisions[0].friction == mu
    assert read.warnings == ()


@pytest.mark.parametrize("mu", ["100000.0", "-1", "1e30"])
def test_a_friction_that_no_material_has_becomes_1_with_one_warning(
    model: ModelReader, mu: str, golden: Golden
) -> None:
    wheels = "".join(
        f'<link name="{name}">{UNIT_MASS}\n{surface(f"<ode><mu>{mu}</mu><mu2>{mu}</mu2></ode>")}</link>'
        for name in ("left", "right")
    )
    read = model(wheels)
    assert [link.collisions[0].friction for link in read.links] == [1, 1]
    assert len(read.warnings) == 1
    assert f"robot.sdf:5: a friction coefficient of {float(mu):g} means 'never slips'" in str(
        read.warnings[0]
    )
    golden(str(read.warnings[0]))


def test_friction_that_depends_on_direction_is_warned_of(model: ModelReader) -> None:
    read = model(f'<link name="base">{UNIT_MASS}{surface("<ode><mu>0.8</mu><mu2>0.2</mu2></ode>")}</link>')
    assert read.links[0].collisions[0].friction == 0.8
    assert "mu = 0.8, not mu2 = 0.2" in str(read.warnings[0])


# -- masses


def test_mass_properties_are_read_as_they_stand(link: LinkReader) -> None:
    read = link(
        "<inertial><mass>2</mass><pose>1 2 3 0 0 0</pose><inertia><ixx>4</ixx><iyy>5</iyy><izz>6</izz>"
        "<ixy>0.1</ixy><ixz>0.2</ixz><iyz>0.3</iyz></inertia></inertial>"
    )
    assert read.inertial == Inertial(2, Pose((1, 2, 3)), (4, 5, 6, 0.1, 0.2, 0.3))


def test_omitted_values_of_an_inertial_have_the_defaults_of_the_specification(link: LinkReader) -> None:
    assert link("<inertial/>").inertial == Inertial(1, Pose(), (1, 1, 1, 0, 0, 0))


def test_a_link_without_inertial_weighs_what_its_shapes_do(model: ModelReader, golden: Golden) -> None:
    read = model(f'<link name="base">\n{collision("<pose>0 0 1 0 0 0</pose>")}</link>')
    inertial = read.links[0].inertial
    assert inertial is not None
    assert inertial.mass == pytest.approx(6000)
    assert inertial.pose.position == pytest.approx((0, 0, 1))
    assert inertial.inertia == pytest.approx((6500, 5000, 2500, 0, 0, 0))
    (warning,) = read.warnings
    golden(warning.message)
    assert (warning.code, warning.line, warning.subject) == (Code.NRP384, 4, "base")


@pytest.mark.parametrize(
    ("body", "mass"),
    [
        (f'<inertial auto="true"/>{collision("")}', 6000),
        (f'<inertial auto="true"><density>10</density></inertial>{collision("")}', 60),
        (f'<inertial auto="true"/>{collision("<density>20</density>")}', 120),
    ],
)
def test_an_automatic_inertial_is_computed_without_a_warning(
    model: ModelReader, body: str, mass: float
) -> None:
    read = model(f'<link name="base">{body}</link>', version="1.11")
    assert read.links[0].inertial is not None
    assert read.links[0].inertial.mass == pytest.approx(mass)
    assert read.warnings == ()


def test_a_mass_of_0_is_computed_instead_with_a_warning(model: ModelReader, golden: Golden) -> None:
    read = model(f'<link name="base">\n<inertial><mass>0</mass></inertial>{collision("")}</link>')
    assert read.links[0].inertial is not None
    assert read.links[0].inertial.mass == pytest.approx(6000)
    assert "robot.sdf:5" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_a_negative_mass_is_refused(link: LinkReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'base'.*-1"):
        link("<inertial><mass>-1</mass></inertial>")


def test_an_inertia_that_no_body_has_is_repaired_with_a_warning(model: ModelReader, golden: Golden) -> None:
    inertia = "<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>1</izz></inertia>"
    read = model(f'<link name="base">\n<inertial><mass>1</mass>{inertia}</inertial></link>')
    inertial = read.links[0].inertial
    assert inertial is not None
    assert inertial.inertia[0] + inertial.inertia[1] >= inertial.inertia[2]
    assert "robot.sdf:5: the inertia of the link 'base' is repaired to 0.501, 0.501, 1" in str(
        read.warnings[0]
    )
    golden(str(read.warnings[0]))


def test_a_link_that_moves_and_has_nothing_to_weigh_gets_sdfs_kilogram(
    model: ModelReader, golden: Golden
) -> None:
    read = model('<link name="base"/>')
    assert read.links[0].inertial == Inertial(1.0)
    assert "SDF's" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_a_link_fixed_to_a_heavy_one_needs_no_mass(model: ModelReader) -> None:
    read = model(
        f'<link name="base">{UNIT_MASS}</link><link name="lens"/>'
        '<joint name="j" type="fixed"><parent>base</parent><child>lens</child></joint>'
    )
    assert read.link("lens").inertial is None
    assert read.warnings == ()


def test_a_static_model_needs_no_mass(model: ModelReader) -> None:
    read = model(f'<static>true</static><link name="base">{collision("")}</link>')
    assert read.static
    assert read.links[0].inertial is None
    assert read.warnings == ()


# -- meshes

MISSING = "<geometry><mesh><uri>model://husky/meshes/body.dae</uri></mesh></geometry>"


def test_a_mesh_beside_the_file_is_kept(model: ModelReader, tmp_path: Path, tetrahedron: Triangles) -> None:
    write_stl(tmp_path / "body.STL", tetrahedron)
    mesh = "<geometry><mesh><uri>body.STL</uri><scale>2 2 -2</scale></mesh></geometry>"
    read = model(f'<link name="base">{UNIT_MASS}{visual("", mesh)}</link>')
    kept = read.links[0].visuals[0].geometry
    assert isinstance(kept, Mesh)
    assert kept.scale == (2, 2, -2)
    assert read_stl(kept.path).tolist() == tetrahedron.tolist()
    assert read.warnings == ()


def test_a_missing_mesh_is_drawn_as_the_collision(model: ModelReader) -> None:
    pose = "<pose>0 0 1 0 0 0</pose>"
    read = model(f'<link name="base">{UNIT_MASS}\n{visual("", MISSING)}{collision(pose)}</link>')
    (skin,) = read.links[0].visuals
    assert (skin.name, skin.geometry, skin.pose) == ("skin", Box((1, 2, 3)), Pose((0, 0, 1)))
    (warning,) = read.warnings
    assert (warning.code, warning.line, warning.subject) == (Code.NRP258, 5, "husky")


def test_without_a_simple_collision_it_is_the_box_with_the_inertia(model: ModelReader) -> None:
    inertia = "<inertia><ixx>13000</ixx><iyy>10000</iyy><izz>5000</izz></inertia>"  # of 12 t, 1 x 2 x 3 m
    inertial = f"<inertial><mass>12000</mass><pose>0 0 1 0 0 0</pose>{inertia}</inertial>"
    read = model(f'<link name="base">{inertial}{visual("", MISSING)}{collision("", MISSING)}</link>')
    (skin,), (hull,) = read.links[0].visuals, read.links[0].collisions
    assert skin.geometry == hull.geometry
    assert isinstance(hull.geometry, Box)
    assert hull.geometry.size == pytest.approx((1, 2, 3))
    assert hull.pose == Pose((0, 0, 1))
    (warning,) = read.warnings
    assert (warning.code, warning.count) == (Code.NRP258, 2)
    assert warning.text.endswith("(and 1 more)")


@pytest.mark.parametrize("name", ["body.fbx", "body.STEP"])
def test_a_kind_of_mesh_that_is_not_read_counts_as_missing(
    model: ModelReader, tmp_path: Path, name: str, golden: Golden
) -> None:
    (tmp_path / name).touch()
    mesh = f"<geometry><mesh><uri>{name}</uri></mesh></geometry>"
    read = model(f'<link name="base">{UNIT_MASS}{visual("", mesh)}{collision("")}</link>')
    assert read.links[0].visuals[0].geometry == Box((1, 2, 3))
    golden(str(read.warnings[0]))


def test_a_huge_mesh_is_not_opened(model: ModelReader, tmp_path: Path, golden: Golden) -> None:
    with (tmp_path / "body.stl").open("wb") as huge:
        huge.truncate(1_000_000_000)
    mesh = "<geometry><mesh><uri>body.stl</uri></mesh></geometry>"
    read = model(f'<link name="base">{UNIT_MASS}{visual("", mesh)}{collision("")}</link>')
    assert read.links[0].visuals[0].geometry == Box((1, 2, 3))
    assert "200 MB" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_cones_and_ellipsoids_are_meshes_of_their_size(link: LinkReader) -> None:
    cone = "<geometry><cone><radius>1</radius><length>2</length></cone></geometry>"
    egg = "<geometry><ellipsoid><radii>1 2 3</radii></ellipsoid></geometry>"
    sizes = []
    for shape in (cone, egg):
        collided = link(collision("", shape)).collisions[0].geometry
        assert isinstance(collided, Mesh)
        corners = read_stl(collided.path).reshape(-1, 3) * collided.scale
        sizes.append(np.ptp(corners, axis=0).tolist())
    assert np.array(sizes) == pytest.approx(np.array([[2, 2, 2], [2, 4, 6]]), rel=0.01)


def test_a_shape_that_is_not_read_is_replaced_with_a_warning(model: ModelReader, golden: Golden) -> None:
    hills = "<geometry><image><uri>hills.png</uri></image></geometry>"
    read = model(f'<link name="base">{UNIT_MASS}{visual("", hills)}{collision("")}</link>')
    assert read.links[0].visuals[0].geometry == Box((1, 2, 3))
    assert "<image>" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_a_robot_without_inertials_is_one_line_with_its_mass(model: ModelReader, golden: Golden) -> None:
    joint = '<joint name="j" type="fixed"><parent>base</parent><child>top</child></joint>'
    read = model(f'<link name="base">{collision("")}</link><link name="top">{collision("")}</link>{joint}')
    (warning,) = read.warnings
    assert sum(link.inertial.mass for link in read.links if link.inertial) == pytest.approx(12_000)
    golden(warning.message)
    assert "1.2e+04 kg" in warning.message


NO_INERTIA = "<inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia>"
SMALL = "<cylinder><radius>1e-6</radius><length>1e-6</length></cylinder>"
MICROMETRE = f"<collision name='c'><geometry>{SMALL}</geometry></collision>"


@pytest.mark.parametrize(
    ("body", "mass"),
    [
        ("<inertial><mass>4e-15</mass></inertial>" + collision(""), 1e-12),
        (f"<inertial><mass>1e-3</mass>{NO_INERTIA}</inertial>{MICROMETRE}", 1e-3),
    ],
)  # fmt: skip
def test_negligible_masses_and_inertias_are_large_enough_for_engines(
    model: ModelReader, body: str, mass: float
) -> None:
    inertial = model(f'<link name="base">{body}</link>').links[0].inertial
    assert inertial is not None
    assert inertial.mass == mass
    assert min(inertial.inertia[:3]) >= LEAST_MOMENT


def test_meshes_of_a_missing_package_are_one_line(model: ModelReader) -> None:
    meshes = "".join(
        f'<visual name="v{n}"><geometry><mesh><uri>package://nowhere/{n}.stl</uri></mesh></geometry></visual>'
        for n in range(3)
    )
    read = model(f'<link name="base"><inertial/>{meshes}</link>')
    assert [(one.code, one.subject, one.count) for one in read.warnings] == [(Code.NRP258, "nowhere", 3)]
