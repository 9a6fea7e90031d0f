"""Images of MJCF materials are where MuJoCo 4.0.1 draws them: expected colours are those of its renderer."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden

from nrp_core.scene.sdf import read_scene
from nrp_core.world.backends import worlds

FACES = ("right", "left", "up", "down", "front", "back")
SIDE_PX, FOVY = 200, 53.13010235415598
"""From 4 m a camera sees 4 m."""


def write(path: Path, rows: list[list[tuple[int, int, int]]]) -> Path:
    pixels = np.array(rows, np.uint8).repeat(32, axis=0).repeat(32, axis=1)
    cv2.imwrite(str(path), pixels[..., ::-1])
    return path


def seen(folder: Path, assets: str, geoms: str, camera: str, engine: str = "mujoco"):
    """Return what a camera sees, RGB."""
    (folder / "scene.xml").write_text(
        f"<mujoco><asset>{assets}</asset><worldbody>{geoms}"
        f'<camera {camera} fovy="{FOVY}" resolution="{SIDE_PX} {SIDE_PX}"/></worldbody></mujoco>'
    )
    scene, backend = read_scene(folder / "scene.xml"), worlds().load(engine)
    assert not scene.warnings
    with backend.open(scene, seed=1, options=backend.options()) as world:
        (topic,) = (name for name in world.topics if name.endswith("/image"))
        images = world.subscribe(topic)
        world.run_until(40_000_000)
        image = images.since(-1)[-1].message
        return np.frombuffer(image.data, np.uint8).reshape(SIDE_PX, SIDE_PX, 3)


EYES = {
    "+x": ("3 0 0", "0 1 0 0 0 1", [(0, 3), (0, 1), (0, 4), (0, 2)]),
    "-x": ("-3 0 0", "0 -1 0 0 0 1", [(1, 2), (1, 4), (1, 1), (1, 3)]),
    "+y": ("0 3 0", "-1 0 0 0 0 1", [(2, 4), (2, 3), (2, 2), (2, 1)]),
    "-y": ("0 -3 0", "1 0 0 0 0 1", [(3, 1), (3, 2), (3, 3), (3, 4)]),
    "+z": ("0 0 3", "1 0 0 0 1 0", [(4, 1), (4, 2), (4, 3), (4, 4)]),
    "-z": ("0 0 -3", "1 0 0 0 -1 0", [(5, 4), (5, 3), (5, 2), (5, 1)]),
}
"""Place and axes of a camera; image and quadrant of it that are seen above and below, left and right."""


@pytest.mark.parametrize("shape", ['type="box" size="0.4 0.4 0.4"', 'type="sphere" size="0.5"'])
@pytest.mark.parametrize("eye", EYES)
def test_six_images_are_around_a_shape(tmp_path: Path, eye: str, shape: str) -> None:
    files = ""
    for number, name in enumerate(FACES):
        tl, tr, bl, br = ((60 * quarter, 0, 40 * (number + 1)) for quarter in (1, 2, 3, 4))
        files += f' file{name}="{write(tmp_path / f"{name}.png", [[tl, tr], [bl, br]])}"'
    assets = f'<texture name="t" type="cube"{files}/><material name="m" texture="t"/>'
    place, axes, quarters = EYES[eye]
    image = seen(tmp_path, assets, f'<geom {shape} material="m"/>', f'pos="{place}" xyaxes="{axes}"')
    middle = SIDE_PX // 2
    found = [tuple(image[middle + down, middle + right]) for down in (-6, 6) for right in (-6, 6)]
    assert found == [(60 * quarter, 0, 40 * (face + 1)) for face, quarter in quarters]


BOX, DRUM = 'type="box" size="0.4 0.5 0.3"', 'type="cylinder" size="0.4 0.4"'
FLAT = [
    (BOX, "+x", "RGBW"), (BOX, "-x", "GRWB"), (BOX, "+y", "GRWB"), (BOX, "-y", "RGBW"), (BOX, "+z", "RGBW"),
    (BOX, "-z", "BWRG"), (DRUM, "+z", "BWRG"), (DRUM, "-z", "RGBW"), (DRUM, "+x", "GRWB"),
    (DRUM, "-x", "RGBW"),
]  # fmt: skip
"""Shape, camera, and the quarters of one image that it sees above and below, left and right."""


@pytest.mark.parametrize(("shape", "eye", "quarters"), FLAT)
def test_one_image_is_on_each_side_of_a_shape(tmp_path: Path, shape: str, eye: str, quarters: str) -> None:
    image = write(tmp_path / "quarters.png", [[R, G], [B, W]])
    assets = f'<texture name="t" type="2d" file="{image}"/><material name="m" texture="t"/>'
    place, axes, _ = EYES[eye]
    found = seen(tmp_path, assets, f'<geom {shape} material="m"/>', f'pos="{place}" xyaxes="{axes}"')
    middle, colors = SIDE_PX // 2, {"R": R, "G": G, "B": B, "W": W}
    corners = [tuple(found[middle + down, middle + right]) for down in (-6, 6) for right in (-6, 6)]
    assert corners == [colors[each] for each in quarters]


MESH = (
    '<mesh name="k" vertex="-1 -.5 0 1 -.5 0 1 .5 0 -1 .5 0 0 0 .8" texcoord="0 0 1 0 1 1 0 1 .5 .5" '
    'face="0 1 4 1 2 4 2 3 4 3 0 4"/>'
)
R, G, B, W = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
CASES = {
    "without an end, in metres": ('size="0 0 .1"', "u", [(-1.5, G), (-0.5, R), (0.5, G), (1.5, R)]),
    "without an end": ('size="0 0 .1"', "n", [(-1.83, G), (-1.5, R), (-0.2, R), (0.2, G), (0.5, R)]),
    "in metres": ('size="1.5 1.5 .1"', "u", [(-1.0, B), (0.0, W), (1.0, B)]),
    "of a mesh": (
        'type="mesh" mesh="k"',
        "n",
        [(-0.85, R), (-0.55, G), (-0.2, R), (0.2, G), (0.55, R), (0.85, G)],
    ),
}
"""Shape, material, and colours along x at 0.3 m."""


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize("case", CASES)
def test_an_image_repeats_as_often_as_its_material_says(tmp_path: Path, case: str, engine: str) -> None:
    image = write(tmp_path / "quarters.png", [[R, G], [B, W]])
    assets = (
        f'<texture name="t" type="2d" file="{image}"/><material name="n" texture="t" texrepeat="3 3"/>'
        f'<material name="u" texture="t" texuniform="true" texrepeat="1 1"/>{MESH}'
    )
    shape, material, colors = CASES[case]
    kind = "" if "type" in shape else 'type="plane"'
    found = seen(tmp_path, assets, f'<geom {kind} {shape} material="{material}"/>', 'pos="0 0 4"', engine)
    row, middle = found[SIDE_PX // 2 - 15], SIDE_PX // 2
    assert [(x, tuple(row[middle + round(50 * x)])) for x, _ in colors] == colors


def test_the_colour_of_a_material_tints_its_image(tmp_path: Path) -> None:
    image = write(tmp_path / "quarters.png", [[R, G], [B, W]])
    assets = f'<texture name="t" type="2d" file="{image}"/><material name="m" texture="t" rgba=".8 .4 .2 1"/>'
    found = seen(tmp_path, assets, '<geom type="plane" size="1 1 .1" material="m"/>', 'pos="0 0 4"')
    middle = SIDE_PX // 2
    corners = [tuple(found[middle + down, middle + right]) for down in (-25, 25) for right in (-25, 25)]
    assert corners == [(204, 0, 0), (0, 102, 0), (0, 0, 51), (204, 102, 51)]


def test_a_capsule_has_the_mean_colour_of_a_flat_image_with_a_warning(tmp_path: Path, golden: Golden) -> None:
    image = write(tmp_path / "half.png", [[(200, 100, 0), (0, 100, 0)]])
    (tmp_path / "scene.xml").write_text(
        f'<mujoco><asset><texture name="t" type="2d" file="{image}"/><material name="m" texture="t"/></asset>'
        '<worldbody><geom type="capsule" size=".2 .3" material="m"/></worldbody></mujoco>'
    )
    scene = read_scene(tmp_path / "scene.xml")
    (visual,) = scene.models[0].links[0].visuals
    assert visual.rgba == pytest.approx((100 / 255, 100 / 255, 0.0, 1.0), abs=2e-3)
    (warning,) = scene.warnings
    golden(str(warning))
