"""The cortical microcircuit of Potjans and Diesmann (2014), built by PyNN and run on one core, and in NEST.

Each run is a process of its own; simulators take turns, and every round is shown: CPU seconds to build and
for a simulated second, peak memory, and the statistics of the spikes beside the published ones. NEST runs
with the interpreter that is given; without one it is left out.

    python benchmarks/microcircuit.py
    python benchmarks/microcircuit.py --scale 1 --duration 10000 --rounds 1
    python benchmarks/microcircuit.py --nest nest-venv/bin/python --rounds 3
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from conditions import conditions, load

PEERS = Path(__file__).parent / "peers"
COLUMNS = {
    "build_cpu_s": "build, CPU s",
    "to_start_cpu_s": "to the first step, CPU s",
    "s_per_s": "CPU s for a simulated second",
    "peak_mb": "peak, MB",
}


def measured(python: str, script: str, *arguments: str) -> tuple[str, dict[str, Any]]:
    """Run the network in a child process; return its table and its report."""
    call = [python, str(PEERS / script), *arguments]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(call)} failed:\n{done.stderr[-2000:]}")
    *text, report = done.stdout.splitlines()
    found: dict[str, Any] = json.loads(report)
    return "\n".join(text[-9:]), found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scale", type=float, default=0.1)
    parser.add_argument("--duration", type=float, default=1000.0, help="ms")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--nest", metavar="PYTHON")
    asked = parser.parse_args()
    print(conditions())
    scripts = {"nrp-core": (sys.executable, "microcircuit_pynn.py")}
    if asked.nest:
        scripts["NEST"] = (asked.nest, "microcircuit_nest.py")
    given = ("--scale", str(asked.scale), "--duration", str(asked.duration), "--threads", str(asked.threads))
    for number in range(asked.rounds):
        for name, (python, script) in scripts.items():
            table, found = measured(python, script, *given)
            costs = ", ".join(f"{text} {found[key]:.2f}" for key, text in COLUMNS.items())
            print(f"\nround {number + 1}, {name}, {found['synapses']:,d} synapses: {costs}; "
                  f"{load()}\n{table}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
