"""Worlds without dynamics, each one edit of the minimal world, are found by the tests of exact motion."""

from __future__ import annotations

import sys
from collections.abc import Collection
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests
from nrp_conformance.world.motion import ExactMotionTests

SOURCE = Path(__file__).parents[3] / "plugins/nrp-world-minimal/src/nrp_world_minimal/engine.py"
ARC, ROOM = "a_curve_is_exactly_the_commanded_arc", "a_low_wall_stops_a_robot_and_a_bridge_does_not"
SIDEWAYS, SPEED = "a_planar_drive_moves_exactly_as_commanded", "velocities_are_those_of_the_arc"
BESIDE, CORNER = "a_wall_at_an_angle_leaves_the_room_beside_it", "a_robot_in_a_corner_is_inside_neither_wall"
LONG = "a_robot_ends_at_half_its_length_in_every_heading"
WRONG = {
    "turns 2 % slow": ("angle = self.command.turn", "angle = 0.98 * self.command.turn", f"{ARC} {SPEED}"),
    "forward 2 % slow": ("length = STEP_S", "length = 0.98 * STEP_S", f"{ARC} {SIDEWAYS} {SPEED} {BESIDE}"),
    "turns the other way when backing": (
        "angle = self.command.turn * STEP_S",
        "angle = self.command.turn * (-STEP_S if self.command.forward < 0 else STEP_S)",
        ARC,
    ),
    "robots pass through each other": (
        "if other != name:", "if False:", "robots_do_not_pass_through_each_other"
    ),
    "roll and pitch dropped": (
        "start.position[2]), roll, pitch", "start.position[2]), 0.0, 0.0",
        "a_robot_keeps_its_roll_and_pitch_on_level_ground",
    ),
    "commanded velocity at a wall": (
        "linear = (x - robot.x) / STEP_S, (y - robot.y) / STEP_S, 0.0",
        "linear = robot.command.forward * cos(yaw), robot.command.forward * sin(yaw), 0.0",
        "the_velocity_at_a_wall_is_the_real_one",
    ),
    "fast robots are held back": (
        "length = STEP_S", "length = min(1.0, 1.5 / max(1e-9, abs(self.command.forward))) * STEP_S", ARC
    ),
    "slow robots stand": ("if robot.command == REST", "if abs(robot.command.forward) < 0.03", ARC),
    "footprints do not turn": (
        "return self.corners @ rotation(yaw).T + (x, y)", "return self.corners + (x, y)",
        f"{LONG} {CORNER}",
    ),
    "low walls do not stop": ("CLEARANCE_M = 0.05", "CLEARANCE_M = 0.2", ROOM),
    "walls do not turn": (
        "points_of(collision, place), (place @ collision.pose).yaw)", "points_of(collision, place), 0.0)",
        BESIDE,
    ),
    "one wall at a time": ("ATTEMPTS = 4", "ATTEMPTS = 1", CORNER),
    "what is above stops": ("if o.low < mine.high and o.high", "if o.high", ROOM),
}  # fmt: skip


def failing(old: str, new: str, only: Collection[str] = ()) -> set[str]:
    """Return the tests of exact motion, all or some, that fail for the minimal world with one edit."""
    source = SOURCE.read_text("utf-8")
    assert source.count(old) == 1
    module = sys.modules["wrong_kinematic_world"] = ModuleType("wrong_kinematic_world")
    exec(compile(source.replace(old, new), "wrong_kinematic_world", "exec"), module.__dict__)
    backend: Any = module.__dict__["MinimalBackend"]
    tests = type("Wrong", (ExactMotionTests,), {"make_backend": classmethod(lambda cls: backend())})
    results = run_tests(tests, only, traceback="native")
    assert len(results) == 16 or only
    return {r.test.partition("[")[0] for r in results if r.outcome is Outcome.FAILED}


def test_the_minimal_world_moves_exactly() -> None:
    assert failing("CLEARANCE_M = 0.05", "CLEARANCE_M = 0.05") == set()


def finders(found_by: str) -> set[str]:
    return {f"test_{test}" for test in found_by.split()}


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_kinematic_world_fails_where_it_should(name: str) -> None:
    old, new, found_by = WRONG[name]
    assert failing(old, new, finders(found_by)) == finders(found_by)


@pytest.mark.heavy
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_kinematic_world_fails_nowhere_else(name: str) -> None:
    old, new, found_by = WRONG[name]
    assert failing(old, new) == finders(found_by)
