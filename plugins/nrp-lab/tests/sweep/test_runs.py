"""Sweeps on real engines and real schedulers: the same numbers wherever they ran, and whatever was killed."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest
from golden import Golden
from nrp_lab.sweep.executor import LocalExecutor, executor
from nrp_lab.sweep.measuring import RunCache, perform
from nrp_lab.sweep.model import read_sweep
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.record import Record
from nrp_lab.sweep.running import Progress, SweepRun, sweep
from nrp_lab.sweep.slurm import JOBS, emit
from nrp_lab.sweep.table import VARYING, Row

import nrp_core
from nrp_core import Run, load_experiment

BRAIN = """
import nrp_core.pynn as sim
sim.setup(timestep=1.0)
circuit = sim.Population(2, sim.IF_curr_exp(i_offset=sim.parameter("current", 1.0)), label="circuit")
"""
DRIVE = """
steps = 0

@nrp.MapSpikeSource("noise", nrp.brain.circuit[0], nrp.poisson, weight=4.0, rate=200.0)
@nrp.MapSpikeSink("cells", nrp.brain.circuit, nrp.population_rate)
@nrp.Neuron2Robot(Topic("/pioneer/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, noise, cells):
    global steps
    steps += 1
    return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(0.02 * cells.rate + 0.05 * steps))
"""
TEXTS = """
import os

class Fatal(str):
    def __reduce__(self):
        return read, (str(self),)

def read(text):
    if os.getpid() == {pid}:
        return Fatal(text)
    times, _, text = text.partition(" ")
    if len(os.listdir("{marks}")) >= int(times):
        return text
    open("{marks}/%d" % os.getpid(), "x")
    os._exit(1)
"""
DEADLY = """steps += 1
    if t > 0.41:
        __import__("os").kill(__import__("os").getpid(), 9)"""
EXPERIMENT = """
extends: slalom_pioneer
name: noisy
duration: 400 ms
brain: {model: brain.py}
transfer_functions: [drive.py]
topics: null
criteria:
  touches_nothing: null
  gets_through: null
  gets_away: {stays_within: {model: pioneer, distance: 1 m, of: [-8, 0]}}
"""
SWEEP = """
experiment: noisy.yaml
vary:
  brain.parameters.current: [0.8, 1.2]
  seed: SEEDS
measure: [criteria, MEASURES]
"""


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    """A sweep of 6 runs with noise, and with a global variable in a file of transfer functions."""
    for name, text in (("brain.py", BRAIN), ("drive.py", DRIVE), ("noisy.yaml", EXPERIMENT)):
        (tmp_path / name).write_text(text)
    return planned(tmp_path, seeds=3)


def planned(folder: Path, seeds: int, measures: str = "time_to_event") -> Plan:
    text = SWEEP.replace("SEEDS", str([*range(1, seeds + 1)])).replace("MEASURES", measures)
    (folder / "sweep.yaml").write_text(text)
    return Plan.of(*read_sweep(folder / "sweep.yaml"))


def made_alone(plan: Plan, count: int | None = None) -> list[str]:
    """Return the digests of the first runs, each made by itself."""
    tasks = [run.task for run in plan.runs[:count]]
    return [nrp_core.run(task.experiment, task.overrides).trajectory_digest for task in tasks]


def test_runs_made_before_an_edit_of_the_experiment_do_not_count_beside_those_made_after_it(
    plan: Plan, tmp_path: Path
) -> None:
    """Of a table that was made while somebody edited a file, every row is of the same experiment."""
    described, brain = tmp_path / "sweep.yaml", tmp_path / "brain.py"

    def edit(progress: Progress) -> None:
        if progress.done == 2:
            brain.write_text(BRAIN + "# edited\n")

    news = r"\d earlier runs do not count: the file .*brain\.py changed"
    with pytest.warns(UserWarning, match=news) as told:
        table = sweep(described, tmp_path / "out", workers=1, on_progress=edit)
    lost = int(str(told[0].message)[0])
    assert lost >= 2
    assert list(table["run"]) == [*range(lost, 6)]
    with pytest.warns(UserWarning, match=news):
        assert len(sweep(described, tmp_path / "out", workers=1)) == 6


def swept(plan: Plan, folder: Path, on: str, workers: int | None = None) -> list[Row]:
    made = SweepRun(plan, folder)
    with executor(on, folder, workers) as where:
        made.run(where)
    return [{key: value for key, value in row.items() if key not in VARYING} for row in made.rows]


def digests(rows: list[Row]) -> list[str]:
    return [row["trajectory_digest"] for row in rows]


def test_the_expected_time_counts_long_runs_and_full_rounds(plan: Plan, tmp_path: Path) -> None:
    made, where = SweepRun(plan, tmp_path / "swept"), LocalExecutor()
    where.workers = 4
    assert made.expected_s(where) is None
    times_s = (1.0, 1.0, 2.0, 8.0, 60.0)  # the longest compiled code, perhaps
    made.records = {f"{i}": Record(f"{i}", i, elapsed_s=one) for i, one in enumerate(times_s)}
    assert made.expected_s(where) == pytest.approx(3.0 * 2)  # 6 runs on 4 processes


@pytest.mark.heavy
def test_runs_are_the_same_alone_in_one_process_and_on_workers_of_dask(plan: Plan, tmp_path: Path) -> None:
    alone = made_alone(plan)
    assert len(set(alone)) == len(alone)
    here = swept(plan, tmp_path / "here", "local", 1)
    assert digests(here) == alone
    assert all(row["complete"] and row["error"] is None for row in here)
    assert swept(plan, tmp_path / "dask", "dask", 2) == here


RANDOMIZE = "{mass: {pioneer/base: {scale: 0.8..1.2}}, sensor_position: {pioneer/.*/.*: {add: -0.01..0.01}}}"


def test_the_table_has_what_was_drawn_for_each_run(plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "noisy.yaml").write_text(EXPERIMENT + f"world: {{randomize: {RANDOMIZE}}}")
    rows = swept(planned(tmp_path, seeds=2), tmp_path / "here", "local", 1)
    masses = {row["seed"]: row["world.randomize.mass.pioneer/base"] for row in rows}
    assert len(set(masses.values())) == len(masses) == 2
    assert all(0.8 <= mass <= 1.2 for mass in masses.values())
    with Run(load_experiment(tmp_path / "noisy.yaml", ["seed=2"])) as run:
        drawn = {(draw.quantity, draw.part): draw.values for draw in run.world.randomized}
        nominal, link = (scene.model("pioneer").link("base") for scene in (
            run.world.nominal, run.world.scene))  # fmt: skip
    assert link.inertial.mass / nominal.inertial.mass == pytest.approx(masses[2], rel=1e-12)
    row = next(row for row in rows if row["seed"] == 2)
    part = next(part for quantity, part in drawn if quantity == "sensor_position")
    moved = [row[f"world.randomize.sensor_position.{part}.{axis}"] for axis in "xyz"]
    assert moved == list(drawn["sensor_position", part])


@pytest.mark.parametrize("wrong", ["keeps the seed", "keeps variables of the file"])
def test_a_worker_that_does_not_start_over_is_noticed(
    plan: Plan, monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    alone = made_alone(plan, 2)

    def reset(run: nrp_core.Run, *, seed: int) -> None:
        run.loop.reset(seed=None if wrong == "keeps the seed" else seed)

    monkeypatch.setattr(nrp_core.Run, "reset", reset)
    found = [perform(run.task).trajectory_digest for run in plan.runs[:2]]
    assert found[0] == alone[0]
    assert found[1] != alone[1]


def test_engines_stay_open_where_only_the_seed_changes(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []
    original = nrp_core.Run.__init__
    monkeypatch.setattr(
        nrp_core.Run,
        "__init__",
        lambda self, *given, **named: (opened.append(1), original(self, *given, **named))[1],
    )
    monkeypatch.setattr("nrp_lab.sweep.measuring.RUN_CACHE", RunCache())
    for run in plan.runs:
        perform(run.task)
    assert len(opened) == 2


def test_metrics_of_a_recording_are_those_of_a_comparison(plan: Plan, tmp_path: Path) -> None:
    from nrp_lab.comparison.shipped_metrics import Distance
    from nrp_lab.comparison.signals import RunSignals

    measured = planned(tmp_path, seeds=2, measures="distance")
    row, *_ = swept(measured, tmp_path / "measured", "local", 1)
    task = measured.runs[0].task
    nrp_core.run(task.experiment, task.overrides, record=tmp_path / "recorded")
    signals = RunSignals(nrp_core.Recording(tmp_path / "recorded"))
    assert row["distance.pioneer"] == Distance().values(signals)["pioneer"]
    assert row["distance.pioneer"] > 0.01


def killed(plan: Plan, folder: Path, times: int, on: str = "local") -> tuple[list[Row], int]:
    """Make a sweep in two processes and kill one of them several times, at random moments."""
    made, stop, kills = SweepRun(plan, folder), Event(), 0
    where: Any = executor(on, folder, 2)

    def pids() -> list[int]:
        if isinstance(where, LocalExecutor):
            return where.pids()
        return [nanny.pid for nanny in where._cluster.workers.values() if nanny.pid]

    def kill() -> None:
        nonlocal kills
        draw, journal, size = random.Random(5), folder / "journal.jsonl", 0
        while kills < times and not stop.wait(draw.uniform(0.05, 0.5)):
            grown = journal.stat().st_size if journal.exists() else 0
            if grown > size and (found := pids()):  # workers that only start end no run, however often
                os.kill(draw.choice(found), signal.SIGKILL)
                kills, size = kills + 1, grown

    with where:
        killer = Thread(target=kill)
        killer.start()
        made.run(where)
        stop.set()
        killer.join()
    return [{k: v for k, v in row.items() if k not in VARYING} for row in made.rows], kills


@pytest.mark.heavy
def test_nothing_is_lost_when_workers_are_killed(plan: Plan, tmp_path: Path) -> None:
    more = planned(tmp_path, seeds=15)
    rows, kills = killed(more, tmp_path / "killed", 2)
    assert kills
    assert rows == swept(more, tmp_path / "whole", "local", 1)


@pytest.mark.heavy
@pytest.mark.slow
@pytest.mark.parametrize("on", ["local", "dask"])
def test_a_thousand_runs_survive_twenty_kills(plan: Plan, tmp_path: Path, on: str) -> None:
    thousand = planned(tmp_path, seeds=500)
    rows, kills = killed(thousand, tmp_path / "killed", 20, on)
    assert kills == 20
    assert [row["run"] for row in rows] == list(range(1000))
    assert not any(row["error"] for row in rows)
    lines = (tmp_path / "killed" / "journal.jsonl").read_text().splitlines()
    assert len(lines) == 1000
    assert rows == swept(thousand, tmp_path / "whole", "local", 1)


@pytest.fixture
def snakemake(tmp_path: Path) -> Path:
    """Snakemake, in an environment of its own."""
    scripts = Path(__file__).parents[4] / "scripts"
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "tools"], check=True)
    tools = tmp_path / "tools" / "bin"
    subprocess.run([scripts / "pip", tools / "python", "-m", "pip", "install", "snakemake"], check=True)
    return tools / "snakemake"


@pytest.mark.heavy
def test_snakemake_goes_on_where_a_job_was_killed(tmp_path: Path, plan: Plan, snakemake: Path) -> None:
    many, folder = planned(tmp_path, seeds=40), tmp_path / "swept"
    SweepRun(many, folder)
    file, _ = emit("snakemake", folder, [run.task for run in many.runs], 1)
    command = [str(one) for one in (snakemake, "--cores", 1, "--snakefile", file, "--directory", folder)]
    journal = folder / "journal.0.jsonl"
    with subprocess.Popen(command) as jobs:
        while not journal.exists() or journal.stat().st_size == 0:
            assert jobs.poll() is None
            time.sleep(0.1)
        subprocess.run(["pkill", "-KILL", "-f", f"nrp_lab.sweep.slurm {JOBS}/0"], check=True)
    assert jobs.returncode == 1
    kept = journal.read_text()
    assert 0 < len(kept.splitlines()) < len(many.runs)
    subprocess.run(command, check=True)
    assert journal.read_text().startswith(kept)
    assert len(journal.read_text().splitlines()) == len(many.runs)
    assert swept(many, folder, "local", 1) == swept(many, tmp_path / "whole", "local", 1)


@pytest.mark.heavy
def test_workers_of_another_version_and_a_missing_scheduler_are_refused(
    plan: Plan, tmp_path: Path, golden: Golden
) -> None:
    other = replace(plan, code={**plan.code, "nrp_core": "0123456789abcdef"})
    with golden.raises(nrp_core.NrpError, match="'nrp_core'"):
        swept(other, tmp_path / "other", "local", 1)
    with golden.raises(nrp_core.NrpError):
        swept(plan, tmp_path / "none", "tcp://127.0.0.1:9")


@pytest.fixture
def fatal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str, int], str]]:
    """Return a function that returns a text which ends the first workers that read it; each leaves a mark."""
    (tmp_path / "marks").mkdir()
    (tmp_path / "texts.py").write_text(TEXTS.format(pid=os.getpid(), marks=tmp_path / "marks"))
    monkeypatch.syspath_prepend(tmp_path)
    texts = import_module("texts")
    yield lambda text, times: texts.Fatal(f"{times} {text}")
    del sys.modules["texts"]


@pytest.mark.heavy
def test_a_worker_of_dask_may_die_before_the_first_run_but_not_have_other_code(
    plan: Plan, tmp_path: Path, fatal: Callable[[str, int], str]
) -> None:
    deadly = {name: fatal(value, 1) for name, value in plan.code.items()}
    rows = swept(replace(plan, code=deadly), tmp_path / "died-once", "dask", 2)
    assert [*(tmp_path / "marks").iterdir()]
    assert rows == swept(plan, tmp_path / "here", "local", 1)
    other = replace(plan, code={**plan.code, "nrp_core": "0123456789abcdef"})
    with pytest.raises(nrp_core.NrpError, match="'nrp_core'"):
        swept(other, tmp_path / "other", "dask", 2)


@pytest.mark.heavy
def test_a_run_is_not_to_blame_for_workers_of_dask_that_die_before_it_begins(
    plan: Plan, tmp_path: Path, fatal: Callable[[str, int], str]
) -> None:
    tasks = [replace(run.task, experiment=fatal(run.task.experiment, 7)) for run in plan.runs[:1]]
    with executor("dask", tmp_path, 1) as where:
        (record,) = where.perform(tasks)
    assert len([*(tmp_path / "marks").iterdir()]) == 7
    assert (record.error, record.attempts) == (None, 1)
    assert [record.trajectory_digest] == made_alone(plan, 1)


@pytest.mark.heavy
@pytest.mark.parametrize("on", ["local", pytest.param("dask", marks=pytest.mark.heavy)])
def test_only_the_run_that_ends_its_workers_fails(plan: Plan, tmp_path: Path, on: str) -> None:
    """Runs that wait behind it die with it, but had not begun."""
    (tmp_path / "drive.py").write_text(DRIVE.replace("steps += 1", DEADLY))
    deadly = planned(tmp_path, seeds=2).runs
    tasks = [run.task for run in deadly]
    tasks[1] = replace(tasks[1], overrides=(*tasks[1].overrides, "duration=500 ms"))
    with executor(on, tmp_path, 2) as where:
        records = {record.index: record for record in where.perform(tasks)}
    assert [index for index, record in records.items() if record.failed] == [1]
    assert records[1].error is not None
    assert "its worker died in each of 5 attempts" in records[1].error
    assert sorted(records) == [0, 1, 2, 3]


# -- SLURM


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cluster of this one machine; as root, with Debian's packages."""
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        pytest.skip("a SLURM cluster is started by root on Debian")
    root = Path(__file__).parents[4]
    subprocess.run([root / "scripts" / "debian-packages", Path(__file__).parent / "apt.txt"], check=True)
    processes = started(tmp_path_factory.mktemp("slurm"))
    try:
        waited = time.monotonic() + 180
        while (
            "idle" not in subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True).stdout
        ):
            assert time.monotonic() < waited, "the SLURM cluster does not start"
            time.sleep(0.2)
        yield
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(30)


def started(folder: Path) -> list[subprocess.Popen[bytes]]:
    """Start the daemons of SLURM with everything they write in one folder."""
    host = os.uname().nodename
    key, socket = folder / "munge.key", folder / "munge.socket"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    config = folder / "slurm.conf"
    config.write_text(
        f"ClusterName=one\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nAuthType=auth/munge\n"
        f"AuthInfo=socket={socket}\nStateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n"
        f"SlurmctldPidFile={folder}/ctld.pid\nSlurmdPidFile={folder}/d.pid\nProctrackType=proctrack/linuxproc\n"
        "TaskPlugin=task/none\nSelectType=select/cons_tres\nReturnToService=2\nSlurmctldPort=16817\n"
        "SlurmdPort=16818\nMpiDefault=none\nSwitchType=switch/none\nSchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0\n"
        f"NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN\n"
        f"PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
    )
    os.environ["SLURM_CONF"] = str(config)
    (folder / "state").mkdir()
    (folder / "spool").mkdir()
    folder.chmod(0o755)
    folder.parent.chmod(0o755)
    files = {"log-file": "munge.log", "pid-file": "munge.pid", "seed-file": "seed"}
    options = [f"--{option}={folder}/{name}" for option, name in files.items()]
    munged = ["munged", "--foreground", "--force", f"--key-file={key}", f"--socket={socket}", *options]
    commands = [munged, ["slurmctld", "-D", "-i"], ["slurmd", "-D", "-N", host]]
    processes = []
    for command in commands:
        with (folder / f"{command[0]}.out").open("wb") as log:
            processes.append(subprocess.Popen(command, stdout=log, stderr=log))
    return processes


@pytest.mark.heavy
def test_a_sweep_on_slurm_gives_the_same_table(slurm: None, plan: Plan, tmp_path: Path) -> None:
    two = planned(tmp_path, seeds=1)
    here = swept(two, tmp_path / "here", "local", 1)
    assert swept(two, tmp_path / "slurm", "slurm", 1) == here
    assert len(list((tmp_path / "slurm").glob("journal.*.jsonl"))) == 2, "both runs were jobs"

    folder = tmp_path / "emitted"
    script, command = emit("slurm", folder, SweepRun(two, folder).pending, 1)
    assert command == f"sbatch {script}"
    subprocess.run(["sbatch", "--wait", script], check=True)
    assert not SweepRun(two, folder).pending, "the submitted job made them all"
    assert swept(two, folder, "local", 1) == here
