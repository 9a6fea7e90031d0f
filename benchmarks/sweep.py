"""The cost of a sweep beyond its runs, and of resuming a long one.

python benchmarks/sweep.py [RUNS]

Runs take about a second. Overhead is the CPU time of this process and its workers over that of the
runs alone, in one process after the engines were compiled; times of the clock mean little on a busy machine.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from conditions import conditions, load

from nrp_core.experiment.model.tree import tree_of
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.sweep.executors.interface import executor
from nrp_core.sweep.journal import JOURNAL
from nrp_core.sweep.plan import Plan
from nrp_core.sweep.reading import sweep_of
from nrp_core.sweep.record import Record
from nrp_core.sweep.running import SweepRun

UNTIL_S = 12.0
LIMIT = 0.05
ROWS = 10_000
"""Rows of the sweep that is resumed."""
ROUNDS = 3


def cpu_s() -> float:
    """Return the CPU time of this process and its children that have ended, s."""
    found = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in found)


def planned(runs: int) -> Plan:
    vary = {"seed": list(range(1, runs + 1))}
    return Plan.of(sweep_of(tree_of({"experiment": "slalom_pioneer", "vary": vary, "until": f"{UNTIL_S} s"})))


def alone_s(runs: int) -> float:
    """Return the CPU time of the same runs in a loop, as they are written by hand, s."""
    began = cpu_s()
    for seed in range(1, runs + 1):
        with Run(load_experiment("slalom_pioneer", [f"seed={seed}"])) as run:
            run.run_until(UNTIL_S)
            run.result()
    return cpu_s() - began


def swept_s(runs: int, folder: Path) -> float:
    """Return the CPU time of a sweep from the file to the tables, s; runs that are made are not repeated."""
    began = cpu_s()
    made = SweepRun(planned(runs), folder)
    with executor("local", folder, 1) as where:
        made.run(where)
    return cpu_s() - began


def resumed_s(folder: Path) -> float:
    """Return the CPU time of taking up a sweep whose runs are all made, s."""
    plan = planned(ROWS)
    SweepRun(plan, folder)
    lines = [Record(run.task.id, run.task.index, state="finished").to_line() for run in plan.runs]
    (folder / JOURNAL).write_text("".join(lines))
    began = time.process_time()
    made = SweepRun(planned(ROWS), folder)
    with executor("local", folder, 1) as where:
        made.run(where)
    return time.process_time() - began


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    print(f"{conditions()}; CPU times of {ROUNDS} rounds of {runs} runs")
    with TemporaryDirectory() as folder:
        alone_s(1)  # compiles, and the next line imports
        swept_s(1, Path(folder) / "first")
        for number in range(ROUNDS):
            swept = Path(folder) / f"swept {number}"
            loop, sweep = alone_s(runs), swept_s(runs, swept)
            fixed = swept_s(runs, swept)
            each = (sweep - fixed) / runs
            resumed = resumed_s(Path(folder) / f"resumed {number}")
            print(
                f"{loop / runs:.3f} s a run in a loop, {each:.3f} s in a sweep: overhead "
                f"{each * runs / loop - 1:+.1%} of at most {LIMIT:.0%}, and {fixed:.2f} s for each sweep; "
                f"{ROWS} rows resumed in {resumed:.2f} s of at most 1 s; {load()}"
            )


if __name__ == "__main__":
    main()
