"""What recording costs: the same run, recorded and not, in turn.

The experiment that ships runs three times in one process, two seconds of simulated time each in turn, in
which a recording is handed to the system several times: as it is, recorded without the camera, and recorded
with it. CPU time; of each round the ratio, of the ratios the median, so that what else the machine does
falls on all three alike.

    python benchmarks/recording.py [SECONDS] [OVERRIDE...]
"""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from nrp_core.experiment.find import load_experiment
from nrp_core.experiment.run import Run
from nrp_core.recording.capsule import Capsule
from nrp_core.recording.layout import MCAP_NAME, Pictures

EXPERIMENT = "braitenberg_husky"
LIMITS = {Pictures.OFF: 0.05, Pictures.EXACT: 0.15}
ROUND_S = 2.0
WARM_UP_S = 1.0
PERIOD_S = 0.02


def spent_s(run: Run, until_s: float) -> float:
    began = time.process_time()
    run.run_until(until_s)
    return time.process_time() - began


def measure(duration_s: float, overrides: list[str]) -> dict[str, list[float]]:
    """Return the CPU seconds of each round, by how it was recorded."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        runs: dict[str, Run] = {}
        for name in ("not", *LIMITS):
            runs[name] = stack.enter_context(Run(load_experiment(EXPERIMENT, overrides)))
        capsules = [Capsule(runs[kept], folder / kept, pictures=kept) for kept in LIMITS]
        for run in runs.values():
            run.run_until(WARM_UP_S)
        rounds = int((duration_s - WARM_UP_S) / ROUND_S)
        spent: dict[str, list[float]] = {name: [] for name in runs}
        for i in range(1, rounds + 1):
            for name, run in runs.items():
                spent[name].append(spent_s(run, WARM_UP_S + i * ROUND_S))
        for capsule in capsules:
            capsule.close("finished")
        sizes = {kept: (folder / kept / MCAP_NAME).stat().st_size for kept in LIMITS}
        print(
            "size: "
            + ", ".join(f"{size / duration_s / 1e3:.0f} kB/s ({kept})" for kept, size in sizes.items())
        )
    return spent


def main(duration_s: float, overrides: list[str]) -> int:
    spent = measure(duration_s, overrides)
    step_us = median(spent["not"]) / (ROUND_S / PERIOD_S) * 1e6
    print(f"a step takes {step_us:.0f} us of CPU time")
    well = True
    for kept, limit in LIMITS.items():
        rounds = zip(spent[kept], spent["not"], strict=True)
        ratio = median(with_it / without for with_it, without in rounds) - 1
        well = well and ratio <= limit
        what = "everything but the camera" if kept is Pictures.OFF else "everything"
        print(f"{what:<26}{ratio:7.1%}, at most {limit:.0%}: {ratio * step_us:.0f} us a step")
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 40.0, sys.argv[2:]))
