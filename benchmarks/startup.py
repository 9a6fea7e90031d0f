"""The cost of starting: imports and the first step of a run in fresh interpreters. CPU time, best of several.

python benchmarks/startup.py [REPEATS]
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys

from conditions import print_conditions

LIMIT_MS = 30.0
STARTS = {
    "import nrp_core": LIMIT_MS,
    "import nrp_core.brain, nrp_core.world": LIMIT_MS,
    "from nrp_core import run": None,
    "import sys; sys.argv = ['nrp', '--help']; sys.stdout = open('/dev/null', 'w'); "
    "from nrp_core.cli import main; main()": 200.0,
}

LIBRARIES = "import mujoco, numba, cv2, pydantic, pyNN.core, pyNN.standardmodels.cells, pyNN.connectors"
FIRST_STEP = """
from nrp_core import Run, load_experiment
with Run(load_experiment("braitenberg_husky")) as run:
    run.step()
"""
CHECKED_FIRST_STEP = """
from nrp_core import open_run
with open_run("braitenberg_husky") as run:
    run.step()
"""
COUNT = """
import sys
print(sum(name.partition(".")[0].startswith(("nrp_", "hbp_nrp_")) for name in sys.modules))
"""
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
"""Of the interpreters: modules are compiled once, as those of an installation are."""
MAX_OVER_LIBRARIES, MAX_OVER_RUN, MAX_MODULES = 1.7, 1.2, 450


def best_ms(code: str, repeats: int) -> float:
    times = []
    for _ in range(repeats):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True, env=ENVIRONMENT)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times) * 1e3


def main() -> None:
    print_conditions()
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    bare_ms = best_ms("pass", repeats)
    print(f"a bare interpreter: {bare_ms:.1f} ms; over it:")
    for code, limit_ms in STARTS.items():
        over_ms = best_ms(code, repeats) - bare_ms
        limit = (
            ""
            if limit_ms is None
            else f" (limit {limit_ms:g} ms{', exceeded' if over_ms > limit_ms else ''})"
        )
        print(f"  {over_ms:6.1f} ms  {code[:60]}{limit}")
    print_first_step(repeats)


def print_first_step(repeats: int) -> None:
    """Print what the main experiment costs up to its first step, against its libraries and with a check."""
    libraries_ms, run_ms, checked_ms = (
        best_ms(code, repeats) for code in (LIBRARIES, FIRST_STEP, CHECKED_FIRST_STEP)
    )
    counted = subprocess.run(
        [sys.executable, "-c", FIRST_STEP + COUNT],
        check=True,
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    print(f"the first step of a Run: {run_ms:.0f} ms; import of its libraries: {libraries_ms:.0f} ms")
    for what, value, limit in (
        ("CPU time over that of the libraries", run_ms / libraries_ms, MAX_OVER_LIBRARIES),
        ("open_run over Run", checked_ms / run_ms, MAX_OVER_RUN),
        ("loaded modules of ours", int(counted.stdout), MAX_MODULES),
    ):
        print(f"  {value:6.3g}  {what} (limit {limit:g}{', exceeded' if value > limit else ''})")


if __name__ == "__main__":
    main()
