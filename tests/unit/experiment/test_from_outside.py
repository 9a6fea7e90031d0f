"""Messages from outside that are never delivered, or that a function replaces at once, are findings."""

from __future__ import annotations

import pytest

from nrp_core import Run, load_experiment
from nrp_core.experiment.running import lost_messages

COMMAND = {"linear": {"x": 0.5}}


def logged(caplog: pytest.LogCaptureFixture) -> list[str]:
    """The messages of the module itself; others log, for example, that kernels are compiled."""
    return [one.getMessage() for one in caplog.records if one.name == lost_messages.__name__]


def lost(run: Run) -> list[str]:
    return [one.message for one in run.problems if one.code.name == "NRP282"]


def test_a_message_after_the_last_step_is_reported_in_the_result_and_at_the_end(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        run.run_until(0.04)
        run.publish("/pioneer/cmd_vel", COMMAND)
        (text,) = lost(run)
        assert "'/pioneer/cmd_vel' was published at 0.04 s, and no step was taken since" in text
    assert logged(caplog) == [text]


def test_a_message_that_has_an_effect_is_not_reported(caplog: pytest.LogCaptureFixture) -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        run.activate("drive", active=False)
        run.publish("/pioneer/cmd_vel", COMMAND)
        run.run_until(0.2)
        assert lost(run) == []
    assert logged(caplog) == []


def test_a_command_that_a_function_replaces_is_reported() -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        run.publish("/pioneer/cmd_vel", COMMAND)
        run.run_until(0.2)
        (text,) = lost(run)
        assert text.startswith(
            "1 message on '/pioneer/cmd_vel' from outside lasted until 'drive' published on it"
        )
        run.activate("drive", active=False)
        run.step()
        assert lost(run) == []


def test_who_publishes_in_each_step_replaces_the_commands_deliberately() -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        for _ in range(6):
            run.publish("/pioneer/cmd_vel", COMMAND)
            run.step()
        assert lost(run) == []
