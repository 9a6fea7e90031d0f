"""What a run can be told from outside: other transfer functions, and which of them run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.control import ControlServer, send_command
from nrp_core.experiment.running.control_commands import commands_of
from nrp_core.experiment.running.run import Run

pytestmark = pytest.mark.usefixtures("fakes")

COUNTS = """
@nrp.MapVariable("total", initial_value=0)
@nrp.Robot2Neuron()
def count(t, total):
    total.value += {}
"""
Told = Callable[..., list[dict[str, Any]]]


@pytest.fixture
def run(drive_to_the_wall: Path) -> Iterator[Run]:
    with Run(load_experiment(drive_to_the_wall, ())) as opened:
        yield opened


@pytest.fixture
def told(run: Run, tmp_path: Path) -> Iterator[Told]:
    """Tells the run to change its functions, through the socket."""
    path = tmp_path / "run.sock"

    def tell_it(add: Path | None = None, **lists: list[str]) -> list[dict[str, Any]]:
        given = {"remove": [], "activate": [], "deactivate": [], **lists}
        found: list[dict[str, Any]] = send_command(path, "functions", add=[str(add)] if add else [], **given)
        return found

    with ControlServer(path, commands_of(run)):
        yield tell_it


def counting(folder: Path, by: object) -> Path:
    path = folder / "count.py"
    path.write_text(COUNTS.format(by))
    return path


def test_the_functions_are_listed_with_where_they_stand(run: Run, told: Told) -> None:
    assert [one["name"] for one in told()] == [function.name for function in run.loop.functions]
    assert all(one["active"] and one["failure"] is None for one in told())


def test_a_file_adds_functions_and_later_replaces_them(run: Run, told: Told, tmp_path: Path) -> None:
    run.step()
    told(counting(tmp_path, 1))
    run.run_until(0.06)
    told(counting(tmp_path, 10))
    run.run_until(0.08)
    (count,) = (function for function in run.loop.functions if function.name == "count")
    assert count.total.value == 12
    told(remove=["count"])
    assert "count" not in [one["name"] for one in told()]


def test_a_function_rests_and_runs_again(run: Run, told: Told, tmp_path: Path, golden: Golden) -> None:
    told(counting(tmp_path, 1), deactivate=["count"])
    run.step()
    for both in (["activate", "deactivate"], ["remove", "activate"]):
        with golden.raises(ExperimentError, match="'count'"):
            told(**{one: ["count"] for one in both})
    told(activate=["count", "count"])
    run.step()
    (count,) = (function for function in run.loop.functions if function.name == "count")
    assert count.total.value == 1


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (COUNTS.format("1 +"), r"count.py:\d+.*not Python"),
        (COUNTS.format(1).replace('"total"', '"totl"'), "no parameter 'totl'"),
        (
            "@nrp.MapSpikeSink('x', nrp.brain.nothing, nrp.poisson)\n@nrp.Robot2Neuron()\ndef f(t, x): pass",
            "poisson",
        ),
        (None, ""),
    ],
    ids=["syntax", "parameter", "device", "file"],
)
def test_a_file_that_is_wrong_changes_nothing(
    run: Run, told: Told, tmp_path: Path, text: str | None, error: str, golden: Golden
) -> None:
    before = told()
    path = tmp_path / "count.py"
    if text is not None:
        path.write_text(text)
    with golden.raises(ExperimentError, match=error):
        told(path)
    assert told() == before
    run.step()


def test_the_message_on_an_unknown_name_suggests_the_nearest(
    told: Told, tmp_path: Path, golden: Golden
) -> None:
    told(counting(tmp_path, 1))
    with golden.raises(ExperimentError, match="'cuont'.*'count'"):
        told(deactivate=["cuont"])


def test_a_misspelt_name_beside_a_file_adds_nothing(told: Told, tmp_path: Path, golden: Golden) -> None:
    before = told()
    with golden.raises(ExperimentError, match="'cuont'.*'count'"):
        told(counting(tmp_path, 1), deactivate=["cuont"])
    assert told() == before


def test_a_failed_function_keeps_its_error_until_it_is_replaced(
    drive_to_the_wall: Path, tmp_path: Path
) -> None:
    with Run(load_experiment(drive_to_the_wall, ["on_error=quarantine"])) as run:
        change = commands_of(run)["functions"]
        change([str(counting(tmp_path, "1 / 0"))], [], [], [])
        run.step()
        (failed,) = (one for one in change([], [], [], []) if one["name"] == "count")
        assert not failed["active"]
        assert "ZeroDivisionError" in failed["failure"]
        (mended,) = (
            one for one in change([str(counting(tmp_path, 1))], [], [], []) if one["name"] == "count"
        )
        assert mended["active"]
        assert mended["failure"] is None


def test_functions_that_publish_on_the_same_topic_are_named(run: Run, told: Told, tmp_path: Path) -> None:
    (drive,) = [function for function in run.loop.functions if function.published]
    (topic,) = (published.name for published in drive.published)
    publish = commands_of(run)["publish"]
    assert publish(topic, {"linear": {"x": 1.0}}) == [drive.name]
    assert publish("/wall/body/glass/color", "red") == []
    told(deactivate=[drive.name])
    assert publish(topic, {"linear": {"x": 1.0}}) == []
