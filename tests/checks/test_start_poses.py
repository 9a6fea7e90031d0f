"""Starts are judged with the joints where the experiment starts them."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code

STARTS = (Code.NRP264, Code.NRP291, Code.NRP292, Code.NRP306)
EXPERIMENT = """
name: legs
duration: 1 s
timestep: 20 ms
brain: {{backend: event, model: brain.py}}
world:
  backend: mujoco
  scene: floor.sdf
  robots: {{walker: {{model: walker.sdf, pose: [0, 0, {z}, 0, 0, 0], joints: {joints}}}}}
transfer_functions: []
"""
BRAIN = (
    "import nrp_core.pynn as sim\nsim.setup()\ncells = sim.Population(1, sim.IF_cond_exp(), label='cells')\n"
)
FLOOR = """<sdf version="1.6"><world name="floor"><model name="ground"><static>true</static><link name="link">
  <collision name="all"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model></world></sdf>"""
WALKER = """<sdf version="1.9"><model name="walker">
  <link name="trunk"><inertial><mass>5</mass></inertial>
    <collision name="c"><geometry><box><size>0.4 0.3 0.1</size></box></geometry></collision></link>
  <link name="leg"><inertial><mass>1</mass></inertial><collision name="c"><pose>0 0 -0.25 0 0 0</pose>
    <geometry><box><size>0.05 0.05 0.5</size></box></geometry></collision></link>
  <joint name="hip" type="revolute"><parent>trunk</parent><child>leg</child><axis><xyz>0 1 0</xyz>
    <limit><lower>{low}</lower><upper>3.2</upper></limit></axis></joint></model></sdf>"""
"""A leg of 50 cm that hangs from its trunk."""


def codes(folder: Path, z: float, joints: str = "{}", low: float = -3.2) -> list[Code]:
    (folder / "experiment.yaml").write_text(EXPERIMENT.format(z=z, joints=joints))
    (folder / "brain.py").write_text(BRAIN)
    (folder / "floor.sdf").write_text(FLOOR)
    (folder / "walker.sdf").write_text(WALKER.format(low=low))
    return [one.code for one in validate_file(folder / "experiment.yaml") if one.code in STARTS]


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("z", "hip", "found"),
    [
        (0.5, 0.0, []),  # stands on its leg
        (0.2, 0.0, [Code.NRP291]),  # 30 cm of the leg are in the floor
        (0.06, pi / 2, []),  # sits, with its leg level: 5 cm of trunk below its middle
        (0.06, 0.0, [Code.NRP291]),
        (3.2, 0.0, []),  # 2.7 m above the floor
        (3.2, pi / 2, [Code.NRP306]),  # 3.15 m, as the leg is level
    ],
)
def test_a_start_is_judged_in_its_posture(tmp_path: Path, z: float, hip: float, found: list[Code]) -> None:
    assert codes(tmp_path, z, f"{{hip: {hip}}}") == found


def test_limits_that_exclude_0_are_reported_only_without_a_start(tmp_path: Path) -> None:
    assert codes(tmp_path, 0.5, low=0.1) == [Code.NRP264]
    assert codes(tmp_path, 0.5, "{hip: 0.2}", low=0.1) == []
