"""The number of Python calls in a step of the loop, and of calls from one module to another.

The robot of the Braitenberg experiment, with its brain, functions and events, takes steps in which its
camera takes an image by the ``raster`` renderer. Counted are the frames of functions that belong to this
project, and those of them whose caller belongs to another module. The frames under ``World`` are those of
its methods, of its switchboard's methods, and of all that they call. Brain and world advance one after the
other, so that no frame is missed. The numbers do not depend on the speed of the machine; of several steps
with an image, the one with the fewest calls is shown.

    python benchmarks/calls.py
    python benchmarks/calls.py --world pybullet --tree
    python benchmarks/calls.py --json
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.world.topics import Subscription

ENGINES = ("mujoco", "pybullet")
WARM_UP_STEPS, STEPS = 20, 30
OURS = ("nrp_core.", "nrp_world_", "nrp_brain_", "nrp_experiments.", "nrp_bibi.")


@dataclass
class Counts:
    """The counts of one step.

    Args:
        calls: frames of this project.
        changes: those whose caller belongs to another module.
        world: those under a method of the world or of its switchboard.
        frames: depth and name of each, in order.
    """

    calls: int = 0
    changes: int = 0
    world: int = 0
    frames: list[tuple[int, str]] = field(default_factory=list)


class Counter:
    """A profiling function that counts what one thread calls."""

    def __init__(self) -> None:
        self.counts = Counts()
        self._modules = [""]
        self._world_from: int | None = None

    def __call__(self, frame: FrameType, event: str, _argument: object) -> None:
        module = str(frame.f_globals.get("__name__", ""))
        if not module.startswith(OURS):
            return
        if event == "call":
            self._enter(module, frame)
        elif event == "return" and len(self._modules) > 1:
            self._modules.pop()
            if self._world_from is not None and len(self._modules) < self._world_from:
                self._world_from = None

    def _enter(self, module: str, frame: FrameType) -> None:
        counts = self.counts
        counts.calls += 1
        counts.changes += module != self._modules[-1]
        self._modules.append(module)
        if self._world_from is None and _is_world(frame):
            self._world_from = len(self._modules)
        counts.world += self._world_from is not None
        counts.frames.append((len(self._modules), f"{module}:{frame.f_code.co_qualname}"))


def _is_world(frame: FrameType) -> bool:
    """Return whether a frame belongs to a method of a world or of its switchboard."""
    kinds = type(frame.f_locals.get("self")).__mro__
    return any(kind.__name__ in ("World", "Switchboard") for kind in kinds)


@contextmanager
def profiled(counter: Counter) -> Iterator[None]:
    """Count what is called in the block."""
    sys.setprofile(counter)
    try:
        yield
    finally:
        sys.setprofile(None)


def measure(engine: str) -> Counts:
    """Return the counts of a step with an image."""
    changes = [f"world.backend={engine}", "world.options.renderer=raster"]
    with Run(load_experiment("braitenberg_husky", changes)) as run:
        run.loop._coupled._concurrent = False
        images = run.world.subscribe("/husky/camera")
        for _ in range(WARM_UP_STEPS):
            run.step()
        return min(_steps(run, images), key=lambda counts: counts.calls)


def _steps(run: Run, images: Subscription) -> Iterator[Counts]:
    for _ in range(STEPS):
        before, counter = images.latest, Counter()
        with profiled(counter):
            run.step()
        if images.latest is not before:
            yield counter.counts


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--world", choices=ENGINES, action="append", help="by default all")
    parser.add_argument("--tree", action="store_true", help="show every frame")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    found = {engine: measure(engine) for engine in options.world or ENGINES}
    if options.json:
        print(json.dumps({engine: _numbers(counts) for engine, counts in found.items()}))
        return
    print(f"{'engine':<10} {'calls':>6} {'changes of module':>18} {'under World':>12}")
    for engine, counts in found.items():
        print(f"{engine:<10} {counts.calls:>6} {counts.changes:>18} {counts.world:>12}")
        for depth, name in counts.frames if options.tree else ():
            print("  " * (depth - 1) + name)


def _numbers(counts: Counts) -> dict[str, Any]:
    return {"calls": counts.calls, "changes": counts.changes, "world": counts.world}


if __name__ == "__main__":
    main()
