"""Cameras with a ``<visibility_mask>`` see the visuals whose ``<visibility_flags>`` share a bit with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.sdf import read_scene

BOX = """<visual name="v{0}"><pose>2 {1} 0 0 0 0</pose><geometry><box><size>0.1 1 2</size></box></geometry>
  <visibility_flags>{0}</visibility_flags><material><emissive>{2} 1</emissive></material></visual>"""
CAMERA = """<sensor name="s{0}" type="rgbd_camera"><update_rate>50</update_rate><topic>s{0}</topic><camera>
  <image><width>16</width><height>16</height></image><visibility_mask>{0}</visibility_mask></camera></sensor>"""


def room(folder: Path, *masks: str) -> Path:
    boxes = BOX.format("0x1", 0.5, "1 0 0") + BOX.format("2", -0.5, "0 1 0")
    cameras = "".join(map(CAMERA.format, masks))
    path = folder / "room.sdf"
    path.write_text(
        '<sdf version="1.9"><world name="w"><model name="m"><static>1</static>'
        f'<link name="l">{boxes}{cameras}</link></model></world></sdf>'
    )
    return path


@pytest.mark.parametrize("renderer", ["raster", "realistic"])
def test_a_camera_sees_what_its_mask_shares_a_bit_with(open_world, advance, tmp_path, renderer):
    scene = read_scene(room(tmp_path, "1", "2", "3", "4"))
    assert scene.warnings == ()
    world = open_world(scene, renderer=renderer)
    topics = {mask: world.subscribe(f"/m/s{mask}") for mask in (1, 2, 3, 4)}
    depths = {mask: world.subscribe(f"/m/s{mask}/depth_image") for mask in topics}
    advance(world, 0.05)
    for mask, images in topics.items():
        left, right = (np.asarray(images.latest.message.data).reshape(16, 16, 3)[8, at] for at in (4, 11))
        assert (left.tolist() == [255, 0, 0]) == bool(mask & 1)
        assert (right.tolist() == [0, 255, 0]) == bool(mask & 2)
        seen = np.isfinite(np.asarray(depths[mask].latest.message.data)[8, [4, 11]])
        assert seen.tolist() == [bool(mask & 1), bool(mask & 2)]


def test_a_visual_without_flags_is_hidden_from_every_camera(open_world, advance, tmp_path):
    path = room(tmp_path, "0xFFFFFFFF", "1")
    path.write_text(path.read_text().replace("<visibility_flags>0x1<", "<visibility_flags>0<"))
    world = open_world(read_scene(path))
    topics = [world.subscribe(f"/m/s{mask}") for mask in ("0xFFFFFFFF", 1)]
    advance(world, 0.05)
    for images, right_hand in zip(topics, ([0, 255, 0], [178] * 3), strict=True):
        left, right = images.latest.message.data[8, [4, 11]].tolist()
        assert (left, right) == ([178] * 3, right_hand)


def test_a_mask_that_is_not_a_number_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(SceneError, match="<visibility_mask>"):
        read_scene(room(tmp_path, "all"))
