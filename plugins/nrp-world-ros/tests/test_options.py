"""Options of ``nrp ros-bridge`` that contradict each other are refused before ROS is joined."""

from __future__ import annotations

import pytest
import typer
from typer.testing import CliRunner

from nrp_world_ros import command


def refusal(*options: str) -> str:
    """Return the words with which a command line is refused."""
    app = typer.Typer()
    app.command()(command.ros_bridge)
    done = CliRunner().invoke(app, ["braitenberg_husky", *options], env={"COLUMNS": "200", "TERM": "dumb"})
    assert done.exit_code == 2, done.output
    return " ".join(done.output.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--lockstep",), "an experiment with a brain cannot wait for another loop"),
        (("--domain", "3"), "only ROS 2 has domains: add --ros2"),
        (("--without-brain", "--brain", "event"), "--brain: it has no effect with --without-brain"),
        (
            ("--without-brain", "--lockstep", "--pace", "2"),
            "--pace: the other loop decides it with --lockstep",
        ),
        (("--until", "5"), "--until: a time needs a unit: '5 ms' or '5 s'?"),
        (("--until", "-1s"), "--until: a run ends after 0 s, not at -1s"),
    ],
)
def test_options_without_an_effect_are_refused(options: tuple[str, ...], words: str) -> None:
    assert words in refusal(*options)


def test_options_that_fit_each_other_reach_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    joined: list[object] = []

    def join(*_: object, **given: object) -> None:
        joined.append(given)
        raise typer.Exit(7)

    monkeypatch.setattr("nrp_world_ros.joining.join", join)
    app = typer.Typer()
    app.command()(command.ros_bridge)
    for options in (["--without-brain", "--lockstep"], ["--brain", "event", "--pace", "2", "--until", "5s"]):
        assert CliRunner().invoke(app, ["braitenberg_husky", *options]).exit_code == 7
    assert len(joined) == 2
