"""The cost of a sweep beyond its runs, and of resuming a long one.

    python benchmarks/sweep.py
    python benchmarks/sweep.py --runs 20 --rounds 5 --on local

What a run takes in a sweep is the difference of a long and a short sweep, divided by the difference of their
runs: what a sweep takes once, such as the start of its workers, is shown apart. It is compared with the same
runs in a loop, in one process after the engines were compiled, as they are written by hand. A run takes about
a second. CPU times of this process and its workers; those of the clock mean little on a busy machine.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from conditions import conditions, load
from nrp_lab.sweep.executor import executor
from nrp_lab.sweep.model import sweep_of
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.record import JOURNAL, Record
from nrp_lab.sweep.running import SweepRun

from nrp_core.experiment.model.section import tree_of
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

EXPERIMENT = "slalom_pioneer"
UNTIL_S = 90.0
SHORT = 2
"""Runs of the short sweep."""
LIMIT = 0.05
ROWS = 10_000
"""Rows of the sweep that is resumed."""


def cpu_s() -> float:
    """Return the CPU time of this process and its children that have ended, s."""
    found = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in found)


def planned(runs: int) -> Plan:
    vary = {"seed": list(range(1, runs + 1))}
    return Plan.of(sweep_of(tree_of({"experiment": EXPERIMENT, "vary": vary, "until": f"{UNTIL_S} s"})))


def alone_s(runs: int) -> float:
    """Return the CPU time of a run in a loop, s."""
    began = cpu_s()
    for seed in range(1, runs + 1):
        with Run(load_experiment(EXPERIMENT, [f"seed={seed}"])) as run:
            run.run_until(UNTIL_S)
            run.result()
    return (cpu_s() - began) / runs


def swept_s(runs: int, on: str) -> float:
    """Return the CPU time of a sweep from the file to the tables, with one worker, s."""
    with TemporaryDirectory() as folder:
        began = cpu_s()
        made = SweepRun(planned(runs), Path(folder))
        with executor(on, Path(folder), 1) as where:
            made.run(where)
        return cpu_s() - began


def resumed_s() -> float:
    """Return the CPU time of taking up a sweep whose runs are all made, s."""
    with TemporaryDirectory() as folder:
        plan = planned(ROWS)
        SweepRun(plan, Path(folder))
        lines = [Record(run.task.id, run.task.index, state="finished").to_line() for run in plan.runs]
        (Path(folder) / JOURNAL).write_text("".join(lines))
        began = time.process_time()
        made = SweepRun(planned(ROWS), Path(folder))
        with executor("local", Path(folder), 1) as where:
            made.run(where)
        return time.process_time() - began


def measure(on: str, runs: int, rounds: int) -> None:
    """Print the overhead of an executor, round by round."""
    alone_s(1)  # compiles, and the next line imports
    swept_s(1, on)
    overheads = []
    for _ in range(rounds):
        loop, short, long = alone_s(runs), swept_s(SHORT, on), swept_s(SHORT + runs, on)
        each = (long - short) / runs
        overheads.append(each / loop - 1)
        print(
            f"{on}: {loop:.3f} s a run in a loop, {each:.3f} s in a sweep: {overheads[-1]:+.1%}, and "
            f"{short - SHORT * each:.2f} s for each sweep; {load()}",
            flush=True,
        )
    print(f"{on}: overhead, median of {rounds} rounds: {median(overheads):+.1%} of at most {LIMIT:.0%}")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=10, help="runs by which the sweeps differ")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--on", nargs="+", default=["local", "dask"], help="executors")
    given = parser.parse_args()
    print(conditions())
    for on in given.on:
        measure(on, given.runs, given.rounds)
    times = ", ".join(f"{resumed_s():.2f}" for _ in range(given.rounds))
    print(f"{ROWS} rows resumed in {times} s of at most 1 s; {load()}")


if __name__ == "__main__":
    main()
