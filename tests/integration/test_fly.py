"""The fly walks, tastes sugar, stops and feeds, with a brain of any size; without its wiring it does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from nrp_experiments.fly.twin import INHIBITORY, SYNAPSES_PER_CELL, twin

from nrp_core._support.used_files import FilesRead
from nrp_core.experiment.running.result import Result
from nrp_core.recording.figures.room import RoomView
from nrp_core.recording.figures.story import Story
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict
from nrp_core.running import run

SMALL = "brain.parameters.cells=2500"
S = 10**9


def passed(result: Result) -> dict[str, bool | None]:
    return {name: outcome.passed for name, outcome in result.criteria.items()}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    folder = tmp_path_factory.mktemp("fly") / "recording"
    return run("fly", [SMALL], record=folder), folder


def test_the_fly_walks_to_the_sugar_stops_and_feeds(recorded: tuple[Result, Path]) -> None:
    result, _ = recorded
    assert passed(result) == dict.fromkeys(
        ("reaches_the_sugar", "stops_there", "extends_its_proboscis"), True
    )
    assert result.problems == []


def test_its_recording_is_repeated_bit_for_bit(recorded: tuple[Result, Path]) -> None:
    request = ReplayRequest(until_ns=S // 2)
    with FilesRead() as files, Replay(Recording(recorded[1]), request, files=files) as again:
        assert again.verify().verdict is ReplayVerdict.SAME


def test_its_map_is_as_small_as_its_way(recorded: tuple[Result, Path]) -> None:
    view = RoomView.of(Story.of(Recording(recorded[1]), 0.0, 2.0))
    bounds = view.focus()
    assert view.moves
    assert 0.005 < bounds.right - bounds.left < 0.02


def test_a_rewired_fly_walks_over_the_sugar() -> None:
    assert passed(run("fly/rewired", [SMALL])) == {
        "reaches_the_sugar": True,
        "stops_there": False,
        "extends_its_proboscis": False,
    }


def ends(*cells: str) -> dict[str, float]:
    """Return where the fly is after some of its descending cells were activated."""
    driven = ", ".join(f"{{activate: {{cells: {one}, rate: 300 Hz, weight: 15}}}}" for one in cells)
    settings = [SMALL, f"brain.interventions=[{driven}]", "criteria=null", "duration=0.6 s"]
    return dict(run("fly", settings).final_pose["fly"])


def test_descending_cells_steer() -> None:
    assert ends("DNp09", "DNa02_left")["yaw"] > 0.3
    back = ends("MDN")
    assert back["x"] < -0.001
    assert abs(back["yaw"]) < 0.3


@pytest.mark.heavy
def test_a_brain_of_full_size_does_the_same_and_a_rewired_one_does_not() -> None:
    assert all(passed(run("fly")).values())
    assert not passed(run("fly/rewired"))["extends_its_proboscis"]


def test_the_twin_has_the_statistics_of_its_description() -> None:
    network = twin(5000, 7)
    out = np.bincount(np.concatenate([one.pre_index for one in network.projections]), minlength=5000)[131:]
    assert out.mean() == pytest.approx(SYNAPSES_PER_CELL, rel=0.05)
    assert np.log(out).std() == pytest.approx(0.9, rel=0.05)
    inhibitory = next(one for one in network.projections if one.receptor == "inhibitory")
    share = len(np.unique(inhibitory.pre_index[inhibitory.pre_index >= 131])) / len(out)
    assert share == pytest.approx(INHIBITORY, rel=0.1)
    assert twin(5000, 7).digest == network.digest != twin(5000, 8).digest
