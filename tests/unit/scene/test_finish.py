"""How SDF's materials shine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from nrp_core.scene.model import Finish, Model, Visual

RED = "<diffuse>1 0 0 1</diffuse>"


@pytest.fixture
def shown(model: Callable[..., Model]) -> Callable[[str], tuple[Visual, tuple[str, ...]]]:
    """Read the contents of a <material>; return the visual and the warnings."""

    def shown(material: str) -> tuple[Visual, tuple[str, ...]]:
        box = "<geometry><box><size>1 1 1</size></box></geometry>"
        visual = f'<visual name="v"><material>{material}</material>{box}</visual>'
        read = model(f'<static>1</static><link name="base">{visual}</link>')
        return read.links[0].visuals[0], read.warnings

    return shown


@pytest.mark.parametrize(
    ("material", "finish"),
    [
        ("", None),
        ("<specular>0 0 0 1</specular><shininess>20</shininess>", None),
        ("<pbr><metal/></pbr>", Finish(0.5, 0.5)),
        ("<pbr><metal><roughness>0.2</roughness><metalness>1</metalness></metal></pbr>", Finish(0.2, 1.0)),
        ("<pbr><specular/></pbr>", Finish(1.0)),
        (
            "<specular>0.1 0.2 0.3 1</specular><pbr><specular><glossiness>0.75</glossiness></specular></pbr>",
            Finish(0.25, 0.0, (0.1, 0.2, 0.3)),
        ),
        (
            "<specular>0.5 0.5 0.5 1</specular><shininess>30</shininess>",
            Finish(0.5, 0.0, (0.04, 0.04, 0.04)),
        ),
        ("<specular>1 1 1 1</specular>", Finish(1.0, 0.0, (0.08, 0.08, 0.08))),
    ],
)
def test_a_finish_follows_from_the_material(shown, material: str, finish: Finish | None) -> None:
    visual, warnings = shown(RED + material)
    assert visual.finish == finish
    assert visual.rgba == (1, 0, 0, 1)
    assert warnings == ()


@pytest.fixture
def images(tmp_path: Path) -> None:
    for name, bgr in (("half.png", (128, 128, 128)), ("blue.png", (255, 0, 0))):
        cv2.imwrite(str(tmp_path / name), np.full((2, 2, 3), bgr, np.uint8))


@pytest.mark.usefixtures("images")
def test_a_map_counts_as_its_mean_and_instead_of_the_number_that_it_varies(shown) -> None:
    maps = "<roughness_map>half.png</roughness_map><metalness_map>half.png</metalness_map>"
    numbers = "<roughness>0.1</roughness><metalness>0.1</metalness>"
    albedo = "<albedo_map>blue.png</albedo_map>"
    visual, warnings = shown(f"<pbr><metal>{maps}{numbers}{albedo}</metal></pbr>")
    assert visual.finish == Finish(128 / 255, 128 / 255)
    assert visual.rgba == (0, 0, 1, 1)
    assert warnings == ()
    grey, _ = shown(f"<diffuse>0.5 0.5 0.5 0.5</diffuse><pbr><specular>{albedo}</specular></pbr>")
    assert grey.rgba == (0, 0, 0.5, 0.5)


@pytest.mark.usefixtures("images")
def test_a_map_of_reflectance_wins_over_the_colour(shown) -> None:
    specular = "<specular><specular_map>blue.png</specular_map></specular>"
    visual, _ = shown(f"<specular>1 1 1 1</specular><pbr>{specular}</pbr>")
    assert visual.finish == Finish(1.0, 0.0, (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("metal", "warning"),
    [
        ("<roughness>2</roughness>", "<roughness> must be from 0 to 1, not 2: 1 is used"),
        ("<metalness>-1</metalness>", "<metalness> must be from 0 to 1, not -1: 0 is used"),
        ("<albedo_map>gone.png</albedo_map>", "the image 'gone.png' is not there: left out"),
        ("<albedo_map>robot.sdf</albedo_map>", "the image 'robot.sdf' cannot be read: left out"),
        ("<normal_map>n.png</normal_map>", "<normal_map> n.png of a <metal> is not simulated"),
        (
            "<rougness>1</rougness>",
            "<rougness> is not an element of <metal>: ignored; did you mean <roughness>?",
        ),
    ],
)
def test_an_element_without_effect_is_reported_with_its_place(shown, metal: str, warning: str) -> None:
    _, (told,) = shown(f"{RED}<pbr><metal>{metal}</metal></pbr>")
    assert str(told.as_error()).endswith(f"robot.sdf:4: {warning}")


def test_a_finish_is_part_of_the_digest_of_a_scene(shown) -> None:
    one, other = (shown(f"<pbr><metal><roughness>{r}</roughness></metal></pbr>")[0] for r in (0.1, 0.2))
    assert repr(one) != repr(other)
