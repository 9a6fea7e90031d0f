"""Colours of the material scripts that models bring along."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from nrp_core.scene.model import Model, Rgba
from nrp_core.scene.sdf import read_model
from nrp_core.scene.sdf.appearance import Material, script_material

SCRIPT = """
// a comment with material Lab/Fake { diffuse 1 1 1 1 }
material Lab/Steel
{
  technique
  {
    pass { }
    pass main
    {
      ambient 0.1 0.1 0.1 1
      diffuse .3 .4 .5 1.0
      specular 0.01 0.01 0.01 1.0 1.5
    }
  }
}
material Lab/Lamp : Lab/Steel
{
  technique { pass {
      diffuse 0 0 0 1
      emissive 0 1 0
  } }
}
/* material Lab/Gone
{ diffuse 1 1 1
} */
material Lab/Poster
{ technique { pass {
      diffuse 1 1 1 1
      texture_unit
      {
        texture poster.png
      }
} } }
material Lab/Nothing
{ technique { pass { lighting off
} } }
"""


@pytest.fixture
def scripts(tmp_path: Path) -> Path:
    folder = tmp_path / "thing" / "materials" / "scripts"
    folder.mkdir(parents=True)
    (folder / "lab.material").write_text(SCRIPT)
    (folder.parent / "textures").mkdir()
    blue = np.full((2, 2, 3), (255, 0, 0), np.uint8)  # as OpenCV has it
    (folder.parent / "textures" / "poster.png").write_bytes(cv2.imencode(".png", blue)[1].tobytes())
    return folder


@pytest.mark.parametrize(
    ("name", "rgba"),
    [
        ("Lab/Steel", (0.3, 0.4, 0.5, 1)),
        ("Lab/Lamp", (0, 1, 0, 1)),
        ("Lab/Poster", (0, 0, 1, 1)),
        ("Lab/Nothing", None),
        ("Lab/Fake", None),
        ("Lab/Gone", None),
        ("Lab", None),
    ],
)
def test_the_colour_is_what_glows_else_the_image_else_what_is_lit(
    scripts: Path, name: str, rgba: Rgba | None
) -> None:
    image = scripts.parent / "textures" / "poster.png" if name == "Lab/Poster" else None
    color = rgba and Material(rgba, name == "Lab/Lamp", image)
    assert script_material(name, [scripts]) == color
    assert script_material(name, [scripts / "lab.material"]) == color


def test_a_missing_image_leaves_what_is_lit(scripts: Path) -> None:
    (scripts.parent / "textures" / "poster.png").unlink()
    assert script_material("Lab/Poster", [scripts]) == Material((1, 1, 1, 1))


@pytest.mark.parametrize(
    "content", [b"", b"material", b"material a\n{ diffuse x y z", b"\xff\xfe\x00", b"/*"]
)
def test_a_damaged_script_is_printed_without_colour(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.material").write_bytes(content)
    assert script_material("a", [tmp_path]) is None


def visual(name: str, uri: str) -> str:
    script = f"<material><script><uri>{uri}</uri><name>{name}</name></script></material>"
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    return f'<link name="base"><inertial/><visual name="v">{script}{box}</visual></link>'


def test_a_model_shows_its_own_material(scripts: Path, tmp_path: Path) -> None:
    robot = tmp_path / "thing" / "model.sdf"
    body = visual("Lab/Steel", "model://thing/materials/scripts")
    robot.write_text(f'<sdf version="1.6"><model name="thing">{body}</model></sdf>')
    model = read_model(robot)
    assert model.links[0].visuals[0].rgba == (0.3, 0.4, 0.5, 1)
    assert model.warnings == ()


def test_gazebos_materials_need_no_script(model: Callable[..., Model]) -> None:
    read = model(visual("Gazebo/Red", "file://media/materials/scripts/gazebo.material"))
    assert read.links[0].visuals[0].rgba == (1, 0, 0, 1)
    assert read.warnings == ()
