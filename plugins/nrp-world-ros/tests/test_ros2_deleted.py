"""Actions of robots that are deleted and spawned; a file of its own, as the other tests need the arm."""

from __future__ import annotations

from pathlib import Path

import pytest

from conftest import needs_ros2
from test_ros2_controllers import answers, running


@needs_ros2
def test_goals_are_aborted_when_their_robot_is_deleted_and_followed_when_robots_are_spawned(
    tmp_path: Path,
) -> None:
    with running(tmp_path / "experiment") as arm:
        inside, outside = arm.folder / "arm.urdf", tmp_path / "arm.urdf"
        outside.write_text(inside.read_text())
        found = answers(arm, "again", inside.as_uri(), outside.as_uri())
    assert found["deleted"] == [1, 2]  # the bridge goes on; there is no such model
    assert (found["running"], found["late"], found["grip"]) == (6, 6, 6)
    assert (found["arm"], found["second"], found["third"]) == (1, 1, 104)  # ok, ok, NO_RESOURCE
    for robot in ("arm", "second"):
        assert found[f"{robot} reached"]["status"] == 4  # STATUS_SUCCEEDED
        assert found[f"{robot} reached"]["at"] == pytest.approx([0.5, -0.4], abs=0.03)
    assert found["controllers"] == ["follow", "hand"]
    assert found["joints"] == ["j1", "j2", "j3"]
