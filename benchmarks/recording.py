"""The cost of recording: the same run, recorded and not, in turn.

The shipped experiment runs three times in one process: not recorded, recorded without the camera, and
recorded with it. They take turns of half a second of simulated time, in changing order, in which a
recording is flushed several times. The result is the median of the ratios of CPU time in each round; other
programs disturb CPU time less than wall time.

    python benchmarks/recording.py [SECONDS] [OVERRIDE...]
"""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

from conditions import print_conditions

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import MCAP_NAME, Images

EXPERIMENT = "braitenberg_husky"
LIMITS = {Images.OFF: 0.10, Images.EXACT: 0.15}
ROUND_S = 0.5
WARM_UP_S = 1.0
PERIOD_S = 0.02
UNRECORDED = "not"


class Spent(NamedTuple):
    """The duration of a round, s."""

    cpu_s: float
    wall_s: float


Rounds = dict[str, list[Spent]]


def spent(run: Run, until_s: float) -> Spent:
    cpu, wall = time.process_time(), time.perf_counter()
    run.run_until(until_s)
    return Spent(time.process_time() - cpu, time.perf_counter() - wall)


def measure(duration_s: float, overrides: list[str]) -> Rounds:
    """Return the duration of each round, by the kind of recording."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        names = [UNRECORDED, *LIMITS]
        runs = {name: stack.enter_context(Run(load_experiment(EXPERIMENT, overrides))) for name in names}
        folders = [RecordingFolder(runs[kept], folder / kept, images=kept) for kept in LIMITS]
        for run in runs.values():
            run.run_until(WARM_UP_S)
        rounds: Rounds = {name: [] for name in names}
        for i in range(1, int((duration_s - WARM_UP_S) / ROUND_S) + 1):
            for name in (*names[i % 3 :], *names[: i % 3]):
                rounds[name].append(spent(runs[name], WARM_UP_S + i * ROUND_S))
        for recording_folder in folders:
            recording_folder.close("finished")
        sizes = {kept: (folder / kept / MCAP_NAME).stat().st_size for kept in LIMITS}
        print(
            "size: "
            + ", ".join(f"{size / duration_s / 1e3:.0f} kB/s ({kept})" for kept, size in sizes.items())
        )
    return rounds


def added(rounds: Rounds, kept: Images, clock: int) -> float:
    """Return the share that recording adds to the run, by one of the clocks."""
    pairs = zip(rounds[kept], rounds[UNRECORDED], strict=True)
    return median(with_it[clock] / without[clock] for with_it, without in pairs) - 1


def main(duration_s: float, overrides: list[str]) -> int:
    print_conditions()
    rounds = measure(duration_s, overrides)
    step_us = median(one.cpu_s for one in rounds[UNRECORDED]) / (ROUND_S / PERIOD_S) * 1e6
    print(f"a step takes {step_us:.0f} us of CPU time")
    well = True
    for kept, limit in LIMITS.items():
        cpu, wall = added(rounds, kept, 0), added(rounds, kept, 1)
        well = well and cpu <= limit
        what = "everything but the camera" if kept is Images.OFF else "everything"
        print(
            f"{what:<26}{cpu:7.1%} of CPU time, at most {limit:.0%}: {cpu * step_us:.0f} us a step; "
            f"{wall:.1%} of wall time"
        )
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0, sys.argv[2:]))
