"""Links of tonnes with turned tensors of inertia move as the formula says."""

from __future__ import annotations

import pytest

from nrp_core.scene.sdf import read_scene

LINK = """<link name="{0}"><pose>{1} 0 1 0 0 0</pose><inertial><mass>1580</mass>
<pose>0.09 0.15 0.08 0.{2} -0.9 1.{2}</pose><inertia><ixx>30617.3</ixx><iyy>35170.9</iyy><izz>17166.1</izz>
</inertia></inertial></link>"""
SLIDER = """<joint name="{0}" type="prismatic"><parent>{1}</parent><child>{2}</child><axis><xyz>0 0 1</xyz>
<limit><lower>-9</lower><upper>9</upper></limit></axis></joint>"""


def test_heavy_links_fall(open_world, advance, tmp_path):
    links = "".join(LINK.format(f"l{number}", number / 7, number) for number in range(4))
    joints = "".join(
        SLIDER.format(f"j{number}", f"l{number - 1}" if number else "world", f"l{number}")
        for number in range(4)
    )
    (tmp_path / "tower.sdf").write_text(
        f'<sdf version="1.9"><world name="w"><model name="tower">{links}{joints}</model></world></sdf>'
    )
    world = open_world(read_scene(tmp_path / "tower.sdf"))
    advance(world, 0.2)
    states = world.joint_states("tower")
    assert sum(states.positions) == pytest.approx(-9.8 * 0.2**2 / 2, rel=0.02)
