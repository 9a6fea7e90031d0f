"""Where files are found: archives, packages of ROS, and what xacro makes of them."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from golden import Golden

from nrp_core import archives
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Box, Mesh
from nrp_core.scene.sdf import read_model, read_scene

SDF = '<sdf version="1.9"><model name="cart"><link name="base"><inertial/>{}</link></model></sdf>'
MESH = '<visual name="skin"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'


@pytest.fixture
def pack(tmp_path: Path) -> Callable[..., Path]:
    """Write an archive of some files."""

    def packed(files: dict[str, bytes | str], name: str = "cart.zip") -> Path:
        with zipfile.ZipFile(tmp_path / name, "w", zipfile.ZIP_DEFLATED) as archive:
            for path, content in files.items():
                archive.writestr(path, content)
        return tmp_path / name

    return packed


Pack = Callable[..., Path]

# -- archives


def test_a_zipped_robot_is_read_with_its_meshes(pack: Pack, tmp_path: Path, tetrahedron: Triangles) -> None:
    write_stl(tmp_path / "a.stl", tetrahedron)
    archive = pack(
        {
            "cart/model.config": '<model><sdf version="1.9">cart.sdf</sdf></model>',
            "cart/cart.sdf": SDF.format(MESH.format("model://cart/meshes/a.stl")),
            "cart/meshes/a.stl": (tmp_path / "a.stl").read_bytes(),
        }
    )
    model = read_model(archive)
    assert model.warnings == ()
    assert isinstance(model.links[0].visuals[0].geometry, Mesh)


def test_an_archive_may_be_flat_and_its_model_of_another_name(
    pack: Pack, tmp_path: Path, tetrahedron: Triangles
) -> None:
    write_stl(tmp_path / "a.stl", tetrahedron)
    sdf = SDF.format(MESH.format("model://wagon/meshes/a.stl"))
    archive = pack({"cart.sdf": sdf, "meshes/a.stl": (tmp_path / "a.stl").read_bytes()})
    assert read_model(archive).warnings == ()


def test_an_archive_may_be_included(pack: Pack, tmp_path: Path) -> None:
    pack({"model.sdf": SDF.format("")})
    room = tmp_path / "room.sdf"
    room.write_text('<sdf version="1.9"><world name="w"><include><uri>cart.zip</uri></include></world></sdf>')
    assert [model.name for model in read_scene(room).models] == ["cart"]


@pytest.mark.parametrize(
    "name", ["../escape.sdf", "a/../../escape.sdf", "/etc/escape.sdf", "C:\\escape.sdf", "..\\escape.sdf"]
)
def test_an_archive_that_would_write_elsewhere_is_refused(
    pack: Pack, name: str, cache: Path, golden: Golden
) -> None:
    with golden.raises(SceneError):
        read_model(pack({"model.sdf": SDF.format(""), name: "x"}))
    assert not list(cache.rglob("escape*"))


def test_a_symbolic_link_in_an_archive_is_refused(pack: Pack, golden: Golden) -> None:
    link = zipfile.ZipInfo("meshes")
    link.external_attr = 0o120777 << 16
    with golden.raises(SceneError):
        read_model(pack({"model.sdf": SDF.format(""), link: "/etc"}))  # type: ignore[dict-item]


def test_a_bomb_is_refused_before_it_is_unpacked(pack: Pack, cache: Path, golden: Golden) -> None:
    with golden.raises(SceneError, match="30 MB"):
        read_model(pack({"model.sdf": SDF.format(""), "zeros": bytes(30_000_000)}))
    assert not list(cache.rglob("zeros"))


def test_an_archive_of_too_much_is_refused(
    pack: Pack, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setattr(archives, "MAX_BYTES", 100)
    with golden.raises(SceneError):
        read_model(pack({"model.sdf": SDF.format("<!-- longer than that -->" * 9)}))


@pytest.mark.parametrize(("content", "message"), [(b"PK nothing", "ZIP"), (b"", "ZIP")])
def test_a_file_that_is_not_an_archive_is_refused(
    tmp_path: Path, content: bytes, message: str, golden: Golden
) -> None:
    (tmp_path / "cart.zip").write_bytes(content)
    with golden.raises(SceneError, match=message):
        read_model(tmp_path / "cart.zip")


def test_a_damaged_archive_is_refused_and_nothing_of_it_kept(pack: Pack, cache: Path, golden: Golden) -> None:
    archive = pack({"damaged.sdf": SDF.format("")})
    content = bytearray(archive.read_bytes())
    content[60] ^= 0xFF
    archive.write_bytes(content)
    with golden.raises(SceneError, match="ZIP"):
        read_model(archive)
    assert not list(cache.rglob("damaged.sdf"))


def test_an_archive_without_a_model_is_refused(pack: Pack, golden: Golden) -> None:
    with golden.raises(SceneError, match="SDF.*URDF"):
        read_model(pack({"readme.txt": "hello"}))


# -- packages


def test_a_package_is_found_above_the_file_that_refers_to_it(tmp_path: Path, tetrahedron: Triangles) -> None:
    for folder in ("cart_description/urdf", "cart_description/meshes"):
        (tmp_path / folder).mkdir(parents=True)
    write_stl(tmp_path / "cart_description/meshes/a.stl", tetrahedron)
    skin = '<visual><geometry><mesh filename="package://cart_description/meshes/a.stl"/></geometry></visual>'
    robot = tmp_path / "cart_description/urdf/cart.urdf"
    robot.write_text(f'<robot name="cart"><link name="base">{MASS}{skin}</link></robot>')
    assert read_model(robot).warnings == ()


def test_the_python_modules_of_a_package_are_not_taken_for_the_package(tmp_path: Path) -> None:
    """As ``ament_python`` makes packages: ``cart/cart/__init__.py`` beside ``cart/urdf``."""
    for folder in ("cart/urdf", "cart/cart"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "cart/package.xml").write_text("<package><name>cart</name></package>")
    head = '<robot name="cart" xmlns:xacro="http://ros.org/wiki/xacro">'
    (tmp_path / "cart/urdf/base.xacro").write_text(f'{head}<link name="base">{MASS}</link></robot>')
    include = '<xacro:include filename="$(find cart)/urdf/base.xacro"/>'
    (tmp_path / "cart/urdf/cart.urdf.xacro").write_text(f"{head}{include}</robot>")
    assert [link.name for link in read_model(tmp_path / "cart/urdf/cart.urdf.xacro").links] == ["base"]


@pytest.mark.parametrize(("variable", "below"), [("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")])
def test_packages_of_ros_are_found(
    tmp_path: Path, tetrahedron: Triangles, monkeypatch: pytest.MonkeyPatch, variable: str, below: str
) -> None:
    meshes = tmp_path / "ros" / below / "wheels" / "meshes"
    meshes.mkdir(parents=True)
    write_stl(meshes / "a.stl", tetrahedron)
    monkeypatch.setenv(variable, str(tmp_path / "ros"))
    robot = tmp_path / "cart.sdf"
    robot.write_text(SDF.format(MESH.format("package://wheels/meshes/a.stl")))
    assert read_model(robot).warnings == ()


@pytest.mark.parametrize(
    ("uri", "place"),
    [
        ("model://gone/meshes/visual/a.stl", "meshes/visual/a.stl"),
        ("model://gone/meshes/visual/a.stl", "a.stl"),
        ("package://gone/dae/a.stl", "meshes/a.stl"),
        ("file:///home/nobody/Models/gone/meshes/a.stl", "meshes/a.stl"),
        ("/home/nobody/Models/gone/meshes/a.stl", "a.stl"),
    ],
)
def test_the_mesh_of_a_missing_package_is_found_beside_the_file(
    tmp_path: Path, tetrahedron: Triangles, uri: str, place: str
) -> None:
    (tmp_path / "cart" / place).parent.mkdir(parents=True)
    write_stl(tmp_path / "cart" / place, tetrahedron)
    robot = tmp_path / "cart" / "model.sdf"
    robot.write_text(SDF.format(MESH.format(uri)))
    assert read_model(robot).warnings == ()


# -- xacro

XACRO = """<robot name="cart" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="{include}"/>
  <xacro:arg name="size" default="2"/>
  <link name="base">{mass}<xacro:skin size="$(arg size)"/></link>
</robot>"""
PARTS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="skin" params="size">
    <visual><geometry><box size="${2 * size} 1 1"/></geometry></visual>
  </xacro:macro>
</robot>"""


@pytest.mark.parametrize("include", ["parts.xacro", "$(find cart_description)/urdf/parts.xacro"])
def test_a_xacro_file_is_expanded(tmp_path: Path, include: str) -> None:
    folder = tmp_path / "cart_description" / "urdf"
    folder.mkdir(parents=True)
    (folder / "parts.xacro").write_text(PARTS)
    (folder / "cart.urdf.xacro").write_text(XACRO.format(include=include, mass=MASS))
    model = read_model(folder / "cart.urdf.xacro")
    assert model.links[0].visuals[0].geometry == Box((4, 1, 1))


def test_substitutions_alone_make_a_xacro_file(tmp_path: Path) -> None:
    robot = tmp_path / "cart.urdf"
    origin = '<inertial><origin xyz="$(optenv CART_CENTRE 0 0 3)"/><mass value="1"/>'
    mass = origin + '<inertia ixx="1" iyy="1" izz="1"/></inertial>'
    robot.write_text(f'<robot name="cart"><link name="base">{mass}</link></robot>')
    inertial = read_model(robot).links[0].inertial
    assert inertial is not None
    assert inertial.pose.position == (0, 0, 3)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("<xacro:nothing/>", "xacro:nothing"),
        ('<xacro:include filename="absent.xacro"/>', "absent.xacro"),
        ('<xacro:include filename="$(find nowhere)/a.xacro"/>', "'nowhere'"),
    ],
)
def test_a_file_that_xacro_cannot_expand_is_one_error(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], body: str, message: str, golden: Golden
) -> None:
    robot = tmp_path / "cart.xacro"
    robot.write_text(f'<robot name="cart" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>')
    with golden.raises(SceneError, match=message) as refusal:
        read_model(robot)
    assert "\n" not in refusal.value.message
    assert capfd.readouterr().err == ""


def test_xacro_files_may_hold_comments_with_hyphens(tmp_path: Path) -> None:
    comment = "<!---- \N{DEGREE SIGN} ----->\n"
    (tmp_path / "parts.xacro").write_text(f"{comment}{PARTS}", encoding="latin-1")
    robot = tmp_path / "cart.xacro"
    robot.write_text(comment + XACRO.format(include="parts.xacro", mass=f"{comment}{MASS}"))
    assert read_model(robot).links[0].visuals[0].geometry == Box((4, 1, 1))


def test_without_xacro_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    robot = tmp_path / "cart.xacro"
    robot.write_text('<robot name="cart" xmlns:xacro="x"><xacro:arg name="a" default="1"/></robot>')
    with golden.raises(SceneError, match=r"'nrp-core\[models\]'"):
        read_model(robot)


# -- Gazebo Fuel


def test_models_of_fuel_are_those_of_gazebos_cache_or_of_folders_with_their_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tetrahedron: Triangles
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    kept = tmp_path / ".gz/fuel/fuel.gazebosim.org/openrobotics/models/blue cart"
    for version in ("2", "10"):
        (kept / version / "meshes").mkdir(parents=True)
        mass = f"<inertial><mass>{version}</mass></inertial>"
        mesh = "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Blue%20Cart/2/files/meshes/a.stl"
        text = SDF.format(MESH.format(mesh)).replace("<inertial/>", mass)
        (kept / version / "model.sdf").write_text(text)
    write_stl(kept / "2/meshes/a.stl", tetrahedron)
    room = tmp_path / "room.sdf"
    uri = "https://fuel.{}.org/1.0/OpenRobotics/models/{}"
    for name, mass in (("Blue Cart", 10), ("Blue Cart/2", 2), ("Blue Cart/tip", 10)):
        include = f"<include><uri>{uri.format('gazebosim', name)}</uri></include>"
        room.write_text(f'<sdf version="1.9"><world name="w">{include}</world></sdf>')
        scene = read_scene(room)
        assert scene.models[0].links[0].inertial.mass == mass
        assert isinstance(scene.models[0].links[0].visuals[0].geometry, Mesh)
    names = ("Ground Plane", "Sun")
    includes = "".join(
        f"<include><uri>{uri.format('ignitionrobotics', name)}</uri></include>" for name in names
    )
    room.write_text(f'<sdf version="1.9"><world name="w">{includes}</world></sdf>')
    assert [model.name for model in read_scene(room).models] == ["ground_plane"]


def test_a_file_that_includes_its_namesake_on_fuel_does_not_include_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "drone").mkdir()
    uri = "https://fuel.gazebosim.org/1.0/someone/models/drone"
    file = tmp_path / "drone" / "model.sdf"
    file.write_text(f'<sdf version="1.9"><include><uri>{uri}</uri></include></sdf>')
    with golden.raises(SceneError, match=f"'{uri}'"):
        read_model(file, search_path=[tmp_path])
    kept = tmp_path / ".gz/fuel/fuel.gazebosim.org/someone/models/drone/1"
    kept.mkdir(parents=True)
    (kept / "model.sdf").write_text(SDF.format(""))
    assert read_model(file, search_path=[tmp_path]).name == "cart"
