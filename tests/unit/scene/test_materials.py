from __future__ import annotations

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.materials import MATERIALS, color_of


@pytest.mark.parametrize(
    ("name", "rgba"),
    [
        ("Gazebo/Red", (1, 0, 0, 1)),
        ("Gazebo/RedGlow", (1, 0, 0, 1)),
        ("Gazebo/BlueGlow", (0, 0, 1, 1)),
        ("Gazebo/Blue", (0, 0, 1, 1)),
        ("Gazebo/Green", (0, 1, 0, 1)),
        ("Gazebo/White", (1, 1, 1, 1)),
        ("Gazebo/Black", (0, 0, 0, 1)),
        ("Gazebo/Grey", (0.7, 0.7, 0.7, 1)),
        ("Gazebo/BlueTransparent", (0, 0, 1, 0.5)),
        ("Gazebo/RedTransparentOverlay", (1, 0, 0, 0.5)),
        ("Gazebo/OrangeTransparent", (1, 0.44, 0, 0.4)),
        ("Gazebo/BlueLaser", (0, 0, 1, 0.4)),
        ("Gazebo/ZincYellow", (0.9725, 0.9529, 0.2078, 1)),
    ],
)
def test_named_materials_have_gazebos_colours(name: str, rgba: tuple[float, ...]) -> None:
    assert MATERIALS[name] == rgba
    assert color_of(name) == rgba


@pytest.mark.parametrize("name", ["red", "RED", "Red", "gazebo/red", "Gazebo/Red", " red "])
def test_a_colour_may_be_named_shortly_in_any_case(name: str) -> None:
    assert color_of(name) == (1, 0, 0, 1)


@pytest.mark.parametrize("name", ["Gazebo/DarkGray", "GrayTransparent", "gray"])
def test_grey_may_be_spelled_in_two_forms(name: str) -> None:
    assert color_of(name) == color_of(name.replace("ray", "rey"))


def test_every_material_is_a_colour() -> None:
    assert "Gazebo/Wood" in MATERIALS
    for rgba in MATERIALS.values():
        assert len(rgba) == 4
        assert all(isinstance(part, float) and 0 <= part <= 1 for part in rgba)


def test_an_unknown_material_gets_a_suggestion(golden: Golden) -> None:
    with golden.raises(SceneError, match="'Gazebo/RedGlowing'.*'redglow'"):
        color_of("Gazebo/RedGlowing")
