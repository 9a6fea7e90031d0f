"""A robot in a ROS workspace finds the packages of the workspace, without ROS and its variables."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.sdf import read_model

MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
CART = """<robot name="cart" xmlns:xacro="x"><xacro:include filename="$(find wheels)/urdf/wheel.xacro"/>
<link name="base">{mass}<xacro:wheel/></link></robot>"""
WHEEL = """<robot xmlns:xacro="x"><xacro:macro name="wheel">
<visual><geometry><mesh filename="package://{package}/meshes/wheel.stl"/></geometry></visual>
</xacro:macro></robot>"""


def package(folder: Path, name: str, files: dict[str, str]) -> None:
    """Write a package of ROS."""
    for path, text in {"package.xml": f"<package><name>{name}</name></package>", **files}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)


@pytest.mark.parametrize(
    ("cart", "wheels"),
    [
        ("src/cart_ros/cart", "src/parts/wheels"),  # the sources of colcon and catkin
        ("src/cart", "src/vendor/parts/wheels_2"),  # a folder of another name, deeper
        ("carts/cart", "carts/wheels"),  # a repository without a workspace
        ("install/cart/share/cart", "install/wheels/share/wheels"),  # colcon
        ("install/share/cart", "install/share/wheels"),  # catkin, and colcon --merge-install
    ],
)
def test_a_package_of_the_same_workspace_is_found(
    tmp_path: Path, tetrahedron: Triangles, cart: str, wheels: str
) -> None:
    package(tmp_path / cart, "cart", {"urdf/cart.xacro": CART.format(mass=MASS)})
    package(tmp_path / wheels, "wheels", {"urdf/wheel.xacro": WHEEL.format(package="wheels")})
    (tmp_path / wheels / "meshes").mkdir()
    write_stl(tmp_path / wheels / "meshes/wheel.stl", tetrahedron)
    model = read_model(tmp_path / cart / "urdf/cart.xacro")
    assert [len(link.visuals) for link in model.links] == [1]
    assert model.warnings == ()


def test_a_package_without_a_name_is_that_of_the_file(tmp_path: Path, tetrahedron: Triangles) -> None:
    skin = '<visual><geometry><mesh filename="package:///meshes/a.stl"/></geometry></visual>'
    robot = f'<robot name="cart"><link name="base">{MASS}{skin}</link></robot>'
    package(tmp_path / "cart", "cart", {"urdf/real/cart.urdf": robot})
    (tmp_path / "cart/meshes").mkdir()
    write_stl(tmp_path / "cart/meshes/a.stl", tetrahedron)
    assert read_model(tmp_path / "cart/urdf/real/cart.urdf").warnings == ()


def test_a_package_of_another_workspace_is_not_found(tmp_path: Path, golden: Golden) -> None:
    package(tmp_path / "one/src/cart", "cart", {"urdf/cart.xacro": CART.format(mass=MASS)})
    package(tmp_path / "two/src/wheels", "wheels", {"urdf/wheel.xacro": WHEEL.format(package="wheels")})
    with golden.raises(SceneError, match="'wheels'"):
        read_model(tmp_path / "one/src/cart/urdf/cart.xacro")
