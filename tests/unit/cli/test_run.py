"""nrp run: what it prints, records, draws, and the code it exits with."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nrp_core.cli import progress
from nrp_core.experiment.running.run import Run
from nrp_core.recording.recording import Recording
from nrp_core.recording.writing.writer import McapFile

Nrp = Callable[..., Any]
Raising = Callable[[str], str]


def test_a_run_that_passes_says_so_and_exits_with_0(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment)
    assert done.code == 0
    assert "✓ arrives: 1.00 m after 1.51 s" in done.out
    assert "husky ends at x 2.02 m" in done.out
    assert done.out.splitlines()[-1] == "passed"


def test_a_criterion_that_is_not_met_exits_with_1(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment, "-s", "criteria.arrives.near.within=0.1 m")
    assert done.code == 1
    assert "✗ arrives" in done.out
    assert done.out.splitlines()[-1] == "failed: a criterion is not met"


def test_a_run_that_is_cut_short_has_decided_nothing_and_exits_with_0(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment, "--until", "0.1 s")
    assert done.code == 0
    assert "? arrives: not decided" in done.out
    assert done.out.splitlines()[-1] == (
        "not decided: the run ended early (criteria judged up to 0.1 s of 3 s: 2 open)"
    )


def test_json_holds_everything_that_scripts_rely_on(nrp: Nrp, experiment: Path) -> None:
    data = json.loads(nrp("run", experiment, "--seed", 3, "--json").out)
    assert set(data) >= {
        "experiment", "brain", "world", "seed", "sim_time_s", "wall_time_s", "real_time_factor", "steps",
        "duration_s", "state", "complete", "passed", "problems", "criteria", "time_share", "final_pose",
        "trajectory_digest", "spikes", "events",
    }  # fmt: skip
    assert (data["seed"], data["passed"], data["steps"], data["error"]) == (3, True, 150, None)
    assert set(data["time_share"]) == {"brain", "world", "transfer_functions", "engine"}
    assert data["criteria"]["arrives"]["passed"] is True


def test_options_come_from_the_environment_and_the_command_line_wins(
    nrp: Nrp, experiment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NRP_SEED", "11")
    monkeypatch.setenv("NRP_UNTIL", "80ms")
    monkeypatch.setenv("NRP_SET", "timestep=40ms name=driving")
    monkeypatch.setenv("NRP_JSON", "1")
    data = json.loads(nrp("run", experiment).out)
    assert (data["seed"], data["steps"], data["experiment"]) == (11, 2, "driving")
    assert json.loads(nrp("run", experiment, "--seed", 12).out)["seed"] == 12


@pytest.mark.parametrize(
    ("name", "said"), [("NRP_SEDE", "NRP_SEDE is not read; did you mean NRP_SEED?"), ("NRP_LAB", "")]
)
def test_a_misspelt_variable_is_noted(
    nrp: Nrp, experiment: Path, monkeypatch: pytest.MonkeyPatch, name: str, said: str
) -> None:
    monkeypatch.setenv(name, "3")
    done = nrp("run", experiment, "--until", "20ms")
    assert done.code == 0
    assert said in done.err
    assert (name in done.err) is bool(said)


def test_options_of_a_recording_that_is_not_made_are_noted(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment, "--until", "20ms", "--images", "jpeg")
    assert "--images and --snapshots have no effect without --record" in done.err


def test_a_function_that_raises_ends_the_run_and_the_recording_is_complete(
    nrp: Nrp, experiment: Path, tmp_path: Path, raising: Raising
) -> None:
    folder = tmp_path / "recording"
    done = nrp("run", experiment, "-s", raising("1 / 0"), "--record", folder)
    assert done.code == 1
    assert "wrong.py:4: transfer function 'wrong' raised ZeroDivisionError" in done.err
    assert "Traceback" not in done.err
    assert done.out.splitlines()[-1] == "failed at 1.02 s"
    recording = Recording(folder)
    assert recording.complete
    assert (recording.run["state"], recording.run["result"]["sim_time_s"]) == ("failed", 1.02)
    assert max(one.t_ns for one in recording.messages({"/gazebo/model_states"})) == 1_020_000_000


def test_a_failed_run_in_json_holds_the_error_and_the_result(
    nrp: Nrp, experiment: Path, raising: Raising
) -> None:
    done = nrp("run", experiment, "-s", raising("return 5"), "--json")
    data = json.loads(done.out)
    assert done.code == 1
    assert data["error"]["kind"] == "TransferFunctionRaisedError"
    assert data["error"]["t_ns"] == 1_020_000_000
    assert (data["steps"], data["passed"]) == (51, False)


def test_a_function_that_leaves_the_process_ends_the_run_as_an_error(
    nrp_process: Nrp, experiment: Path, raising: Raising
) -> None:
    done = nrp_process("run", experiment, "-s", raising("import os; os._exit(0)"), "--json")
    data = json.loads(done.out)
    assert done.code == 1
    assert data["error"]["kind"] == "TransferFunctionRaisedError"
    assert data["error"]["t_ns"] == 1_020_000_000


@pytest.mark.parametrize("error", [MemoryError(), RuntimeError("can't start new thread")])
def test_a_machine_with_too_little_of_something_is_not_called_a_bug(
    nrp: Nrp, experiment: Path, error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_run: Run, *_arguments: Any) -> None:
        raise error

    monkeypatch.setattr(Run, "run", refuse)
    done = nrp("run", experiment)
    assert done.code == 1
    assert "ulimit" in done.err
    assert "bug" not in done.err


def test_a_full_disk_ends_the_run_with_one_clear_error(
    nrp: Nrp, experiment: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    start = McapFile.flush
    monkeypatch.setattr(McapFile, "is_due", lambda *_: True)
    monkeypatch.setattr(
        McapFile, "flush", lambda file: full() if sum(file.counts.values()) > 50 else start(file)
    )
    done = nrp("run", experiment, "--record", tmp_path / "recording", "--json")
    data = json.loads(done.out)
    assert done.code == 1
    assert data["error"]["message"] == "the recording cannot be written: No space left on device"
    assert 0 < data["steps"] < 30_000
    assert Recording(tmp_path / "recording").run["state"] == "failed"


def test_a_function_in_quarantine_does_not_end_the_run(nrp: Nrp, experiment: Path, raising: Raising) -> None:
    settings = (raising("1 / 0"), "on_error=quarantine", "criteria=null")
    done = nrp("run", experiment, *(word for setting in settings for word in ("-s", setting)), "--json")
    data = json.loads(done.out)
    assert (data["steps"], len(data["failures"]), data["complete"], data["passed"]) == (150, 1, False, None)
    assert done.code == 1


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("run", "nowhere"), 3, "there is no experiment or file 'nowhere'"),
        (("run", "{}", "--brain", "countin"), 4, "did you mean 'counting'?"),
        (("run", "{}", "--brain", "broken"), 4, "pip install --force-reinstall fakes"),
        (("run", "{}", "-s", "timestp=3"), 3, "did you mean 'timestep'? [NRP201]"),
        (("run", "{}", "-s", "timestep=7 us"), 3, "[NRP20"),
        (("run", "{}", "--pace", "fast"), 3, "a pace is 'max', 'realtime' or a factor of at least 0.0001"),
        (("run", "{}", "--until", "5"), 2, "a time needs a unit"),
        (("run", "{}", "--until", "15ms"), 2, "15ms is not a whole number of steps of 20 ms"),
        (("run", "{}", "--until=-1s"), 2, "it cannot stop at -1s"),
        (("run", "{}", "--plot", "figure.gif"), 2, "a figure is a .png, .svg or .pdf file"),
        (("run", "{}", "--plot", "no/such/figure.png"), 2, "the folder does not exist"),
        (("run", "{}", "--record", "{}"), 2, "it exists already"),
        (("run", "{}", "--images", "gif"), 2, "'gif'"),
        (("run", "{}", "--sed", "3"), 2, "--seed"),
        (("run",), 2, "EXPERIMENT"),
    ],
)
def test_each_mistake_has_its_message_and_its_code(
    nrp: Nrp, experiment: Path, arguments: tuple[str, ...], code: int, message: str
) -> None:
    done = nrp(*(argument.format(experiment) for argument in arguments))
    assert done.code == code
    assert message in done.err
    assert "Traceback" not in done.err
    assert done.out == ""


def test_a_mistake_in_the_file_is_found_by_line_and_column(nrp: Nrp, experiment: Path) -> None:
    path = experiment / "experiment.yaml"
    path.write_text(path.read_text().replace("timestep:", "timestp:"))
    done = nrp("run", experiment)
    line = next(i for i, text in enumerate(path.read_text().splitlines(), 1) if "timestp" in text)
    assert done.code == 3
    assert f"error: {path}:{line}:1: " in done.err
    data = json.loads(nrp("run", experiment, "--json").out)["error"]
    assert (data["path"], data["line"], data["column"]) == (str(path), line, 1)
    assert data["findings"][0]["code"] == "NRP201"


def test_usage_errors_are_json_too(nrp: Nrp, experiment: Path) -> None:
    done = nrp("run", experiment, "--until", "5", "--json")
    assert done.code == 2
    assert json.loads(done.out)["error"]["kind"] == "UsageError"


@pytest.mark.parametrize("as_json", [False, True])
def test_ctrl_c_before_the_first_step_is_reported(
    nrp: Nrp, experiment: Path, monkeypatch: pytest.MonkeyPatch, as_json: bool
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Run, "__init__", interrupted)
    done = nrp("run", experiment, *(["--json"] if as_json else []))
    assert done.code == 130
    if as_json:
        assert json.loads(done.out) == {"error": {"kind": "Interrupted", "message": "interrupted"}}
    else:
        assert (done.out, done.err.splitlines()[-1]) == ("", "error: interrupted")


def test_a_mistake_in_the_program_is_one_line_unless_asked_for(
    nrp: Nrp, experiment: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Run, "run", lambda *_: [].pop())
    done = nrp("run", experiment, "--record", tmp_path / "recording")
    assert done.code == 1
    assert "IndexError: pop from empty list; this is a bug in the program" in done.err
    assert "Traceback" not in done.err
    assert Recording(tmp_path / "recording").run["state"] == "failed"
    assert "Traceback" in nrp("--debug", "run", experiment).err


def test_a_figure_is_drawn_without_leaving_a_recording(nrp: Nrp, experiment: Path, tmp_path: Path) -> None:
    figure = tmp_path / "figure.svg"
    done = nrp("run", experiment, "--until", "200ms", "--plot", figure)
    assert done.code == 0
    assert f"figure: {figure}" in done.out
    assert figure.read_text().startswith("<?xml")
    assert "recorded" not in done.out


def test_nothing_but_the_document_reaches_standard_output(
    nrp_process: Nrp, experiment: Path, raising: Raising
) -> None:
    body = "pass\n    print('from Python')\n    import os; os.write(1, b'from C')"
    done = nrp_process("run", experiment, "-s", raising(body), "--until", "40ms", "--json")
    assert json.loads(done.out)["steps"] == 2
    assert "from Python" in done.err
    assert "from C" in done.err


@pytest.fixture
def running(experiment: Path, tmp_path: Path) -> Any:
    """A run in real time that has recorded something already."""
    recording = tmp_path / "recording"
    command = [
        sys.executable,
        "-m",
        "nrp_core",
        "run",
        experiment,
        "--pace",
        "realtime",
        "--record",
        recording,
        "-s",
        "duration=600s",
    ]
    file = recording / "recording.mcap"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen([*map(str, command), "--json"], **pipes) as process:
        while process.poll() is None and not (file.exists() and file.stat().st_size > 5_000):
            time.sleep(0.01)
        yield process, recording
        process.kill()


@pytest.mark.one_of(3)
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_or_a_polite_kill_ends_the_run_cleanly(running: Any, sent: signal.Signals) -> None:
    process, folder = running
    process.send_signal(sent)
    out, _ = process.communicate()
    data = json.loads(out)
    recording = Recording(folder)
    assert process.returncode == 130
    assert data["interrupted"] is True
    assert 0 < data["steps"] < 30_000
    assert recording.complete
    assert recording.run["state"] == "interrupted"
    last_ns = max(one.t_ns for one in recording.messages({"/gazebo/model_states"}))
    assert last_ns == data["steps"] * 20_000_000


@pytest.mark.one_of(3)
@pytest.mark.parametrize("sent", ["TERM", "HUP"])
def test_a_run_in_the_background_of_a_script_is_ended_cleanly(experiment: Path, sent: str) -> None:
    script = f"""
        {sys.executable} -m nrp_core run {experiment} --pace realtime -s duration=600s --record out \\
            > run.txt 2>&1 &
        while [ ! -s out/recording.mcap ] || [ $(stat -c %s out/recording.mcap) -lt 5000 ]; do
            kill -0 $! || exit 99
            sleep 0.05
        done
        kill -INT $!
        sleep 0.1
        kill -{sent} $!
        wait $!
        echo $? > code.txt
    """
    heard = ["env", f"--default-signal={sent}", "sh", "-c", script]  # the tests may run under nohup
    subprocess.run(heard, cwd=experiment, check=True, timeout=120)
    assert (experiment / "code.txt").read_text() == "130\n"
    recording = Recording(experiment / "out")
    assert recording.check().intact
    assert recording.run["state"] == "interrupted"


def test_nohup_keeps_a_run_from_ending_with_its_terminal(experiment: Path) -> None:
    script = (
        f"nohup {sys.executable} -m nrp_core run {experiment} --pace realtime --until 1s --record out & "
        "while [ ! -s out/recording.mcap ]; do kill -0 $! || exit 99; sleep 0.05; done; kill -HUP $!; wait $!"
    )
    done = subprocess.run(
        ["sh", "-c", script], cwd=experiment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert Recording(experiment / "out").run["state"] == "finished"


def test_a_killed_run_leaves_a_recording_that_can_be_read(running: Any) -> None:
    process, folder = running
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    recording = Recording(folder)
    assert not recording.complete
    assert (recording.run["state"], recording.run["result"]) == ("running", None)
    assert len(list(recording.messages({"/gazebo/model_states"}))) > 2


def test_a_brain_script_that_never_ends_is_stopped_with_its_line(nrp, experiment, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE_S", 0.1)
    script = experiment / "brain.py"
    script.write_text(
        "import time\n\nwhile True:\n    try:\n        time.sleep(0.01)\n    except Exception: pass\n"
    )
    done = nrp("run", experiment, "-s", "brain.time_limit=1 s")
    assert done.code == 3
    assert "executing the brain script brain.py; this is the experiment's own code" in done.err
    assert "because code is compiled" not in done.err.partition("executing the brain script")[2]
    assert re.search(
        r"brain\.py:[3-6]: the brain script did not return within 1 s, its brain\.time_limit", done.err
    )


@pytest.mark.heavy
def test_a_script_that_leaves_the_program_is_an_error_with_its_line(
    nrp: Nrp, nrp_process: Nrp, experiment: Path
) -> None:
    for name, code, run in (("brain.py", 3, nrp_process), ("drive.py", 0, nrp)):
        script = experiment / name
        text = script.read_text()
        script.write_text(f"import os\nos._exit({code})\n{text}")
        done = run("run", experiment)
        script.write_text(text)
        assert done.code == 3
        assert f"{name}:2: SystemExit: os._exit({code}) would end the whole program" in done.err


def test_processes_that_a_script_forks_still_end_by_themselves(nrp_process: Nrp, experiment: Path) -> None:
    script = experiment / "brain.py"
    fork = "import os\nif (child := os.fork()) == 0: os._exit(7)\n"
    check = "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
    script.write_text(f"{fork}{check}{script.read_text()}")
    assert nrp_process("run", experiment, "--until", "40ms").code in (0, 1)


def test_a_slow_brain_script_without_a_limit_runs(nrp, experiment):
    script = experiment / "brain.py"
    script.write_text(f"import time\ntime.sleep(0.5)\n{script.read_text()}")
    assert nrp("run", experiment, "-s", "brain.time_limit=200 ms").code == 3
    assert nrp("run", experiment, "-s", "brain.time_limit=off").code == 0


def test_a_run_beyond_the_end_of_the_experiment_is_noted(nrp, experiment):
    done = nrp("run", experiment, "--until", "4s")
    assert "the run went on to 4 s, and the duration of the experiment is 3 s" in done.out
    assert "went on" not in nrp("run", experiment, "--until", "3s").out


def test_every_figure_that_is_asked_for_is_drawn(nrp, experiment, tmp_path):
    one, two = tmp_path / "one.png", tmp_path / "two.svg"
    done = nrp("run", experiment, "--until", "0.1s", "--plot", one, "--plot", two)
    assert f"  figure: {one}\n  figure: {two}\n" in done.out
    assert one.read_bytes().startswith(b"\x89PNG")
    assert "<svg" in two.read_text()
    refused = nrp("run", experiment, "--plot", one, "--overwrite", "--plot", tmp_path / "three.txt")
    assert refused.code != 0
    assert "three.txt" in refused.err
