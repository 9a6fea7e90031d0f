"""Actions of a robot that is deleted; a file of its own, as the other tests need the arm."""

from __future__ import annotations

from pathlib import Path

from conftest import needs_ros2
from test_ros2_controllers import answers, running


@needs_ros2
def test_goals_of_a_robot_that_is_deleted_are_aborted(tmp_path: Path) -> None:
    with running(tmp_path) as arm:
        found = answers(arm, "delete")
    assert found["deleted"] == [1, 2]  # the bridge goes on; there is no such model
    assert (found["running"], found["late"], found["grip"]) == (6, 6, 6)
