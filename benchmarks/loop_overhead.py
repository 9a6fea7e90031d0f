"""The loop's own cost: everything in a step that is neither an engine nor the body of a transfer function.

The paper's two transfer functions run between a mock brain and a mock world, whose own time is taken
off, as is the time that the bodies take when they are called alone. CPU time, best of several runs.

    python benchmarks/loop_overhead.py [STEPS]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import numpy as np
from conditions import print_conditions

from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS, seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import load_transfer_functions
from nrp_core.dsl.testing import MockBrain, MockEngine, MockWorld
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.scene.model import Link, Model, Scene
from nrp_core.world.sensors.camera import Camera

PERIOD_NS = 20 * NS_PER_MS
LIMIT_US = 150.0
REPEATS = 5


def listings() -> list[TransferFunction]:
    folder = Path(experiment.__file__).parent
    files = ("listing1.py", "listing2.py")
    return [function for name in files for function in load_transfer_functions(folder / name)]


class StillEngine(MockEngine):
    """A robot with a camera and a drive that always sees the same red square."""

    def __init__(self) -> None:
        camera = Camera("eye", "/husky/camera", 30.0, horizontal_fov=1.57, width=320, height=240)
        drive = WheelDrive("drive", "/husky/cmd_vel", (), (), separation=0.57, wheel_diameter=0.36)
        husky = Model("husky", (Link("base_link", sensors=(camera,)),), drives=(drive,))
        super().__init__(Scene((husky,)))
        self.image = np.full((240, 320, 3), (90, 100, 110), np.uint8)
        self.image[80:160, 180:290] = (200, 10, 10)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        return self.image.view()


def measure(steps: int) -> dict[str, float]:
    """Return CPU microseconds per step, by activity."""
    brain = MockBrain({"sensors": 5, "other": 1, "actors": 2})
    with ClosedLoop(
        brain, MockWorld(engine=StillEngine()), listings(), period_ns=PERIOD_NS, concurrent=False
    ) as loop:
        loop.run_until(10 * PERIOD_NS)  # warm up: OpenCV loads here
        loop.reset()
        began = time.process_time_ns()
        loop.run_until(steps * PERIOD_NS)
        total_ns = time.process_time_ns() - began
        bodies_ns = sum(body_ns(function, steps) for function in loop.functions)
        sides_ns = loop.account.both_ns
    own_ns = total_ns - sides_ns - bodies_ns
    parts = {"brain and world (mocks)": sides_ns, "bodies": bodies_ns, "the loop's own": own_ns}
    return {name: spent_ns / steps / 1e3 for name, spent_ns in parts.items()}


def body_ns(function: TransferFunction, steps: int) -> int:
    arguments = tuple(function.adapters.values())
    call: Callable[..., object] = function.function
    t = seconds(PERIOD_NS)
    began = time.process_time_ns()
    for _ in range(steps):
        call(t, *arguments)
    return time.process_time_ns() - began


def main(steps: int) -> int:
    print_conditions()
    runs = [measure(steps) for _ in range(REPEATS)]
    best = min(runs, key=lambda run: run["the loop's own"])
    for name, spent_us in best.items():
        print(f"{name:<26}{spent_us:8.1f} us a step")
    share = 100 * best["the loop's own"] / LIMIT_US
    print(f"the loop's own cost is {share:.0f} % of the {LIMIT_US:g} us it may take")
    return 0 if share <= 100 else 1


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 500))
