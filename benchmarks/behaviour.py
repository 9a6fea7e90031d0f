"""Check the behaviour of the Braitenberg Husky on every pair of backends, with many seeds.

Runs the shipped experiment over brains x worlds x gains x order of the screens x seeds, and a minute
without red, and prints how many runs met all criteria, how long the robot took to each screen and how far it
strayed before the first one. The exit code is 1 if a run failed.

    python benchmarks/behaviour.py --seeds 10
    python benchmarks/behaviour.py --seeds 1 --image-scale 0.2
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import sys
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

from conditions import print_conditions

VARIANTS = ("", "/right_first", "/nrp_gains", "/nrp_gains_right_first", "/no_red", "/nrp_gains_no_red")
BRAINS, WORLDS = ("event", "spinnaker"), ("mujoco", "pybullet")


class Case(NamedTuple):
    """One run."""

    variant: str
    brain: str
    world: str
    seed: int
    image_scale: float
    repeat: bool


class Row(NamedTuple):
    """The result of a run."""

    case: Case
    passed: bool
    same_again: bool | None
    to_left_s: float | None
    to_right_s: float | None
    factor: float


def run(case: Case) -> Row:
    """Run one case, or twice to check determinism."""
    from nrp_core.experiment.reading.find import load_experiment
    from nrp_core.experiment.running.run import Run

    settings = [
        f"brain.backend={case.brain}", f"world.backend={case.world}", f"seed={case.seed}",
        f"world.options.image_scale={case.image_scale}",
    ]  # fmt: skip
    experiment = load_experiment(f"braitenberg_husky{case.variant}", settings)
    results = []
    for _ in range(1 + case.repeat):
        with Run(experiment) as simulation:
            simulation.run()
            results.append(simulation.result())
    result = results[0]
    same = (result.trajectory_digest, result.spikes) == (results[-1].trajectory_digest, results[-1].spikes)
    took = {name: outcome.took_s for name, outcome in result.criteria.items()}
    return Row(
        case, bool(result.passed), same if case.repeat else None,
        took.get("reaches_left"), took.get("reaches_right"), result.real_time_factor,
    )  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--image-scale", type=float, default=1.0, help="of the 320x240 camera")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--twice", action="store_true", help="run every case twice and compare bit for bit")
    arguments = parser.parse_args()
    print_conditions()
    cases = [
        Case(variant, brain, world, seed, arguments.image_scale, arguments.twice)
        for variant, brain, world, seed in itertools.product(
            VARIANTS, BRAINS, WORLDS, range(1, arguments.seeds + 1)
        )
    ]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        rows = list(pool.map(run, cases))
    report(rows)
    return 0 if all(row.passed and row.same_again is not False for row in rows) else 1


def report(rows: list[Row]) -> None:
    """Print one line for each variant and pair."""
    groups = defaultdict(list)
    for row in rows:
        groups[row.case.variant.lstrip("/") or "left first", row.case.brain, row.case.world].append(row)
    timed = f"{'to left s':>20}{'to right s':>20}{'x real time':>13}"
    print(f"{'variant':24}{'brain':12}{'world':10}{'passed':>8}{timed}")
    for (variant, brain, world), group in groups.items():
        passed = f"{sum(row.passed for row in group)}/{len(group)}"
        factor = statistics.median(row.factor for row in group)
        left, right = _spread([row.to_left_s for row in group]), _spread([row.to_right_s for row in group])
        print(f"{variant:24}{brain:12}{world:10}{passed:>8}{left:>20}{right:>20}{factor:13.1f}")
    if any(row.same_again is False for row in rows):
        print("NOT deterministic:", [row.case for row in rows if row.same_again is False])
    elif all(row.same_again for row in rows):
        print("every run repeated bit for bit")


def _spread(values: list[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{min(known):.2f} to {max(known):.2f}" if known else "-"


if __name__ == "__main__":
    sys.exit(main())
