"""A transfer function that does not return is interrupted: one clear error, or quarantine."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nrp_core._support.time_limit import TimeLimit, TimeLimitExceeded
from nrp_core.cli import app
from nrp_core.errors import ExperimentError, TransferFunctionRaisedError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from tests.shared.profiled import is_profilable

PATIENCE_S = 60.0
QUICK = "function_time_limit=1 s"
WAYS = {
    "computes": "while True: pass",
    "sleeps": "time.sleep(3600)",
    "waits for a lock": "threading.Semaphore(0).acquire()",
    "reads a pipe": "os.read(os.pipe()[0], 1)",
    "catches exceptions": "go_on_whatever(Exception)",
    "catches everything": "go_on_whatever(BaseException)",
}
SOURCE = """
import os
import threading
import time


def go_on_whatever(kind):
    while True:
        try:
            time.sleep(0.01)
        except kind:
            pass


@nrp.MapVariable("seen", initial_value=0)
@nrp.Neuron2Robot()
def hangs(t, seen):
    seen.value += 1
    if t > 0.05:
        {way}
"""


@pytest.fixture
def hanging(tmp_path: Path) -> Callable[..., Any]:
    """Return a function that loads the shipped experiment with a function that hangs in its third step."""

    def load(way: str, *overrides: str) -> Any:
        path = tmp_path / "hangs.py"
        path.write_text(SOURCE.format(way=WAYS[way]))
        settings = ("world.options.image_scale=0.1", QUICK, "duration=0.2 s", "criteria=null", *overrides)
        experiment = load_experiment("braitenberg_husky", settings)
        return experiment.model_copy(update={"transfer_functions": (*experiment.transfer_functions, path)})

    return load


@pytest.mark.one_of(6)
@pytest.mark.parametrize("way", WAYS)
def test_a_function_that_hangs_ends_the_run_with_one_error_that_names_it(
    hanging: Callable[..., Any], way: str, tmp_path: Path
) -> None:
    with Run(hanging(way)) as run:
        recording_folder = RecordingFolder(run, tmp_path / "recording")
        with pytest.raises(TransferFunctionRaisedError) as caught:
            run.run()
        recording_folder.close("failed")
        assert run.loop.steps == 3
    first, second = str(caught.value).splitlines()[:2]
    place, said = first.split(": ", 1)
    path, line = place.rsplit(":", 1)
    assert Path(path) == tmp_path / "hangs.py"
    assert int(line) in (range(8, 13) if "catches" in way else (20,))
    assert said == ("transfer function 'hangs' did not return within 1 s, its function_time_limit")
    assert second == "  in step 3, at 0.06 s, with"
    recording = Recording(tmp_path / "recording")
    assert recording.complete
    assert sum(1 for _ in recording.messages({"/gazebo/model_states"})) == 4


@pytest.mark.one_of(8)
@pytest.mark.parametrize("way", WAYS)
def test_with_quarantine_a_function_that_hangs_is_set_aside(hanging: Callable[..., Any], way: str) -> None:
    with Run(hanging(way, "on_error=quarantine")) as run:
        run.run()
        result = run.result()
    assert (result.steps, len(result.failures), result.error) == (10, 1, None)
    assert "did not return within 1 s" in str(result.failures[0])
    assert is_profilable()


def test_in_another_thread_a_function_that_computes_is_interrupted(hanging: Callable[..., Any]) -> None:
    failures: list[BaseException] = []

    def work() -> None:
        with Run(hanging("computes")) as run:
            try:
                run.run()
            except TransferFunctionRaisedError as error:
                failures.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(PATIENCE_S)
    assert not thread.is_alive()
    assert "did not return within 1 s" in str(failures[0])
    assert is_profilable()


def test_the_command_line_says_it_in_one_error(
    hanging: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    hanging("sleeps")
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    command = [
        *("run", "braitenberg_husky", "--json", "--record"),
        *(str(tmp_path / "recording"), "-s", QUICK, "-s", "world.options.image_scale=0.1"),
        *("-s", f"transfer_functions=[{tmp_path / 'hangs.py'}]"),
    ]
    assert app.run_app(command) == 1
    done = capfd.readouterr()
    assert "hangs.py:20: transfer function 'hangs' did not return" in json.loads(done.out)["error"]["message"]
    assert "Traceback" not in done.err
    assert Recording(tmp_path / "recording").run["state"] == "failed"


def test_a_limit_does_not_change_results_and_pauses_do_not_count() -> None:
    digests = set()
    for limit in ("off", "1 s"):
        settings = [f"function_time_limit={limit}", "world.options.image_scale=0.1", "duration=0.4 s"]
        pace = ["pace=0.5"] if limit != "off" else []
        with Run(load_experiment("braitenberg_husky", [*settings, *pace])) as run:
            run.run()
            digests.add(run.result().trajectory_digest)
    assert len(digests) == 1


def test_a_limit_is_a_time_above_0_or_off() -> None:
    for wrong in ("0 s", "-1 s", "30", "never"):
        with pytest.raises(ExperimentError, match="function_time_limit"):
            load_experiment("braitenberg_husky", [f"function_time_limit={wrong}"])
    assert load_experiment("braitenberg_husky").function_time_limit == 60 * 10**9
    assert load_experiment("braitenberg_husky", ["function_time_limit=off"]).function_time_limit is None


# -- the limit itself


def test_many_calls_at_the_edge_of_the_limit_leave_nothing_behind() -> None:
    """What comes too late for a call does not hit what runs after it."""
    for own_thread in (False, True):
        limit, outcomes = TimeLimit(0.02), {"in time": 0, "late": 0}

        def work(limit: TimeLimit = limit, outcomes: dict[str, int] = outcomes) -> None:
            with limit.watching():
                for k in range(60):
                    try:
                        limit.call(_spin, 0.018 + 0.0002 * k)
                        outcomes["in time"] += 1
                    except TimeLimitExceeded:
                        outcomes["late"] += 1
                    _spin(0.003)  # here nothing may come

        if own_thread:
            thread = threading.Thread(target=work)
            thread.start()
            thread.join()
        else:
            work()
        assert outcomes["in time"] + outcomes["late"] == 60


def test_the_watching_thread_ends_with_the_run() -> None:
    limit = TimeLimit(0.02)
    with limit.watching():
        assert any(thread.name == "time limit" for thread in threading.enumerate())
        assert limit.call(lambda: 3) == 3
    until = time.monotonic() + PATIENCE_S
    while limit._watcher is not None:
        assert time.monotonic() < until
        time.sleep(0.01)


def _spin(s: float) -> None:
    until = time.perf_counter() + s
    while time.perf_counter() < until:
        pass
