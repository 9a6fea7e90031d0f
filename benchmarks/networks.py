"""Networks of 1000 to 50 000 neurons in the event brain, on the grid and exact, in NEST and in Brian2.

All simulators get the same graph and take turns, each in a process of its own, on one thread. CPU seconds
per simulated second without building, warm-up and compiling; the best of all chunks and rounds. NEST and
Brian2 (C++ standalone) run with the interpreters that are given.

    python benchmarks/networks.py
    python benchmarks/networks.py --nest nest-venv/bin/python --brian2 brian2-venv/bin/python --rounds 3
    python benchmarks/networks.py --cases growth
    python benchmarks/networks.py --threads 2

With ``--threads`` the grid alone runs, by one thread and by several in turn: elapsed seconds.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from conditions import print_conditions

PEERS = Path(__file__).parent / "peers"
SHORT = ("--duration", "100", "--chunks", "2", "--warm-up", "50")


@dataclass(frozen=True)
class Case:
    """A network and how it is run: arguments for all, and for a simulator alone."""

    name: str
    model: str
    n: int
    extra: tuple[str, ...] = ()
    exact: bool = False
    only: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


SLOW_NEST = {"nest": ("--duration", "200", "--chunks", "1", "--warm-up", "100")}
CASES = {
    "table": [
        Case("CUBA 4000", "cuba", 4000, exact=True),
        Case("COBA 4000", "coba", 4000, only={"nest": ("--chunks", "1")}),
        Case("Brunel 12500", "brunel", 12500, only=SLOW_NEST),
        Case("Brunel 12500, own weights", "brunel", 12500, ("--weights", "own"), only=SLOW_NEST),
        Case(
            "Brunel 12500, own weights and delays", "brunel", 12500,
            ("--weights", "own", "--delays", "own"), only=SLOW_NEST,
        ),
    ],
    "large": [
        Case(
            "Brunel 50000", "brunel", 50000, SHORT,
            only={"nest": ("--duration", "20", "--chunks", "1", "--warm-up", "20")},
        ),
    ],
    "exact": [
        Case("COBA 4000", "coba", 4000, ("--chunks", "1", "--duration", "300"), exact=True),
        Case("Brunel 1250", "brunel", 1250, ("--chunks", "1", "--duration", "300"), exact=True),
    ],
    "growth": [Case(f"{m} {n}", m, n) for m in ("cuba", "brunel") for n in (1000, 2000, 4000, 8000, 16000)],
}  # fmt: skip


def measured(python: str, script: str, case: Case, *extra: str) -> dict[str, Any]:
    """Run a network in a child process; return its report."""
    call = [python, str(PEERS / script), case.model, "--n", str(case.n), *case.extra, *extra]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(call)} failed:\n{done.stderr[-2000:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def compare(case: Case, interpreters: dict[str, str], rounds: int) -> Iterable[dict[str, Any]]:
    """Run a network in all simulators in turn."""
    modes = ("grid", "exact") if case.exact else ("grid",)
    calls: dict[str, tuple[str, ...]] = {
        **{mode: (sys.executable, "nrp_run.py", "--mode", mode) for mode in modes},
        **{name: (python, f"{name}_run.py") for name, python in interpreters.items()},
    }
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, (python, script, *extra) in calls.items():
            found[name].append(measured(python, script, case, *extra, *case.only.get(name, ())))
    best = {name: min(cost for run in runs for cost in run["costs"]) for name, runs in found.items()}
    for name, runs in found.items():
        checked = case.model != "brunel" and "nest" in found and name in ("grid", "nest")
        yield {
            "network": case.name,
            "simulator": name,
            "s_per_s": round(best[name], 4),
            "faster_than_nest": round(best["nest"] / best[name], 1) if "nest" in best else "-",
            "faster_than_brian2": round(best["brian2"] / best[name], 2) if "brian2" in best else "-",
            "rate_hz": round(runs[0]["rate_hz"], 2),
            "build_s": round(min(run["build_s"] for run in runs), 2),
            "peak_mb": round(min(run["peak_mb"] for run in runs)),
            "bytes_a_synapse": round(runs[0].get("bytes_per_synapse", 0.0), 2) or "-",
            "spikes_as_nest": runs[0]["digest"] == found["nest"][0]["digest"] if checked else "-",
            "rounds": [round(cost, 4) for run in runs for cost in run["costs"]],
        }


def share(case: Case, threads: int, rounds: int) -> Iterable[dict[str, Any]]:
    """Run a network on the grid by one thread and by several in turn."""
    extra = ("--duration", "200", "--chunks", "10", "--threads", str(threads))
    runs = [measured(sys.executable, "nrp_run.py", case, *extra) for _ in range(rounds)]
    one, several = (min(run[name] for run in runs) for name in ("one", "several"))
    yield {
        "network": case.name,
        "threads": threads,
        "one_s_per_s": round(one, 4),
        "several_s_per_s": round(several, 4),
        "faster": round(one / several, 2),
        "same_spikes": all(run["same_spikes"] for run in runs),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--nest", metavar="PYTHON")
    parser.add_argument("--brian2", metavar="PYTHON")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=["table"])
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    print_conditions()
    given = {"nest": arguments.nest, "brian2": arguments.brian2}
    interpreters = {name: python for name, python in given.items() if python}
    n, rounds = arguments.threads, arguments.rounds
    cases = (case for kind in arguments.cases for case in CASES[kind])
    rows = (
        row
        for case in cases
        for row in (share(case, n, rounds) if n > 1 else compare(case, interpreters, rounds))
    )
    for line in map(json.dumps, rows) if arguments.json else table(rows):
        print(line, flush=True)


def table(rows: Iterable[dict[str, Any]]) -> Iterable[str]:
    """Yield the lines of a table as soon as they are known."""
    width: dict[str, int] = {}
    for row in rows:
        if not width:
            width = {"network": 36, **{name: max(len(name), 8) for name in list(row)[1:]}}
            yield "  ".join(f"{name:>{w}}" for name, w in width.items())
        yield "  ".join(f"{row[name]!s:>{w}}" for name, w in width.items())


if __name__ == "__main__":
    main()
