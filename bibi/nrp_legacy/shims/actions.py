"""``actionlib`` and ``dynamic_reconfigure``: who asks their servers learns that there are none."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.modules import module
from nrp_legacy.shims.smach import State

_LOST = 9
_STATES = {
    "PENDING": 0, "ACTIVE": 1, "PREEMPTED": 2, "SUCCEEDED": 3, "ABORTED": 4, "REJECTED": 5, "PREEMPTING": 6,
    "RECALLING": 7, "RECALLED": 8, "LOST": _LOST,
}  # fmt: skip


class SimpleActionClient:
    """Asks a server that is not there: goals are lost.

    Args:
        graph: of the run.
        name: of the action.
    """

    def __init__(self, graph: Graph, name: str, *_kinds: Any, **_options: Any) -> None:
        graph.warn(f"no server takes the actions '{absolute(name)}': goals for it are lost")

    def wait_for_server(self, *_values: Any, **_options: Any) -> bool:
        """Return that there is no server."""
        return False

    wait_for_result = wait_for_server

    def get_state(self, *_values: Any, **_options: Any) -> int:
        """Return that the goal is lost."""
        return _LOST

    send_goal_and_wait = get_state

    def send_goal(self, *_values: Any, **_options: Any) -> None:
        """Lose a goal."""

    get_result = cancel_goal = cancel_all_goals = stop_tracking_goal = send_goal

    def get_goal_status_text(self) -> str:
        """Return what became of the goal."""
        return "there is no server"


class SimpleActionServer:
    """Serves nobody."""

    def __init__(self, *_values: Any, **_options: Any) -> None:
        """Serve nobody."""

    def start(self, *_values: Any) -> None:
        """Serve nobody."""

    set_succeeded = set_aborted = set_preempted = publish_feedback = accept_new_goal = start
    register_goal_callback = register_preempt_callback = start

    def is_preempt_requested(self) -> bool:
        """Return that nobody asks."""
        return False

    is_active = is_new_goal_available = is_preempt_requested


class SimpleActionState(State):
    """A state whose goal is lost."""

    def __init__(self, graph: Graph, name: str, *_values: Any, **_options: Any) -> None:
        super().__init__(("succeeded", "aborted", "preempted"))
        self._graph, self._name = graph, name

    def execute(self, userdata: Any) -> str:
        SimpleActionClient(self._graph, self._name)
        return "aborted"


class SettingsClient:
    """Keeps settings that nobody reads."""

    def __init__(self, *_values: Any, **_options: Any) -> None:
        self._settings: dict[str, Any] = {}

    def update_configuration(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Take settings."""
        self._settings |= changes
        return self._settings

    def get_configuration(self, *_values: Any, **_options: Any) -> dict[str, Any]:
        """Return the settings that were taken."""
        return self._settings


def action_modules(graph: Graph) -> dict[str, ModuleType]:
    """Return the modules for one experiment."""
    return {
        "actionlib": module(
            "actionlib",
            SimpleActionClient=lambda *values, **options: SimpleActionClient(graph, *values, **options),
            SimpleActionServer=SimpleActionServer,
            GoalStatus=module("GoalStatus", **_STATES),
            SimpleGoalState=module("SimpleGoalState", PENDING=0, ACTIVE=1, DONE=2),
        ),
        "dynamic_reconfigure.client": module("dynamic_reconfigure.client", Client=SettingsClient),
    }
